// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "cf/densify/densify.h"

namespace cf {
namespace {

constexpr int kGrid = 12;              // cells of the reference photo along each side
constexpr double kSeenAgain = 0.35;    // worth of a cell seen already by an earlier partner
constexpr double kBestBaseline = 0.3;  // baseline over depth: as good as it gets from here ...
constexpr double kLongBaseline = 0.6;  // ... to here
constexpr double kMaxAlongAxis = 0.6;  // of the baseline's direction, along the optical axes
constexpr double kMaxDepthRatio = 2;   // between the two photos' scene distances: the scales differ

struct Candidate {
  FrameId id;
  std::array<bool, kGrid * kGrid> seen{};
  Eigen::Vector3d direction;  // of the baseline
  double quality = 0;         // of its baseline over depth and scale, 0..1
};

/// Precision grows with the baseline; beyond about 0.6 of the depth photos differ too much.
double baselineQuality(double ratio) {
  if (ratio < kBestBaseline) return ratio / kBestBaseline;
  if (ratio > kLongBaseline) return std::max(0.2, 1 - (ratio - kLongBaseline) / 0.5);
  return 1;
}

std::optional<Candidate> candidateOf(const DenseView& reference, const DenseView& other,
                                     const DensifyOptions& options) {
  if (other.id == reference.id || other.component != reference.component ||
      !(other.median_depth_m > 0))
    return std::nullopt;
  const Eigen::Vector3d baseline =
      other.T_world_cam.translation() - reference.T_world_cam.translation();
  const Eigen::Vector3d axis_a = reference.T_world_cam.linear().col(2);
  const Eigen::Vector3d axis_b = other.T_world_cam.linear().col(2);
  const double cosine = std::clamp(axis_a.dot(axis_b), -1.0, 1.0);
  if (std::acos(cosine) > options.max_convergence_deg * M_PI / 180) return std::nullopt;
  const Eigen::Vector3d axis = (axis_a + axis_b).normalized();
  const double along = baseline.dot(axis);
  const double across = (baseline - along * axis).norm();
  const double ratio = across / reference.median_depth_m;
  if (ratio < options.min_baseline_over_depth || ratio > options.max_baseline_over_depth ||
      std::abs(along) > kMaxAlongAxis * baseline.norm()) {
    return std::nullopt;
  }
  const double scale = reference.median_depth_m / other.median_depth_m;
  if (scale > kMaxDepthRatio || scale < 1 / kMaxDepthRatio) return std::nullopt;

  Candidate candidate;
  candidate.id = other.id;
  candidate.direction = baseline.normalized();
  candidate.quality = baselineQuality(ratio) * std::min(scale, 1 / scale);
  const Eigen::Isometry3d T_other_ref = other.T_world_cam.inverse() * reference.T_world_cam;
  const CameraModel& camera = reference.camera;
  int seen = 0;
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      const Eigen::Vector2d pixel((i + 0.5) * camera.width / kGrid - 0.5,
                                  (j + 0.5) * camera.height / kGrid - 0.5);
      const Eigen::Vector3d p =
          T_other_ref * (reference.median_depth_m * camera.undistort(pixel).homogeneous());
      const CameraModel& c = other.camera;
      // The first test keeps strong distortions from folding far points into the photo.
      const bool in = p.z() > 0 && std::abs(p.x()) < p.z() * c.width / c.fx &&
                      std::abs(p.y()) < p.z() * c.height / c.fy && c.contains(c.project(p));
      candidate.seen[static_cast<std::size_t>(j * kGrid + i)] = in;
      seen += in;
    }
  }
  if (seen < options.min_overlap * kGrid * kGrid) return std::nullopt;
  return candidate;
}

/// What the candidate adds to the partners chosen so far.
double gain(const Candidate& candidate, const std::vector<Candidate>& chosen) {
  double cells = 0;
  for (std::size_t k = 0; k < candidate.seen.size(); ++k) {
    if (!candidate.seen[k]) continue;
    double worth = 1;
    for (const Candidate& earlier : chosen) {
      if (!earlier.seen[k]) continue;
      const double sine = candidate.direction.cross(earlier.direction).norm();
      worth *= kSeenAgain * (0.5 + 0.5 * sine);
    }
    cells += worth;
  }
  return cells * candidate.quality;
}

}  // namespace

std::vector<FrameId> choosePartners(const DenseView& reference,
                                    const std::vector<DenseView>& others,
                                    const DensifyOptions& options) {
  std::vector<Candidate> candidates, chosen;
  if (!(reference.median_depth_m > 0)) return {};
  for (const DenseView& other : others) {
    if (auto candidate = candidateOf(reference, other, options)) candidates.push_back(*candidate);
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.id < b.id; });
  std::vector<FrameId> ids;
  while (static_cast<int>(ids.size()) < options.partners && !candidates.empty()) {
    auto best = candidates.begin();
    double best_gain = -1;
    for (auto it = candidates.begin(); it != candidates.end(); ++it) {
      const double g = gain(*it, chosen);
      if (g > best_gain) {
        best_gain = g;
        best = it;
      }
    }
    ids.push_back(best->id);
    chosen.push_back(*best);
    candidates.erase(best);
  }
  return ids;
}

}  // namespace cf
