// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "reprojection.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "robust.h"

namespace cf {
namespace {

/// Residuals beyond this many medians are of wrong matches.
constexpr double kGross = 6;
constexpr int kEnough = 20;  ///< residuals in a zone

/// T_cam_world of every photo with a pose, by UAV and photo.
std::vector<std::map<std::uint32_t, Eigen::Isometry3d>> viewsOf(const RunRecord& run) {
  std::vector<std::map<std::uint32_t, Eigen::Isometry3d>> views(run.uavs.size());
  for (std::size_t u = 0; u < run.uavs.size(); ++u)
    for (const PhotoPose& pose : run.uavs[u].final_trajectory)
      views[u][pose.photo] = pose.T_world_cam.inverse();
  return views;
}

struct Residual {
  std::uint32_t photo = 0;
  Eigen::Vector2f pixel, error;
};

std::vector<std::vector<Residual>> residualsOf(const RunRecord& run) {
  const auto views = viewsOf(run);
  std::vector<std::vector<Residual>> residuals(run.uavs.size());
  std::size_t next = 0;
  for (const SparsePoint& point : run.sparse_points)
    for (const SparseObservation& o : point.observations) {
      if (next >= run.sparse_pixels.size()) return residuals;
      const Eigen::Vector2f pixel = run.sparse_pixels[next++];
      const auto view = views[o.frame.uav].find(o.frame.index);
      if (view == views[o.frame.uav].end()) continue;
      const Eigen::Vector3d in_camera = view->second * point.position_m;
      if (in_camera.z() <= 0) continue;
      const Eigen::Vector2d projected = run.uavs[o.frame.uav].camera_after.project(in_camera);
      residuals[o.frame.uav].push_back({o.frame.index, pixel, projected.cast<float>() - pixel});
    }
  return residuals;
}

void addZones(const std::vector<Residual>& residuals, const CameraModel& camera,
              Reprojection& out) {
  const double limit = kGross * std::max(out.median_px, 1e-6);
  std::vector<double> squares(Reprojection::kColumns * Reprojection::kRows);
  out.zones.resize(squares.size());
  const auto part = [](double value, double size, int parts) {
    return std::clamp(static_cast<int>(parts * (value + 0.5) / size), 0, parts - 1);
  };
  for (const Residual& r : residuals) {
    if (r.error.norm() > limit) continue;
    const auto zone = static_cast<std::size_t>(
        part(r.pixel.y(), camera.height, Reprojection::kRows) * Reprojection::kColumns +
        part(r.pixel.x(), camera.width, Reprojection::kColumns));
    out.zones[zone].mean_px += r.error.cast<double>();
    squares[zone] += r.error.cast<double>().squaredNorm();
    ++out.zones[zone].count;
  }
  double sum = 0;
  int zones = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    Reprojection::Zone& zone = out.zones[i];
    const auto column = static_cast<double>(i % Reprojection::kColumns);
    const auto row = static_cast<double>(i / Reprojection::kColumns);
    zone.middle_px = {(column + 0.5) * camera.width / Reprojection::kColumns,
                      (row + 0.5) * camera.height / Reprojection::kRows};
    if (zone.count == 0) continue;
    zone.mean_px /= zone.count;
    if (zone.count < kEnough) continue;
    const double mean_square = zone.mean_px.squaredNorm();
    sum += mean_square - (squares[i] / zone.count - mean_square) / (zone.count - 1);
    ++zones;
  }
  out.systematic_px = zones > 0 ? std::sqrt(std::max(0.0, sum / zones)) : 0;
}

}  // namespace

std::vector<Reprojection> reprojectionsOf(const RunRecord& run) {
  const auto residuals = residualsOf(run);
  std::vector<Reprojection> all(run.uavs.size());
  for (std::size_t u = 0; u < all.size(); ++u) {
    Reprojection& out = all[u];
    std::map<std::uint32_t, int> counts;
    std::vector<double> errors;
    for (const Residual& r : residuals[u]) {
      errors.push_back(r.error.norm());
      out.rms_px[r.photo] += r.error.squaredNorm();
      ++counts[r.photo];
    }
    for (auto& [photo, value] : out.rms_px) value = std::sqrt(value / counts[photo]);
    out.median_px = quantileOf(errors, 0.5);
    out.p95_px = quantileOf(errors, 0.95);
    out.errors_px.assign(errors.begin(), errors.end());
    addZones(residuals[u], run.uavs[u].camera_after, out);
  }
  return all;
}

double groundPixel(const RunRecord& run) {
  const auto views = viewsOf(run);
  std::vector<double> sizes;
  for (const SparsePoint& point : run.sparse_points) {
    if (point.observations.empty()) continue;
    const FrameId id = point.observations.front().frame;
    const auto view = views[id.uav].find(id.index);
    if (view == views[id.uav].end()) continue;
    sizes.push_back((view->second * point.position_m).z() / run.uavs[id.uav].camera_after.fx);
  }
  return medianOf(std::move(sizes));
}

}  // namespace cf
