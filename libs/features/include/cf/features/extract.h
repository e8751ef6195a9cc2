// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "cf/base/options.h"
#include "cf/types/feature_set.h"
#include "cf/types/image_frame.h"

namespace cf {

struct FeatureOptions {
  double megapixels = 1.0;  ///< size at which features are sought
  int max_features = 4000;  ///< per photo, spread over a grid
  double contrast = 0.01;   ///< SIFT's contrast threshold

  void visit(OptionVisitor& v);
};

/// SIFT (Lowe 2004) with RootSIFT descriptors (Arandjelovic & Zisserman 2012), spread evenly: the
/// strongest blob of each grid cell first; only those chosen are described. The photo is searched
/// at `megapixels` without Lowe's doubling; a smaller photo is enlarged to it, at most twice.
/// `frame.image` must be decoded. Deterministic.
FeatureSet extractFeatures(const ImageFrame& frame, const FeatureOptions& options);

/// The features with the given indices, in that order.
FeatureSet subset(const FeatureSet& features, const std::vector<int>& indices);

}  // namespace cf
