// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "elas_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "disparity_filter.h"
#include "elas_descriptor.h"
#include "elas_prior.h"
#include "elas_support.h"

namespace cf {
namespace {

// The paper's symbols, for descriptors of 32 values.
constexpr double kBeta = 0.02, kGamma = 3, kSigmaPx = 1;
constexpr int kWithin = 3;  // sigma, about the plane
constexpr int kSpeckle = 80;
constexpr double kSpeckleStepPx = 1;
constexpr int kMaxGap = 5;  // px
constexpr double kMaxGapStepPx = 1;
constexpr int kUnmatched = INT16_MIN;

/// What is left of the energy beside the difference of the descriptors, in its units, by the
/// distance from the plane [1/16 px].
class PriorEnergy {
 public:
  PriorEnergy() {
    for (std::size_t k = 0; k < table_.size(); ++k) {
      const double distance = static_cast<double>(k) / 16;
      const double bell = std::exp(-distance * distance / (2 * kSigmaPx * kSigmaPx));
      table_[k] = static_cast<int>(std::lround(std::log((kGamma + 1) / (kGamma + bell)) / kBeta));
    }
  }
  int operator()(int distance_16) const {
    return table_[std::min(static_cast<std::size_t>(std::abs(distance_16)), table_.size() - 1)];
  }

 private:
  std::array<int, 16 * (kWithin + 1)> table_{};
};

/// One image of the pair, searched in the other: pixel u looks at u - direction * d.
struct Side {
  const DescriptorRow &own, &other;
  int width, other_width;
  int direction;
};

CF_CLONES void matchRow(const Side& side, const std::int16_t* plane, const uchar* inside,
                        const ElasPrior& prior, int v, const PriorEnergy& energy,
                        std::int16_t* out) {
  for (int u = 0; u < side.width; ++u) {
    out[u] = kUnmatched;
    if (!inside[u]) continue;
    const std::uint8_t* own = side.own.values.data() + DescriptorRow::kDense * u;
    int best = kUnmatched, least = std::numeric_limits<int>::max();
    const auto consider = [&](int d, int beyond) {
      const int x = u - side.direction * d;
      if (x < 0 || x >= side.other_width) return;
      const int cost = beyond + difference<DescriptorRow::kDense>(
                                    own, side.other.values.data() + DescriptorRow::kDense * x);
      if (cost >= least) return;
      least = cost;
      best = d;
    };
    int from = 0, to = -1;
    if (plane[u] != kNoDisparity) {
      const int centre = (plane[u] + 8) >> 4;
      from = centre - kWithin;
      to = centre + kWithin;
      for (int d = from; d <= to; ++d) consider(d, energy(16 * d - plane[u]));
    }
    for (const int d : prior.near(u, v)) {
      if (d < from || d > to) consider(d, energy(std::numeric_limits<int>::max()));
    }
    out[u] = static_cast<std::int16_t>(best);
  }
}

/// Reference disparities [1/16 px] that the partner's confirm.
void confirm(const std::int16_t* reference, const std::int16_t* partner, int width,
             int partner_width, std::int16_t* out) {
  for (int u = 0; u < width; ++u) {
    out[u] = kNoDisparity;
    if (reference[u] == kUnmatched) continue;
    const int x = u - reference[u];
    if (x < 0 || x >= partner_width || partner[x] == kUnmatched) continue;
    if (std::abs(partner[x] - reference[u]) <= 1) {
      out[u] = static_cast<std::int16_t>(16 * reference[u]);
    }
  }
}

cv::Mat elasMatch(const StereoInput& input) {
  const SobelImages reference(input.reference), partner(input.partner);
  const std::vector<SupportPoint> points = supportPoints(input, reference, partner);
  std::vector<SupportPoint> partner_points = points;
  for (SupportPoint& p : partner_points) p.u -= p.d;
  const ElasPrior prior(points, reference.size), partner_prior(partner_points, partner.size);
  const PriorEnergy energy;
  cv::Mat disparity(reference.size, CV_16S);
  const int width = reference.size.width, partner_width = partner.size.width;
  DescriptorRow row, partner_row;
  std::vector<std::int16_t> best(static_cast<std::size_t>(width));
  std::vector<std::int16_t> partner_best(static_cast<std::size_t>(partner_width));
  for (int v = 0; v < disparity.rows; ++v) {
    row.makeDense(reference, v);
    partner_row.makeDense(partner, v);
    matchRow({row, partner_row, width, partner_width, 1}, prior.plane.ptr<std::int16_t>(v),
             input.reference_inside.ptr(v), prior, v, energy, best.data());
    matchRow({partner_row, row, partner_width, width, -1}, partner_prior.plane.ptr<std::int16_t>(v),
             input.partner_inside.ptr(v), partner_prior, v, energy, partner_best.data());
    confirm(best.data(), partner_best.data(), width, partner_width, disparity.ptr<std::int16_t>(v));
  }
  return disparity;
}

}  // namespace

StereoOutput ElasMatcher::match(const StereoInput& input) const {
  cv::Mat disparity = elasMatch(input);
  clearOutside(disparity, input);
  clearSpeckles(disparity, kSpeckle, kSpeckleStepPx);
  fillGaps(disparity, kMaxGap, kMaxGapStepPx);
  refineDisparity(disparity, input);
  smoothDisparity(disparity, 1);
  return {disparity, confidenceOf(disparity, input)};
}

}  // namespace cf
