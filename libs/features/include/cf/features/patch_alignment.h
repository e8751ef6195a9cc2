// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace cf {

/// A photo as patches are aligned in it: 8-bit grey, at most `megapixels` large, smoothed a little
/// so that bilinear interpolation does not draw positions towards whole pixels.
/// `photo`: BGR or grey.
cv::Mat greyForAlignment(const cv::Mat& photo, double megapixels);

/// Between pixel centres (whole numbers) of two sizes of one photo, the other `factor` times as
/// large.
Eigen::Vector2d scaledPixel(const Eigen::Vector2d& pixel, double factor);

/// Derivative of the target's normalized plane by the source's around a point that lies in a plane
/// parallel to the source's image; `p_source` in the source's frame, any unit.
Eigen::Matrix2d patchWarp(const Eigen::Isometry3d& T_target_source,
                          const Eigen::Vector3d& p_source);

struct AlignedPatch {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< in the target [px]
  double sigma = 0;  ///< of each coordinate, from the grey values left over [px]
};

/// Where the patch around `at` in `reference` lies in `target`: least-squares matching (Gruen 1985)
/// with an affine warp, gain and offset, by the inverse compositional iteration (Baker & Matthews
/// 2004) from `start` and `A_target_reference`, the derivative of target by reference pixels.
/// Fails at the border, where the patch has no texture, where it comes to lie more than
/// `max_shift` from the start, or where the two do not look alike.
std::optional<AlignedPatch> alignPatch(const cv::Mat& reference, const Eigen::Vector2d& at,
                                       const cv::Mat& target, const Eigen::Vector2d& start,
                                       const Eigen::Matrix2d& A_target_reference, double max_shift);

}  // namespace cf
