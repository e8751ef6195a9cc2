// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <vector>

#include "disparity_filter.h"
#include "lanes.h"
#include "window_sums.h"

namespace cf {
namespace {

constexpr float kMinSlopeEnergy = 4;  // squared grey levels per px
constexpr float kMaxRefinementPx = 0.75F;
constexpr float kCorrelationNone = 0.2F, kCorrelationFull = 0.9F;
constexpr float kSpread = 16 * 2;  // squared 1/4 px: a variance of the disparities that counts half
constexpr float kLeastEven = 0.2F;     // what is left of the confidence beside a step
constexpr float kTextureSigma = 2.5F;  // grey levels: noise of a photo

constexpr int kKnown = 0;  ///< the first quantity of every window: pixels with a disparity

/// One row of the partner warped onto the reference, in 1/16 grey levels; zero where there is no
/// disparity.
struct WarpedRow {
  explicit WarpedRow(int width)
      : known(static_cast<std::size_t>(width)), left(known), right(known), slope(known) {}

  std::vector<std::int32_t> known;  ///< 1 or 0
  std::vector<std::int32_t> left;   ///< of the reference, about middle grey
  std::vector<std::int32_t> right;  ///< of the partner, about middle grey
  std::vector<std::int32_t> slope;  ///< of the partner, per px

  void warp(const std::int16_t* disparity, const uchar* reference, const uchar* partner,
            int partner_width) {
    for (std::size_t k = 0; k < known.size(); ++k) {
      const int position = 16 * static_cast<int>(k) - disparity[k], x = position >> 4;
      known[k] = left[k] = right[k] = slope[k] = 0;
      if (disparity[k] == kNoDisparity || x < 1 || x + 2 >= partner_width) continue;
      const int t = position & 15;
      const uchar* p = partner + x;
      known[k] = 1;
      left[k] = 16 * (reference[k] - 128);
      right[k] = (16 - t) * p[0] + t * p[1] - 16 * 128;
      slope[k] = ((16 - t) * (p[1] - p[-1]) + t * (p[2] - p[0])) >> 1;
    }
  }
};

CF_CLONES void multiply(const std::int32_t* a, const std::int32_t* b, int n, std::int32_t* out) {
  for (int u = 0; u < n; ++u) out[u] = a[u] * b[u];
}
CF_CLONES void difference(const std::int32_t* a, const std::int32_t* b, const std::int32_t* known,
                          int n, std::int32_t* out) {
  for (int u = 0; u < n; ++u) out[u] = (a[u] - b[u]) * known[u];
}

/// Sums of `quantities` over the window about every pixel: fill(v, row, sums) fills all of them but
/// the first, which counts, for row v of the partner warped onto the reference, and use(v, windows)
/// takes the sums about row v once they are complete.
template <class Fill, class Use>
void eachWindow(int quantities, const cv::Mat& disparity, const StereoInput& input,
                const Fill& fill, const Use& use) {
  const int width = disparity.cols, rows = disparity.rows;
  WindowSums sums(quantities, width);
  WarpedRow row(width);
  std::vector<std::vector<std::int32_t>> windows(
      static_cast<std::size_t>(quantities),
      std::vector<std::int32_t>(static_cast<std::size_t>(width)));
  for (int v = 0; v < rows + WindowSums::kRadius; ++v) {
    if (v < rows) {
      row.warp(disparity.ptr<std::int16_t>(v), input.reference.ptr(v), input.partner.ptr(v),
               input.partner.cols);
      std::copy(row.known.begin(), row.known.end(), sums.begin(kKnown));
      fill(v, row, sums);
    } else {
      for (int q = 0; q < quantities; ++q) sums.fillZero(q);
    }
    sums.push();
    if (v < WindowSums::kRadius) continue;
    for (int q = 0; q < quantities; ++q) sums.sums(q, windows[static_cast<std::size_t>(q)].data());
    use(v - WindowSums::kRadius, windows);
  }
}

/// New disparities of a row from the sums of its windows.
CF_CLONES void refineRow(const std::int32_t* n, const std::int32_t* slope, const std::int32_t* rest,
                         const std::int32_t* slope2, const std::int32_t* product, int width,
                         std::int16_t* disparity) {
  for (int u = 0; u < width; ++u) {
    const auto count = static_cast<float>(std::max(n[u], 1));
    const float mean = static_cast<float>(slope[u]) / count;
    const float energy = static_cast<float>(slope2[u]) / count - mean * mean;
    const float shift = (static_cast<float>(product[u]) - mean * static_cast<float>(rest[u])) /
                        count / std::max(energy, 1.F);
    const bool good = disparity[u] != kNoDisparity && energy >= 256 * kMinSlopeEnergy &&
                      std::abs(shift) <= kMaxRefinementPx;
    const float refined = static_cast<float>(disparity[u]) - 16 * shift;
    const auto rounded = static_cast<std::int16_t>(static_cast<int>(refined + 32768.5F) - 32768);
    disparity[u] = good ? rounded : disparity[u];
  }
}

/// Disparities in 1/4 px, zero where there is none.
CF_CLONES void quarterPixels(const std::int16_t* disparity, const std::int32_t* known, int n,
                             std::int32_t* out) {
  for (int u = 0; u < n; ++u) out[u] = (disparity[u] >> 2) * known[u];
}

CF_CLONES void confidenceRow(const std::int32_t* n, const std::int32_t* left,
                             const std::int32_t* right, const std::int32_t* left2,
                             const std::int32_t* right2, const std::int32_t* product,
                             const std::int32_t* quarters, const std::int32_t* quarters2, int width,
                             const std::int16_t* disparity, uchar* confidence) {
  constexpr float kNoise = 256 * kTextureSigma * kTextureSigma;
  for (int u = 0; u < width; ++u) {
    const auto count = static_cast<float>(std::max(n[u], 1));
    const float share = 1 / count;
    const float ma = static_cast<float>(left[u]) * share;
    const float mb = static_cast<float>(right[u]) * share;
    const float va = std::max(static_cast<float>(left2[u]) * share - ma * ma, 25.F);
    const float vb = std::max(static_cast<float>(right2[u]) * share - mb * mb, 25.F);
    const float correlation =
        (static_cast<float>(product[u]) * share - ma * mb) / __builtin_sqrtf(va * vb);
    const float alike = std::min(1.F, std::max(0.F, (correlation - kCorrelationNone) /
                                                        (kCorrelationFull - kCorrelationNone)));
    const float texture = __builtin_sqrtf(va / (va + kNoise));
    const float whole = std::min(1.F, count * (2.F / (WindowSums::kSide * WindowSums::kSide)));
    const float mean = static_cast<float>(quarters[u]) * share;
    const float spread = static_cast<float>(quarters2[u]) * share - mean * mean;
    const float even = kLeastEven + (1 - kLeastEven) * kSpread / (kSpread + std::max(spread, 0.F));
    const int value = static_cast<int>(255.F * alike * texture * whole * even + 0.5F);
    confidence[u] = static_cast<uchar>(disparity[u] == kNoDisparity ? 0 : value);
  }
}

}  // namespace

void refineDisparity(cv::Mat& disparity, const StereoInput& input) {
  enum { kSlope = kKnown + 1, kRest, kSlope2, kProduct, kCount };
  const int width = disparity.cols;
  eachWindow(
      kCount, disparity, input,
      [&](int, const WarpedRow& row, WindowSums& sums) {
        std::copy(row.slope.begin(), row.slope.end(), sums.begin(kSlope));
        std::int32_t* rest = sums.begin(kRest);
        difference(row.left.data(), row.right.data(), row.known.data(), width, rest);
        multiply(row.slope.data(), row.slope.data(), width, sums.begin(kSlope2));
        multiply(row.slope.data(), rest, width, sums.begin(kProduct));
      },
      [&](int v, const auto& windows) {
        refineRow(windows[kKnown].data(), windows[kSlope].data(), windows[kRest].data(),
                  windows[kSlope2].data(), windows[kProduct].data(), width,
                  disparity.ptr<std::int16_t>(v));
      });
}

cv::Mat confidenceOf(const cv::Mat& disparity, const StereoInput& input) {
  enum { kLeft = kKnown + 1, kRight, kLeft2, kRight2, kProduct, kQuarters, kQuarters2, kCount };
  const int width = disparity.cols;
  cv::Mat confidence(disparity.size(), CV_8U);
  eachWindow(
      kCount, disparity, input,
      [&](int v, const WarpedRow& row, WindowSums& sums) {
        std::copy(row.left.begin(), row.left.end(), sums.begin(kLeft));
        std::copy(row.right.begin(), row.right.end(), sums.begin(kRight));
        multiply(row.left.data(), row.left.data(), width, sums.begin(kLeft2));
        multiply(row.right.data(), row.right.data(), width, sums.begin(kRight2));
        multiply(row.left.data(), row.right.data(), width, sums.begin(kProduct));
        std::int32_t* quarters = sums.begin(kQuarters);
        quarterPixels(disparity.ptr<std::int16_t>(v), row.known.data(), width, quarters);
        multiply(quarters, quarters, width, sums.begin(kQuarters2));
      },
      [&](int v, const auto& windows) {
        confidenceRow(windows[kKnown].data(), windows[kLeft].data(), windows[kRight].data(),
                      windows[kLeft2].data(), windows[kRight2].data(), windows[kProduct].data(),
                      windows[kQuarters].data(), windows[kQuarters2].data(), width,
                      disparity.ptr<std::int16_t>(v), confidence.ptr(v));
      });
  return confidence;
}

}  // namespace cf
