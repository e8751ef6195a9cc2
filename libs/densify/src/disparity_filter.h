// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "cf/densify/stereo_matcher.h"

namespace cf {

/// Clears disparities of reference pixels outside their photo, and of matches that land outside the
/// partner's photo.
void clearOutside(cv::Mat& disparity, const StereoInput& input);

/// Clears connected patches of fewer than `min_pixels`; neighbours belong together up to
/// `max_step_px`.
void clearSpeckles(cv::Mat& disparity, int min_pixels, double max_step_px);

/// Fills gaps of at most `max_gap_px` along rows, then columns, between disparities that differ by
/// at most `max_step_px`: linear.
void fillGaps(cv::Mat& disparity, int max_gap_px, double max_step_px);

/// Sub-pixel disparities by one Gauss-Newton step (Lucas and Kanade 1981): the shift of the warped
/// partner, common to a window about each pixel, that explains what is left of the grey difference
/// but for its mean. The census cost alone draws disparities to whole pixels.
void refineDisparity(cv::Mat& disparity, const StereoInput& input);

/// Bilateral mean over the 3 x 3 neighbours that differ by at most `max_step_px` from the centre:
/// smooths noise, keeps steps.
void smoothDisparity(cv::Mat& disparity, double max_step_px);

/// Gives pixels of `disparity` that have none the surface about them in `raw`, the same before its
/// speckles were cleared: the median of an area where enough is known, and enough of it was
/// speckles, and most agrees. For surfaces so rough that their disparities fall into speckles, as
/// tree crowns.
void fillByVote(cv::Mat& disparity, const cv::Mat& raw);

/// Where `fine` has no disparity or a weak one, takes that of `coarse`, half its size, if it is
/// smooth there and lands where nothing nearer hides it in the partner; at a share of its
/// confidence.
void fillFromCoarse(StereoOutput& fine, const StereoOutput& coarse, int partner_width);

/// CV_8UC1, 0..255; 0 where there is no disparity. From how alike the two images are once the
/// partner is warped onto the reference (zero-mean normalized correlation of a window), how much
/// texture the window holds, and how little the disparities vary in it.
cv::Mat confidenceOf(const cv::Mat& disparity, const StereoInput& input);

}  // namespace cf
