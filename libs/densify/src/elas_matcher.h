// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/densify/stereo_matcher.h"

namespace cf {

/// Efficient large-scale stereo matching (Geiger, Roser and Urtasun, ACCV 2010), written from the
/// paper: support points, a prior that is linear between them, and for each pixel of both images
/// the most probable of a few disparities.
class ElasMatcher : public StereoMatcher {
 public:
  StereoOutput match(const StereoInput& input) const override;
};

}  // namespace cf
