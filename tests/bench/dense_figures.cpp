// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dense_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace cf::bench {
namespace {

constexpr int kStride = 2;             // of the pixels whose errors are kept
constexpr double kClose = 3;           // d, of a depth that counts as found
constexpr double kFlying_m = 1;        // off any surface
constexpr float kNothing = 1e6F;       // depth, for the nearest of a window
constexpr double kStep_m = 1.5;        // least height of a measured step
constexpr double kFlat_m = 0.5;        // greatest relief on its two sides
constexpr int kSide = 6;               // px, of a step's two sides
constexpr int kBins = 8;               // of confidence
constexpr std::size_t kMinInBin = 50;  // samples

struct Spread {
  double median = 0, nmad = 0;
};

double quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

Spread spreadOf(std::vector<float> values) {
  Spread spread;
  spread.median = quantile(values, 0.5);
  for (float& v : values) v = std::abs(v - static_cast<float>(spread.median));
  spread.nmad = 1.4826 * quantile(values, 0.5);
  return spread;
}

/// Nearest and farthest depth within `radius` px.
void depthRange(const cv::Mat& depth, int radius, cv::Mat& nearest, cv::Mat& farthest) {
  const cv::Mat window =
      cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  cv::Mat filled = depth.clone();
  filled.setTo(kNothing, depth <= 0);
  cv::erode(filled, nearest, window);
  cv::dilate(depth, farthest, window);
}

double percent(std::size_t part, std::size_t whole) {
  return whole ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

}  // namespace

ComparedFrame compareFrame(const TruthFlight& flight, const DepthFrame& frame) {
  const TruePhoto& reference = flight.photo(frame.reference);
  const TruePhoto& partner = flight.photo(frame.partner);
  const RectifiedView& view = frame.reference_view;
  ComparedFrame out;
  out.f = view.f;
  out.baseline_m = frame.T_reference_partner.translation().norm();
  const cv::Size size = frame.disparity.size();
  out.truth = cv::Mat::zeros(size, CV_32F);
  out.estimate = cv::Mat::zeros(size, CV_32F);
  out.visible = cv::Mat::zeros(size, CV_8U);
  const TrueDepth& depth = flight.depth(reference);
  const double offset = view.cx - frame.partner_view.cx;
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector3d ray =
          view.R_rect_cam.transpose() *
          Eigen::Vector3d((u - view.cx) / view.f, (v - view.cy) / view.f, 1);
      if (ray.z() <= 0) continue;
      const ushort stored = frame.disparity.at<ushort>(v, u);
      if (stored > 0) {
        const double d = (stored - 1) / 16.0 + frame.disparity_offset_px - offset;
        if (d > 0) {
          out.estimate.at<float>(v, u) = static_cast<float>(view.f * out.baseline_m / d * ray.z());
        }
      }
      const Eigen::Vector2d pixel = frame.reference_camera.project(ray);
      if (!frame.reference_camera.contains(pixel)) continue;
      const double z = depth.at(pixel);
      if (z <= 0) continue;
      out.truth.at<float>(v, u) = static_cast<float>(z);
      const Eigen::Vector3d p =
          reference.T_world_cam * (z * reference.camera.undistort(pixel).homogeneous());
      out.visible.at<uchar>(v, u) = flight.sees(partner, p) ? 255 : 0;
    }
  }
  cv::Mat nearest, farthest;
  depthRange(out.truth, 3, nearest, farthest);
  out.near_step = farthest - nearest > 1;
  return out;
}

void DenseFigures::add(const ComparedFrame& compared, const DepthFrame& frame) {
  cv::Mat nearest, farthest;
  const double centre_z = cv::mean(compared.truth, compared.truth > 0)[0];
  const double d_m = centre_z / compared.f;
  d_m_ += d_m;
  base_to_height_ += compared.baseline_m / centre_z;
  depthRange(compared.truth, static_cast<int>(kFlying_m / d_m), nearest, farthest);
  for (int v = 0; v < compared.truth.rows; ++v) {
    for (int u = 0; u < compared.truth.cols; ++u) {
      const double truth = compared.truth.at<float>(v, u), z = compared.estimate.at<float>(v, u);
      if (truth <= 0) continue;
      ++pixels_;
      const bool visible = compared.visible.at<uchar>(v, u) != 0, valid = z > 0;
      (visible ? visible_ : hidden_) += 1;
      if (!valid) continue;
      ++valid_;
      (visible ? visible_valid_ : hidden_valid_) += 1;
      ++compared_;
      flying_ +=
          z < nearest.at<float>(v, u) - kFlying_m || z > farthest.at<float>(v, u) + kFlying_m;
      const double error = compared.error(v, u);
      visible_close_ += visible && std::abs(error) <= kClose;
      if (v % kStride || u % kStride) continue;
      const double fb = compared.f * compared.baseline_m;  // depths on the optical axis, about
      const double error_px = fb / z - fb / truth;
      const double disparity = fb / truth;
      samples_.push_back({static_cast<float>(error), static_cast<float>(error_px),
                          static_cast<float>(disparity - std::floor(disparity)),
                          frame.confidence.at<uchar>(v, u),
                          compared.near_step.at<uchar>(v, u) != 0});
    }
  }
  addSteps(compared);
}

/// Steps along the rows and columns with flat ground on both sides: how many of the 12 pixels about
/// one have the depth of the wrong side.
void DenseFigures::addSteps(const ComparedFrame& compared) {
  for (const bool along_columns : {false, true}) {
    const cv::Mat truth = along_columns ? cv::Mat(compared.truth.t()) : compared.truth;
    const cv::Mat estimate = along_columns ? cv::Mat(compared.estimate.t()) : compared.estimate;
    const cv::Mat visible = along_columns ? cv::Mat(compared.visible.t()) : compared.visible;
    for (int v = 0; v < truth.rows; v += kStride) {
      const auto* z = truth.ptr<float>(v);
      const auto* e = estimate.ptr<float>(v);
      for (int u = kSide; u + kSide <= truth.cols; ++u) {
        if (!(std::abs(z[u] - z[u - 1]) > kStep_m)) continue;
        const auto [low_a, high_a] = std::minmax_element(z + u - kSide, z + u);
        const auto [low_b, high_b] = std::minmax_element(z + u, z + u + kSide);
        if (*low_a <= 0 || *low_b <= 0 || *high_a - *low_a > kFlat_m || *high_b - *low_b > kFlat_m)
          continue;
        const float middle = (z[u] + z[u - 1]) / 2;
        std::size_t wrong = 0, known = 0;
        for (int k = u - kSide; k < u + kSide; ++k) {
          if (e[k] <= 0) continue;
          ++known;
          wrong += (e[k] > middle) != (z[k] > middle);
        }
        if (known < kSide) continue;
        ++steps_known_;
        ++steps_wrong_[wrong];
      }
    }
  }
}

void DenseFigures::addPair(double cpu_s, bool matched, double megapixels) {
  ++pairs_;
  failed_ += !matched;
  pair_cpu_s_ += cpu_s;
  megapixels_ += megapixels;
}

void DenseFigures::addPhoto(std::size_t seen, std::size_t complete, double cpu_s) {
  ++photos_;
  seen_ += seen;
  complete_ += complete;
  photo_cpu_s_ += cpu_s;
}

std::string DenseFigures::text() const {
  const double n = static_cast<double>(std::max<std::size_t>(1, pairs_ - failed_));
  std::vector<float> all, px, surface, near_step;
  std::size_t within = 0, surface_within = 0;
  for (const Sample& s : samples_) {
    all.push_back(s.error_d);
    px.push_back(s.error_px);
    (s.near_step ? near_step : surface).push_back(s.error_d);
    within += std::abs(s.error_d) <= 1.5F;
    surface_within += !s.near_step && std::abs(s.error_d) <= 1.5F;
  }
  const Spread depth = spreadOf(all), disparity = spreadOf(px), flat = spreadOf(surface);
  std::vector<float> phases[kBins];
  for (const Sample& s : samples_)
    if (!s.near_step)
      phases[std::min(kBins - 1, static_cast<int>(s.phase * kBins))].push_back(s.error_px);
  double low = 1e9, high = -1e9;
  for (const auto& phase : phases) {
    low = std::min(low, quantile(phase, 0.5));
    high = std::max(high, quantile(phase, 0.5));
  }
  std::size_t steps_2 = steps_wrong_[0] + steps_wrong_[1] + steps_wrong_[2];
  std::string out = fmt::format(
      "pairs {} (failed {}), {:.2f} MP each, baseline/depth {:.2f}, d {:.3f} m\n"
      "depth error [d]       NMAD {:.3f}  median {:+.3f}  within 1.5 d {:.2f} %\n"
      "  off steps           NMAD {:.3f}  median {:+.3f}  within 1.5 d {:.2f} %  of {:.1f} %\n"
      "disparity error [px]  NMAD {:.3f}  median {:+.3f}  locking {:.3f}\n"
      "flying (> 1 m off)    {:.3f} %\n"
      "seen by both          {:.2f} % have a depth, {:.2f} % within 3 d\n"
      "hidden from partner   {:.2f} % of the view, {:.2f} % of it with a depth\n"
      "roof edges            {:.1f} % within 2 px, {:.1f} % within 1 px ({} of them)\n"
      "photos                {:.2f} % of what another photo sees within 3 d\n"
      "CPU                   {:.3f} s per pair, {:.3f} s per photo\n",
      pairs_, failed_, megapixels_ / n, base_to_height_ / n, d_m_ / n, depth.nmad, depth.median,
      percent(within, all.size()), flat.nmad, flat.median, percent(surface_within, surface.size()),
      percent(surface.size(), all.size()), disparity.nmad, disparity.median, (high - low) / 2,
      percent(flying_, compared_), percent(visible_valid_, visible_),
      percent(visible_close_, visible_), percent(hidden_, pixels_), percent(hidden_valid_, hidden_),
      percent(steps_2, steps_known_), percent(steps_wrong_[0] + steps_wrong_[1], steps_known_),
      steps_known_, percent(complete_, seen_), pair_cpu_s_ / static_cast<double>(pairs_),
      photo_cpu_s_ / static_cast<double>(std::max<std::size_t>(1, photos_)));
  out += "confidence   share   NMAD d  > 1.5 d    > 3 d\n";
  for (int bin = 0; bin < kBins; ++bin) {
    std::vector<float> errors;
    std::size_t beyond = 0, far = 0;
    for (const Sample& s : samples_) {
      if (s.confidence * kBins / 256 != bin) continue;
      errors.push_back(s.error_d);
      beyond += std::abs(s.error_d) > 1.5F;
      far += std::abs(s.error_d) > 3;
    }
    if (errors.size() < kMinInBin) continue;
    out += fmt::format("{:3d} to {:3d}  {:5.1f} %  {:7.3f}  {:5.1f} %  {:5.1f} %\n",
                       bin * 256 / kBins, (bin + 1) * 256 / kBins - 1,
                       percent(errors.size(), samples_.size()), spreadOf(errors).nmad,
                       percent(beyond, errors.size()), percent(far, errors.size()));
  }
  return out;
}

void drawFrame(const std::filesystem::path& prefix, const ComparedFrame& compared,
               const DepthFrame& frame) {
  double low = 0, high = 0;
  cv::minMaxLoc(compared.truth, &low, &high, nullptr, nullptr, compared.truth > 0);
  const auto write = [&](const char* what, const cv::Mat& image) {
    cv::imwrite(prefix.string() + "_" + what + ".png", image);
  };
  const auto coloured = [&](const cv::Mat& value, double from, double to, const cv::Mat& known,
                            int map) {
    cv::Mat grey, out;
    value.convertTo(grey, CV_8U, 255 / (to - from), -from * 255 / (to - from));
    cv::applyColorMap(grey, out, map);
    out.setTo(cv::Scalar::all(0), known == 0);
    return out;
  };
  write("photo", frame.colour);
  write("truth", coloured(compared.truth, high, low, compared.truth > 0, cv::COLORMAP_TURBO));
  write("depth", coloured(compared.estimate, high, low, compared.estimate > 0, cv::COLORMAP_TURBO));
  write("confidence", frame.confidence);
  const cv::Mat both = (compared.truth > 0) & (compared.estimate > 0);
  cv::Mat error;
  cv::divide(compared.estimate - compared.truth, compared.truth, error, compared.f);
  cv::Mat picture = coloured(error, -3, 3, both, cv::COLORMAP_TWILIGHT_SHIFTED);
  picture.setTo(cv::Scalar(0, 90, 0), (compared.visible == 0) & (compared.estimate <= 0));
  write("error", picture);
}

}  // namespace cf::bench
