// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "method.h"

namespace cf {
namespace {

constexpr int kRoundsPerKeyframe = 2;
constexpr int kRoundsAtFinish = 12;
constexpr double kSettled = 0.01;  ///< relative change of the noise between rounds

/// The paper's: the scale is a state; the receiver's noise is estimated from the residuals and
/// weighs the fixes; outliers are left out.
class TwoStage : public GeoreferenceMethod {
 public:
  using GeoreferenceMethod::GeoreferenceMethod;

  void update(std::vector<Segment>& segments, std::size_t changed) const override {
    Segment& segment = segments[changed];
    const bool from_scratch = isShort(segment) || !segment.solved;
    if (!fullSolveDue(segment)) {
      predictLast(segment);
      solveOnce(segments, segment, windowStart(segment));
      return;
    }
    // Short segments start afresh: nothing wrong from the first photos can stay.
    if (!from_scratch)
      predictLast(segment);
    else if (!initialise(segment, options()))
      return;
    segment.full_solve_size = segment.nodes.size();
    for (int round = 0; round < kRoundsPerKeyframe; ++round) solveOnce(segments, segment, 0);
  }

  void finish(std::vector<Segment>& segments) const override {
    for (Segment& segment : segments) segment.solved = initialise(segment, options());
    Noise before = weights(segments);
    for (int round = 0; round < kRoundsAtFinish; ++round) {
      for (Segment& segment : segments)
        if (segment.solved) {
          gateFixes(segment, before);
          solve(segment, before, *this, 0);
        }
      const Noise now = weights(segments);
      const double change =
          (now.weighed().cwiseQuotient(before.weighed()).array() - 1).abs().maxCoeff();
      before = now;
      if (change < kSettled) break;
    }
  }

  bool scaleIsState() const override { return true; }

  Increment increment(const Segment& segment, std::size_t j) const override {
    Increment out;
    out.T_i_j = incrementTo(segment, j);
    out.rotation_sigma_rad = options().vo_rotation_sigma_deg * kRadPerDeg;
    const double depth = std::max(segment.nodes[j - 1].median_depth, segment.nodes[j].median_depth);
    out.translation_sigma =
        options().vo_step_sigma * out.T_i_j.translation().norm() + options().vo_depth_sigma * depth;
    // Photos of one place: not more certain than a thousandth of the segment's longest step.
    const double floor = segment.longest_step > 0 ? 1e-3 * segment.longest_step : 1e-3;
    out.translation_sigma = std::max(out.translation_sigma, floor);
    return out;
  }

  Noise weights(const std::vector<Segment>& segments) const override {
    return measuredNoise(segments, options());
  }

  double scaleOf(const Segment& segment) const override { return segment.scale; }

 private:
  void solveOnce(const std::vector<Segment>& segments, Segment& segment,
                 std::size_t first_free) const {
    const Noise now = weights(segments);
    gateFixes(segment, now);
    solve(segment, now, *this, first_free);
  }
};

}  // namespace

std::unique_ptr<GeoreferenceMethod> makeTwoStage(const GeoreferenceOptions& options) {
  return std::make_unique<TwoStage>(options);
}

}  // namespace cf
