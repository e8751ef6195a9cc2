// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/view/view_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr double kDeg = M_PI / 180.0;
constexpr double kMargin = 1.1;  // picture size over scene size

double percentile(std::vector<float>& values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

struct Box {
  Eigen::Vector3d min = Eigen::Vector3d::Constant(INFINITY);
  Eigen::Vector3d max = Eigen::Vector3d::Constant(-INFINITY);
  bool empty() const { return !(min.x() <= max.x()); }
  void extend(const Eigen::Vector3d& p) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
  bool contains(const Eigen::Vector3d& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
};

template <class Points, class Position>
Box robustBox(const Points& points, Position position) {
  Box box;
  const std::size_t step = std::max<std::size_t>(1, points.size() / 200'000);
  std::array<std::vector<float>, 3> axis;
  for (std::size_t i = 0; i < points.size(); i += step)
    for (int k = 0; k < 3; ++k) axis[static_cast<std::size_t>(k)].push_back(position(points[i])[k]);
  if (axis[0].empty()) return box;
  for (int k = 0; k < 3; ++k) {
    auto& values = axis[static_cast<std::size_t>(k)];
    box.min[k] = percentile(values, 0.005);
    box.max[k] = percentile(values, 0.995);
  }
  return box;
}

// Points that the picture must show: those of the cloud (or voxels) in the box, and the tracks.
std::vector<Eigen::Vector3d> pointsToShow(const SceneInputs& scene, const View& view) {
  const bool voxels = view.kind == View::Kind::kOctomap;
  std::vector<Eigen::Vector3d> shown;
  const UavTrack* only = nullptr;
  for (const auto& track : scene.tracks) {
    if (view.kind == View::Kind::kUav && track.name != view.uav) continue;
    if (view.kind == View::Kind::kUav) only = &track;
    shown.insert(shown.end(), track.positions_m.begin(), track.positions_m.end());
  }
  if (view.kind == View::Kind::kUav && only == nullptr) {
    std::string known;
    for (const auto& track : scene.tracks) known += (known.empty() ? "" : ", ") + track.name;
    throw UsageError(fmt::format("--view uav:{}: no such UAV in this run; it has: {}", view.uav,
                                 known.empty() ? "none" : known));
  }
  Box box = voxels ? robustBox(scene.voxels, [](const Voxel& v) { return v.centre_m; })
                   : robustBox(scene.cloud, [](const ColouredPoint& p) { return p.position_m; });
  if (only != nullptr && !only->positions_m.empty() && !box.empty()) {
    // The ground around this UAV: its track widened by half its height above the lowest ground.
    Box around;
    for (const auto& p : only->positions_m) around.extend(p);
    const double reach = std::max(5.0, 0.5 * (around.max.z() - box.min.z()));
    for (int k = 0; k < 2; ++k) {
      box.min[k] = std::max(box.min[k], around.min[k] - reach);
      box.max[k] = std::min(box.max[k], around.max[k] + reach);
    }
  }
  const std::size_t count = voxels ? scene.voxels.size() : scene.cloud.size();
  const std::size_t step = std::max<std::size_t>(1, count / 50'000);
  for (std::size_t i = 0; i < count; i += step) {
    const Eigen::Vector3d p =
        (voxels ? scene.voxels[i].centre_m : scene.cloud[i].position_m).cast<double>();
    if (box.contains(p)) shown.push_back(p);
  }
  if (shown.empty())
    throw RunError("nothing to show: the run has neither map points nor trajectories");
  return shown;
}

// Azimuth of the view behind a UAV: along its last leg.
double azimuthBehind(const UavTrack& track) {
  const auto& p = track.positions_m;
  for (std::size_t i = p.size(); i > 1; --i) {
    const Eigen::Vector3d leg = p.back() - p[i - 2];
    if (leg.head<2>().norm() > 1.0) return std::atan2(-leg.y(), -leg.x()) / kDeg;
  }
  return -90;
}

}  // namespace

ImageSize parseImageSize(const std::string& text) {
  ImageSize size;
  const char* end = text.data() + text.size();
  const auto w = std::from_chars(text.data(), end, size.width);
  const bool x = w.ec == std::errc() && w.ptr != end && *w.ptr == 'x';
  const auto h = x ? std::from_chars(w.ptr + 1, end, size.height) : w;
  const auto fits = [](int v) { return v >= 64 && v <= 16384; };
  if (!x || h.ec != std::errc() || h.ptr != end || !fits(size.width) || !fits(size.height))
    throw UsageError(
        fmt::format("--size {}: expected WIDTHxHEIGHT in pixels, 64 to 16384 each", text));
  return size;
}

View parseView(const std::string& text) {
  if (text.rfind("uav:", 0) == 0 && text.size() > 4) return {View::Kind::kUav, text.substr(4)};
  const std::pair<const char*, View::Kind> names[] = {{"top", View::Kind::kTop},
                                                      {"iso", View::Kind::kIso},
                                                      {"front", View::Kind::kFront},
                                                      {"octomap", View::Kind::kOctomap},
                                                      {"height", View::Kind::kHeight}};
  for (const auto& [name, kind] : names)
    if (text == name) return {kind, {}};
  throw UsageError(fmt::format(
      "--view {}: no such view; choose top, iso, front, uav:<name>, octomap or height", text));
}

Eigen::Vector3d ViewCamera::right() const {
  return {-std::sin(azimuth_deg * kDeg), std::cos(azimuth_deg * kDeg), 0};
}

Eigen::Vector3d ViewCamera::forward() const {
  const double a = azimuth_deg * kDeg, e = elevation_deg * kDeg;
  return {-std::cos(a) * std::cos(e), -std::sin(a) * std::cos(e), -std::sin(e)};
}

Eigen::Vector3d ViewCamera::up() const { return right().cross(forward()); }

Eigen::Vector3d ViewCamera::eye() const { return target_m - distance_m * forward(); }

double ViewCamera::metresPerPixel(double depth_m) const {
  if (orthographic) return height_m / size.height;
  return 2 * depth_m * std::tan(kFieldOfViewDeg / 2 * kDeg) / size.height;
}

Eigen::Vector2d ViewCamera::project(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d d = p - eye();
  const double px = 1 / metresPerPixel(forward().dot(d));
  return {(size.width - 1) / 2.0 + right().dot(d) * px, (size.height - 1) / 2.0 - up().dot(d) * px};
}

ViewCamera frameScene(const SceneInputs& scene, const View& view, ImageSize size) {
  const auto points = pointsToShow(scene, view);
  ViewCamera camera;
  camera.size = size;
  switch (view.kind) {
    case View::Kind::kTop:
    case View::Kind::kHeight:
      camera.orthographic = true;
      break;
    case View::Kind::kFront:
      camera.elevation_deg = 18;
      break;
    case View::Kind::kIso:
    case View::Kind::kOctomap:
      camera.azimuth_deg = -60;
      camera.elevation_deg = 38;
      break;
    case View::Kind::kUav:
      camera.elevation_deg = 30;
      for (const auto& track : scene.tracks)
        if (track.name == view.uav) camera.azimuth_deg = azimuthBehind(track);
      break;
  }
  const Eigen::Vector3d r = camera.right(), u = camera.up(), f = camera.forward();
  const double aspect = static_cast<double>(size.width) / size.height;
  // Smallest picture that holds every point: slope 0 is a parallel projection, else the tangent of
  // half the opening angle; each side of the picture is one plane that the points must be behind.
  const double tan_v =
      camera.orthographic ? 0 : std::tan(ViewCamera::kFieldOfViewDeg / 2 * kDeg) / kMargin;
  const double tan_h = tan_v * aspect;
  double left = -INFINITY, right = -INFINITY, top = -INFINITY, bottom = -INFINITY;
  double z_min = INFINITY, z_max = -INFINITY;
  for (const auto& p : points) {
    const double x = r.dot(p), y = u.dot(p), z = f.dot(p);
    right = std::max(right, x - tan_h * z);
    left = std::max(left, -x - tan_h * z);
    top = std::max(top, y - tan_v * z);
    bottom = std::max(bottom, -y - tan_v * z);
    z_min = std::min(z_min, z);
    z_max = std::max(z_max, z);
  }
  const double depth_range = std::max(1.0, z_max - z_min);
  const double z_mid = (z_min + z_max) / 2;
  double z_eye;
  if (camera.orthographic) {
    // MRPT ties the two together: visible height = distance / 2. The eye must be above the scene.
    camera.height_m =
        std::max({1.0, kMargin * std::max(top + bottom, (left + right) / aspect), depth_range});
    camera.distance_m = 2 * camera.height_m;
    z_eye = z_mid - camera.distance_m;
  } else {
    const double back = std::max((top + bottom) / (2 * tan_v), (left + right) / (2 * tan_h));
    z_eye = std::min(-back, z_min - 0.05 * depth_range - 1);
    camera.distance_m = z_mid - z_eye;
  }
  camera.target_m = r * ((right - left) / 2) + u * ((top - bottom) / 2) + f * z_mid;
  // Outliers beyond the robust extent are drawn too, within reason.
  camera.near_m = std::max(0.02 * (z_min - z_eye), z_min - z_eye - depth_range);
  camera.far_m = (z_max - z_eye) + depth_range;
  return camera;
}

}  // namespace cf
