// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cf/densify/densify.h"
#include "cf/densify/stereo_matcher.h"
#include "cf/geometry/rectification.h"
#include "resample.h"

namespace cf {
namespace {

constexpr double kNearMargin = 0.35;  // of the median depth: trees and roofs without features
constexpr double kFarMargin = 0.15;   // of the median depth
constexpr double kMinMatched = 0.01;  // share of the view's pixels
constexpr int kStrip = 128;           // rows resampled at once: their table stays in the cache
/// A partner was chosen by its overlap at the median depth: relief may leave so much of that.
constexpr double kOverlapLeft = 0.5;
constexpr double kRoundingUp = 0.3;  // reduction by n from n - 0.3 on: aliasing begins before n

/// The photo reduced by an integer factor where the view samples it far below its resolution, so
/// that the remap does not alias.
cv::Mat reduced(const cv::Mat& image, const CameraModel& camera, double f) {
  const double ratio = camera.scaled(image.cols, image.rows).fx / f;
  const int factor = static_cast<int>(ratio + kRoundingUp);
  if (factor < 2) return image;
  cv::Mat out;
  cv::resize(image, out, {image.cols / factor, image.rows / factor}, 0, 0, cv::INTER_AREA);
  return out;
}

struct Rectified {
  cv::Mat image, inside;
};

Rectified rectify(const cv::Mat& image, const CameraModel& camera, const RectifiedView& view) {
  const cv::Mat source = reduced(image, camera, view.f);
  const CameraModel source_camera = camera.scaled(source.cols, source.rows);
  Rectified out;
  out.image.create(view.height, view.width, source.type());
  out.inside.create(view.height, view.width, CV_8U);
  for (int v = 0; v < view.height; v += kStrip) {
    const cv::Range strip(v, std::min(v + kStrip, view.height));
    const RemapTable table = remapTable(view, source_camera, strip);
    resample(source, table, out.image.rowRange(strip));
    table.inside.copyTo(out.inside.rowRange(strip));
  }
  return out;
}

/// Brings the partner's brightness and contrast to the reference's: exposures differ.
void equalise(cv::Mat& partner, const cv::Mat& partner_inside, const cv::Mat& reference,
              const cv::Mat& reference_inside) {
  cv::Scalar mean_r, sigma_r, mean_p, sigma_p;
  cv::meanStdDev(reference, mean_r, sigma_r, reference_inside);
  cv::meanStdDev(partner, mean_p, sigma_p, partner_inside);
  const double gain = sigma_p[0] > 1 ? std::clamp(sigma_r[0] / sigma_p[0], 0.5, 2.0) : 1;
  partner.convertTo(partner, CV_8U, gain, mean_r[0] - gain * mean_p[0]);
}

}  // namespace

cv::Mat referenceColour(const DepthFrame& frame, const cv::Mat& reference_image) {
  return rectify(reference_image, frame.reference_camera, frame.reference_view).image;
}

Result<DepthFrame> matchPair(const DenseView& reference, const cv::Mat& reference_image,
                             const DenseView& partner, const cv::Mat& partner_image,
                             const DensifyOptions& options) {
  if (!(reference.near_depth_m > 0 && reference.far_depth_m >= reference.near_depth_m)) {
    return Failure{"no_depth", "the reference photo has no depth range"};
  }
  // The rectified views are laid out for the decoded images: never above their resolution.
  const PosedCamera a{reference.T_world_cam,
                      reference.camera.scaled(reference_image.cols, reference_image.rows)};
  const PosedCamera b{partner.T_world_cam,
                      partner.camera.scaled(partner_image.cols, partner_image.rows)};
  const double median =
      std::clamp(reference.median_depth_m, reference.near_depth_m, reference.far_depth_m);
  RectificationRequest request;
  request.megapixels = options.megapixels;
  request.min_overlap = kOverlapLeft * options.min_overlap;
  request.near_depth_m = reference.near_depth_m;
  request.far_depth_m = reference.far_depth_m;
  request.search_near_depth_m =
      std::max(reference.near_depth_m - kNearMargin * median, 0.3 * reference.near_depth_m);
  request.search_far_depth_m = reference.far_depth_m + kFarMargin * median;
  const Result<RectifiedPair> pair = rectifyPair(a, b, request);
  if (!pair) return pair.failure();
  if (std::max(-pair->min_disparity_px, pair->max_disparity_px) >= kMostDisparity_px) {
    return Failure{"wide_range", fmt::format("disparities from {} to {} px", pair->min_disparity_px,
                                             pair->max_disparity_px)};
  }

  const Rectified left = rectify(reference_image, reference.camera, pair->reference);
  cv::Mat partner_grey;
  cv::cvtColor(partner_image, partner_grey, cv::COLOR_BGR2GRAY);
  const Rectified right = rectify(partner_grey, partner.camera, pair->partner);
  StereoInput input;
  cv::cvtColor(left.image, input.reference, cv::COLOR_BGR2GRAY);
  input.partner = right.image;
  input.reference_inside = left.inside;
  input.partner_inside = right.inside;
  input.min_disparity_px = pair->min_disparity_px;
  input.max_disparity_px = pair->max_disparity_px;
  equalise(input.partner, input.partner_inside, input.reference, input.reference_inside);

  const StereoOutput match = makeStereoMatcher(options)->match(input);
  const cv::Mat& disparity = match.disparity;
  DepthFrame frame;
  frame.reference = reference.id;
  frame.partner = partner.id;
  frame.reference_view = pair->reference;
  frame.partner_view = pair->partner;
  frame.reference_camera = reference.camera;
  frame.partner_camera = partner.camera;
  frame.T_reference_partner = pair->T_reference_partner;
  // Sub-pixel and coarser levels may reach a little beyond the range.
  const int offset_px = pair->min_disparity_px - 8;
  frame.disparity_offset_px = offset_px;
  frame.confidence = match.confidence;
  frame.colour = left.image;
  frame.disparity.create(disparity.size(), CV_16U);
  int matched = 0;
  for (int v = 0; v < disparity.rows; ++v) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    auto* confidence = frame.confidence.ptr<uchar>(v);
    auto* stored = frame.disparity.ptr<ushort>(v);
    for (int u = 0; u < disparity.cols; ++u) {
      stored[u] = 0;
      const int shifted = d[u] - 16 * offset_px;
      if (confidence[u] < options.min_confidence || shifted < 0 || shifted >= UINT16_MAX) {
        confidence[u] = 0;
        continue;
      }
      stored[u] = static_cast<ushort>(shifted + 1);
      ++matched;
    }
  }
  if (matched < kMinMatched * static_cast<double>(disparity.total())) {
    return Failure{"no_match", fmt::format("{} of {} pixels matched", matched, disparity.total())};
  }
  return frame;
}

}  // namespace cf
