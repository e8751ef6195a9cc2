// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "method.h"

namespace cf {
namespace {

/// The baseline: global fusion after Qin et al. 2019 (VINS-Fusion, arXiv 1901.03642). A graph over
/// world poses; local factors are the increments of an odometry taken as metric, of one fixed
/// covariance; global factors are the fixes at their tagged sigma under a robust loss. Each new
/// pose starts from the newest transformation of the local frame to the world.
///
/// That method expects metric odometry with gravity from an IMU. Ours has neither: the first fixes
/// set scale and attitude of the local frame once, after which the scale is held; the attitude
/// priors stand in for gravity.
class GlobalFusion : public GeoreferenceMethod {
 public:
  using GeoreferenceMethod::GeoreferenceMethod;

  void update(std::vector<Segment>& segments, std::size_t changed) const override {
    Segment& segment = segments[changed];
    if (!segment.scale_held) {
      if (!initialise(segment, options())) return;
      // Every fix counts: the robust loss alone deals with outliers.
      for (Node& node : segment.nodes) node.horizontal_outlier = node.vertical_outlier = false;
      segment.scale_held = segment.fixes() >= options().fusion_start_fixes;
    } else {
      predictLast(segment);
    }
    const bool full = fullSolveDue(segment);
    if (full) segment.full_solve_size = segment.nodes.size();
    solve(segment, {}, *this, full ? 0 : windowStart(segment));
  }

  void finish(std::vector<Segment>& segments) const override {
    for (Segment& segment : segments)
      if (segment.solved) solve(segment, {}, *this, 0);
  }

  bool scaleIsState() const override { return false; }

  Increment increment(const Segment& segment, std::size_t j) const override {
    return {incrementTo(segment, j), options().fusion_rotation_sigma_deg * kRadPerDeg,
            options().fusion_step_sigma_m / segment.scale};
  }

  Noise weights(const std::vector<Segment>&) const override { return {}; }

  /// Length of the path so far over the odometry's.
  double scaleOf(const Segment& segment) const override {
    double world = 0, local = 0;
    for (std::size_t j = 1; j < segment.nodes.size(); ++j) {
      const Node &a = segment.nodes[j - 1], &b = segment.nodes[j];
      world += (b.T_world_cam.translation() - a.T_world_cam.translation()).norm();
      local += incrementTo(segment, j).translation().norm();
    }
    return world > 0 && local > 0 ? world / local : segment.scale;
  }
};

}  // namespace

std::unique_ptr<GeoreferenceMethod> makeGlobalFusion(const GeoreferenceOptions& options) {
  return std::make_unique<GlobalFusion>(options);
}

}  // namespace cf
