// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ground_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "cf/evaluate/doming.h"
#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

constexpr std::size_t kPlaces = 20'000;
constexpr std::size_t kPlacesPerPhoto = 400;
constexpr double kMinAngle_rad = 0.05, kMaxAngle_rad = 1.0471975511965976;

struct Seen {
  const TruthView* view;
  Eigen::Vector2d pixel;
};

/// The two photos at the widest angle that is not too wide.
std::optional<std::pair<Seen, Seen>> widest(const std::vector<Seen>& seen,
                                            const Eigen::Vector3d& p_world) {
  std::optional<std::pair<Seen, Seen>> best;
  double best_angle = kMinAngle_rad;
  const auto ray = [&](const Seen& s) {
    return (s.view->T_cam_world.inverse().translation() - p_world).normalized().eval();
  };
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t j = i + 1; j < seen.size(); ++j) {
      const double angle = std::acos(std::min(1.0, ray(seen[i]).dot(ray(seen[j]))));
      if (angle > best_angle && angle <= kMaxAngle_rad) {
        best_angle = angle;
        best = {seen[i], seen[j]};
      }
    }
  return best;
}

std::optional<Eigen::Vector3d> triangulateBy(const RunInputs& run, const std::vector<Seen>& seen,
                                             const Eigen::Vector3d& truth) {
  const auto pair = widest(seen, truth);
  if (!pair) return std::nullopt;
  std::vector<Sight> sights;
  for (const Seen& s : {pair->first, pair->second}) {
    const RunUav& uav = run.uavs[s.view->uav];
    sights.push_back({*uav.photos[s.view->photo].estimate, uav.camera_after->undistort(s.pixel)});
  }
  const auto point = triangulate(sights);
  return point ? std::optional(point->position) : std::nullopt;
}

/// Pixels of an even grid on the depth map, at which the depth is exact.
std::vector<Eigen::Vector3d> placesOf(const TruthView& view, std::size_t wanted) {
  const cv::Mat& depth = view.depth.values;
  const double pixels = static_cast<double>(depth.rows) * depth.cols;
  const int n = std::max(1, static_cast<int>(std::sqrt(pixels / static_cast<double>(wanted))));
  const Eigen::Isometry3d T_world_cam = view.T_cam_world.inverse();
  std::vector<Eigen::Vector3d> places;
  for (int j = n / 2; j < depth.rows; j += n)
    for (int i = n / 2; i < depth.cols; i += n) {
      const auto z = static_cast<double>(depth.at<float>(j, i));
      if (!(z > 0)) continue;
      const Eigen::Vector2d pixel(i * view.depth.step, j * view.depth.step);
      places.push_back(T_world_cam * (z * view.camera->undistort(pixel).homogeneous()));
    }
  return places;
}

GroundPoint mapPlace(const RunInputs& run, const std::vector<TruthView>& views,
                     const Sim3& S_ref_est, const Eigen::Vector3d& truth) {
  GroundPoint point;
  point.truth = truth;
  std::map<std::size_t, std::vector<Seen>> seen;
  double gsd = 0;
  std::size_t n = 0;
  for (const TruthView& view : views) {
    const RunUav& uav = run.uavs[view.uav];
    Eigen::Vector2d pixel;
    if (!uav.camera_after || !uav.photos[view.photo].estimate || !view.sees(truth, pixel)) continue;
    seen[view.uav].push_back({&view, pixel});
    gsd += (view.T_cam_world * truth).z() / view.camera->fx;
    ++n;
  }
  point.gsd_m = n > 0 ? gsd / static_cast<double>(n) : 0;
  for (const auto& [uav, photos] : seen)
    if (const auto mapped = triangulateBy(run, photos, truth))
      point.mapped[uav] = S_ref_est * *mapped;
  return point;
}

/// Horizontal and vertical errors, in metres and ground pixels.
struct Errors {
  std::vector<double> horizontal_m, vertical_m, horizontal_gsd, vertical_gsd;

  void add(const Eigen::Vector3d& error, double gsd_m) {
    horizontal_m.push_back(error.head<2>().norm());
    vertical_m.push_back(error.z());
    horizontal_gsd.push_back(error.head<2>().norm() / gsd_m);
    vertical_gsd.push_back(std::abs(error.z()) / gsd_m);
  }
  Json json() const {
    if (vertical_m.empty()) return nullptr;
    std::vector<double> magnitude;
    for (const double v : vertical_m) magnitude.push_back(std::abs(v));
    Json out = {{"places", vertical_m.size()},
                {"horizontal_m", sizeOf(horizontal_m)},
                {"vertical_m", sizeOf(magnitude)},
                {"horizontal_gsd", sizeOf(horizontal_gsd)},
                {"vertical_gsd", sizeOf(vertical_gsd)}};
    out["vertical_m"]["bias"] = spreadOf(vertical_m)["bias"];
    return out;
  }
};

}  // namespace

std::vector<GroundPoint> mapGroundPoints(const RunInputs& run, const std::vector<TruthView>& views,
                                         const Sim3& S_ref_est) {
  std::vector<Eigen::Vector3d> places;
  const std::size_t wanted = std::max<std::size_t>(
      1, std::min(kPlacesPerPhoto, kPlaces / std::max<std::size_t>(1, views.size())));
  for (const TruthView& view : views)
    for (const Eigen::Vector3d& place : placesOf(view, wanted)) places.push_back(place);
  std::vector<GroundPoint> points(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(),
                    [&](std::size_t i) { points[i] = mapPlace(run, views, S_ref_est, places[i]); });
  points.erase(std::remove_if(points.begin(), points.end(),
                              [](const GroundPoint& p) { return p.mapped.empty(); }),
               points.end());
  return points;
}

RunSection seamFigures(const RunInputs& run, const std::vector<GroundPoint>& points) {
  std::map<std::pair<std::size_t, std::size_t>, Errors> by_pair;
  Errors all;
  for (const GroundPoint& p : points)
    for (auto a = p.mapped.begin(); a != p.mapped.end(); ++a)
      for (auto b = std::next(a); b != p.mapped.end(); ++b) {
        by_pair[{a->first, b->first}].add(a->second - b->second, p.gsd_m);
        all.add(a->second - b->second, p.gsd_m);
      }
  if (by_pair.empty())
    return Failure{"no_common_ground", "no place is seen by two photos each of two UAVs"};
  Json out = {{"all", all.json()}, {"pairs", Json::array()}};
  for (const auto& [pair, errors] : by_pair) {
    Json entry = {{"a", run.uavs[pair.first].name}, {"b", run.uavs[pair.second].name}};
    entry.update(errors.json());
    out["pairs"].push_back(std::move(entry));
  }
  return out;
}

RunSection groundFigures(const RunInputs& run, const std::vector<GroundPoint>& points) {
  if (points.empty()) return Failure{"no_ground", "no place is seen by two photos of one UAV"};
  Errors all;
  std::map<std::size_t, Errors> by_uav;
  for (const GroundPoint& p : points)
    for (const auto& [uav, mapped] : p.mapped) {
      all.add(mapped - p.truth, p.gsd_m);
      by_uav[uav].add(mapped - p.truth, p.gsd_m);
    }
  Json out = {{"all", all.json()}};
  for (const auto& [uav, errors] : by_uav) out["per_uav"][run.uavs[uav].name] = errors.json();
  return out;
}

RunSection domingFigures(const std::vector<GroundPoint>& points) {
  std::vector<Eigen::Vector2d> places;
  std::vector<double> errors;
  for (const GroundPoint& p : points) {
    double error = 0;
    for (const auto& [uav, mapped] : p.mapped)
      error += (mapped.z() - p.truth.z()) / static_cast<double>(p.mapped.size());
    places.emplace_back(p.truth.head<2>());
    errors.push_back(error);
  }
  const auto doming = domingOf(places, errors);
  if (!doming) return doming.failure();
  return Json{{"places", places.size()}, {"span_m", doming->span_m}, {"rms_m", doming->rms_m}};
}

}  // namespace cf
