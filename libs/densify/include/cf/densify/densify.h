// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "cf/base/options.h"
#include "cf/base/result.h"
#include "cf/types/camera_model.h"
#include "cf/types/depth_frame.h"
#include "cf/types/ids.h"

namespace cf {

/// Section [densify].
struct DensifyOptions {
  double megapixels = 1.5;      ///< of a pair's common area, never above the photos' resolution
  std::string matcher = "sgm";  ///< or "elas", the paper's
  int partners = 2;             ///< of a photo
  double min_baseline_over_depth = 0.05;  ///< of a pair; depth: the reference's median
  double max_baseline_over_depth = 0.8;
  double max_convergence_deg = 40;  ///< between the optical axes
  double min_overlap = 0.2;         ///< share of the reference photo that its partner must see
  int min_confidence = 24;          ///< matches of less are dropped [0..255]

  void visit(OptionVisitor& visitor);
};

/// A photo that can take part in a virtual stereo pair: where it is, and how far its scene is along
/// its optical axis (of its triangulated features: 5th, 50th and 95th percentile). Views of
/// different components have poses that do not fit each other.
struct DenseView {
  FrameId id;
  int component = 0;
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  CameraModel camera;
  double near_depth_m = 0, median_depth_m = 0, far_depth_m = 0;
};

/// Up to options.partners of `others`, best first. What counts is how much of the reference photo
/// a partner adds: a share that no earlier partner sees counts in full, one seen already counts
/// less, least from the same direction; times how well its baseline over depth measures (best
/// between 0.3 and 0.6). Empty when none fits. Photos without depth, or of another component,
/// are never chosen.
std::vector<FrameId> choosePartners(const DenseView& reference,
                                    const std::vector<DenseView>& others,
                                    const DensifyOptions& options);

/// One virtual stereo pair, from rectification to filtered disparity. The images are the decoded
/// BGR photos, possibly reduced. The failures of rectifyPair, and "no_depth" (the reference has no
/// depth range), "wide_range" (its disparities at this size are more than a StereoMatcher tells),
/// "no_match" (nothing passed the checks).
Result<DepthFrame> matchPair(const DenseView& reference, const cv::Mat& reference_image,
                             const DenseView& partner, const cv::Mat& partner_image,
                             const DensifyOptions& options);

/// The colour of a depth frame anew, to the last bit, for one that was kept without: CV_8UC3.
cv::Mat referenceColour(const DepthFrame& frame, const cv::Mat& reference_image);

}  // namespace cf
