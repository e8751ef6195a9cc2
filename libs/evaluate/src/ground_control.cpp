// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/ground_control.h"

#include <algorithm>
#include <map>

#include "cf/base/error.h"
#include "cf/evaluate/marked_points.h"
#include "cf/formats/camera_ini.h"
#include "estimated_poses.h"
#include "figures.h"
#include "statistics.h"
#include "world_origin.h"

namespace cf {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

/// Lengths of the errors of a point, all of them and by UAV [px].
struct PixelErrors {
  std::vector<double> all;
  std::map<std::string, std::vector<double>> by_uav;

  void add(const std::string& uav, double error_px) {
    all.push_back(error_px);
    by_uav[uav].push_back(error_px);
  }
  double max() const { return *std::max_element(all.begin(), all.end()); }
};

Json jsonOf(const std::vector<double>& errors_px) {
  return {{"marks", errors_px.size()}, {"rms_px", rms(errors_px)}};
}

Json differences(const std::vector<Eigen::Vector3d>& d) {
  std::vector<double> length, horizontal, vertical;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : d) {
    length.push_back(v.norm());
    horizontal.push_back(v.head<2>().norm());
    vertical.push_back(v.z());
    mean += v / static_cast<double>(d.size());
  }
  return {{"rms", rms(length)},
          {"horizontal_rms", rms(horizontal)},
          {"vertical_rms", rms(vertical)},
          {"mean", triple(mean)}};
}

Sim3 alignmentOf(const std::vector<const MarkedPoint*>& points,
                 const std::vector<MarkedPlace>& places, std::optional<AlignmentModel> model) {
  if (!model) return {};
  std::vector<Eigen::Vector3d> surveyed, mapped;
  for (std::size_t i = 0; i < points.size(); ++i) {
    surveyed.push_back(points[i]->surveyed);
    mapped.push_back(places[i].position);
  }
  const Result<Sim3> S = alignPoints(surveyed, mapped, *model);
  if (!S) throw RunError("the ground points cannot be aligned: " + S.failure().detail);
  return *S;
}

/// One triangulated point; its errors are added to those of all.
Json pointFigures(const MarkedPoint& point, const MarkedPlace& place, const Sim3& S_surveyed_map,
                  PixelErrors& all) {
  PixelErrors errors;
  Json sights = Json::array();
  for (const MarkedSight& sight : point.sights) {
    const Eigen::Vector2d e = sight.errorOf(place.position);
    errors.add(sight.uav, e.norm());
    all.add(sight.uav, e.norm());
    sights.push_back({{"image", sight.image},
                      {"uav", sight.uav},
                      {"pixel", {sight.pixel.x(), sight.pixel.y()}},
                      {"error_px", {e.x(), e.y()}}});
  }
  return {{"name", point.name},
          {"marks", point.sights.size()},
          {"uavs", point.uavs()},
          {"rms_px", rms(errors.all)},
          {"max_px", errors.max()},
          {"angle_deg", kDegrees * place.max_angle_rad},
          {"position_m", triple(place.position)},
          {"surveyed_m", triple(point.surveyed)},
          {"difference_m", triple(S_surveyed_map * place.position - point.surveyed)},
          {"sights", std::move(sights)}};
}

/// The photos of a run, from its files.
MapPhotos photosOf(const std::filesystem::path& out_dir) {
  MapPhotos photos;
  std::map<std::string, CameraModel> cameras;
  for (const auto& [name, pose] : readEstimatedPoses(out_dir)) {
    auto camera = cameras.find(pose.uav);
    if (camera == cameras.end()) try {
        const auto ini = out_dir / "cameras" / (pose.uav + ".ini");
        camera = cameras.emplace(pose.uav, readCameraIni(ini)).first;
      } catch (const UsageError& e) {
        throw RunError(e.what());
      }
    photos.emplace(name, MapPhoto{pose.uav, pose.T_world_cam, camera->second});
  }
  return photos;
}

LocalFrame frameOf(const std::filesystem::path& out_dir) {
  const std::optional<LocalFrame> world = worldFrameOf(out_dir);
  if (!world)
    throw RunError((out_dir / "world.json").string() +
                   ": gives no origin: the map's place on the earth is not known");
  return *world;
}

}  // namespace

std::string evaluateGroundControl(const std::filesystem::path& out_dir,
                                  const std::filesystem::path& gcp_list,
                                  const GroundControlOptions& options) {
  const GcpList list = readGcpList(gcp_list);
  const std::vector<MarkedPoint> points =
      joinMarks(list, frameOf(out_dir), photosOf(out_dir), options.size);
  std::vector<const MarkedPoint*> placed;
  std::vector<MarkedPlace> places;
  Json missing = Json::object(), without_pose = Json::array();
  for (const MarkedPoint& point : points) {
    for (const std::string& image : point.without_pose)
      if (std::find(without_pose.begin(), without_pose.end(), image) == without_pose.end())
        without_pose.push_back(image);
    const Result<MarkedPlace> place = placeOf(point.sights);
    if (place) {
      placed.push_back(&point);
      places.push_back(*place);
    } else {
      missing[point.name] = place.failure().detail;
    }
  }
  if (placed.empty())
    throw RunError(
        gcp_list.string() +
        ": no point is marked in two photos with a pose: is it the list of this flight?");

  const Sim3 S = alignmentOf(placed, places, options.align);
  PixelErrors errors;
  std::vector<Eigen::Vector3d> difference;
  Json per_point = Json::array(), per_uav = Json::object();
  int across = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    per_point.push_back(pointFigures(*placed[i], places[i], S, errors));
    difference.push_back(S * places[i].position - placed[i]->surveyed);
    across += placed[i]->uavs() > 1 ? 1 : 0;
  }
  for (const auto& [uav, of_uav] : errors.by_uav) per_uav[uav] = jsonOf(of_uav);
  const Json out = {{"crs", list.crs},
                    {"points", points.size()},
                    {"triangulated", placed.size()},
                    {"across_uavs", across},
                    {"marks", errors.all.size()},
                    {"rms_px", rms(errors.all)},
                    {"median_px", median(errors.all)},
                    {"max_px", errors.max()},
                    {"difference_m", differences(difference)},
                    {"scale", S.scale},
                    {"missing", missing},
                    {"photos_without_pose", without_pose},
                    {"per_uav", per_uav},
                    {"per_point", per_point}};
  return out.dump(2);
}

}  // namespace cf
