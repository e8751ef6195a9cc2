// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cf/base/result.h"

namespace cf {

/// A point of a photo's normalized plane and its inverse depth there.
struct GroundSight {
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();
  double inverse_depth = 0;
};

/// Units of `known` per unit of `measured`, both of one photo, that make both lie on one plane: the
/// inverse depth of a plane is an affine function of the coordinates. Robust: houses and trees may
/// stand on it. Fails where either are few ("few_depths"), or where so much departs from the plane
/// that it does not carry a scale from one part of the photo to the other ("rough_ground").
Result<double> scaleByGround(const std::vector<GroundSight>& known,
                             const std::vector<GroundSight>& measured);

}  // namespace cf
