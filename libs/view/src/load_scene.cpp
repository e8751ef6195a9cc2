// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/formats/csv.h"
#include "cf/formats/ply.h"
#include "cf/formats/tum.h"
#include "cf/view/scene_inputs.h"
#include "load_octomap.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

std::vector<ColouredPoint> loadCloud(const fs::path& file, std::size_t max_points) {
  PlyReader reader(file);
  std::vector<ColouredPoint> cloud;
  const double keep = static_cast<double>(max_points) /
                      static_cast<double>(std::max<std::uint64_t>(1, reader.count()));
  cloud.reserve(static_cast<std::size_t>(std::min<std::uint64_t>(reader.count(), max_points)));
  std::mt19937 random(1);
  const double most = static_cast<double>(std::mt19937::max());
  PlyPoint p;
  for (;;) {
    const bool wanted = !(keep < 1 && static_cast<double>(random()) / most > keep);
    if (!(wanted ? reader.next(p) : reader.skip())) break;
    if (!wanted) continue;
    if (!p.position_m.allFinite()) continue;
    ColouredPoint point;
    point.position_m = p.position_m.cast<float>();
    const std::array<std::uint8_t, 3> grey = {160, 160, 160};
    const auto& rgb = reader.coloured() ? p.rgb : grey;
    std::copy(rgb.begin(), rgb.end(), point.rgb);
    cloud.push_back(point);
  }
  return cloud;
}

constexpr std::size_t kMostLinks = 60;  // more would hide the map
constexpr const char* kOnlineSuffix = ".online";

std::vector<fs::path> trackFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".tum" && entry.path().stem().extension() != kOnlineSuffix)
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// Camera centre of each photo of one UAV by the photo's name: images/<uav>.csv joined with the
// trajectory by time.
using Centres = std::map<std::string, Eigen::Vector3d>;
Centres centresByPhoto(const fs::path& images_csv, const std::map<TimeNs, Eigen::Vector3d>& track) {
  Centres centres;
  if (!fs::exists(images_csv)) return centres;
  const CsvTable table(images_csv);
  const auto image = table.column("image"), t = table.column("t"), status = table.column("status");
  for (const auto& row : table.rows()) {
    if (row[status] != "posed") continue;
    try {
      const auto found = track.find(timeFromText(row[t]));
      if (found != track.end()) centres[row[image]] = found->second;
    } catch (const RunError& e) {
      throw RunError(fmt::format("{}: {}", images_csv.string(), e.what()));
    }
  }
  return centres;
}

void loadLinks(const fs::path& file, const std::map<std::string, Centres>& centres,
               std::vector<RelativeLink>& links) {
  if (!fs::exists(file)) return;
  const CsvTable table(file);
  const auto uav_a = table.column("uav_a"), uav_b = table.column("uav_b");
  const auto image_a = table.column("image_a"), image_b = table.column("image_b");
  const auto find = [&](const std::string& uav,
                        const std::string& image) -> const Eigen::Vector3d* {
    const auto found = centres.find(uav);
    if (found == centres.end()) return nullptr;
    const auto centre = found->second.find(image);
    return centre == found->second.end() ? nullptr : &centre->second;
  };
  // For each photo its strongest partner of each other UAV: all of them would hide the map.
  const auto inliers = table.column("inliers");
  struct Strongest {
    double inliers = -1;
    std::size_t row = 0;
  };
  std::map<std::array<std::string, 3>, Strongest> strongest;  // by UAV, photo, other UAV
  for (std::size_t i = 0; i < table.rows().size(); ++i) {
    const auto& row = table.rows()[i];
    if (row[uav_a] == row[uav_b]) continue;  // within one UAV: not drawn
    if (!find(row[uav_a], row[image_a]) || !find(row[uav_b], row[image_b])) continue;
    const double count = numberFrom(row[inliers]).value_or(0);
    for (Strongest* best : {&strongest[{row[uav_a], row[image_a], row[uav_b]}],
                            &strongest[{row[uav_b], row[image_b], row[uav_a]}]})
      if (count > best->inliers) *best = {count, i};
  }
  std::set<std::size_t> rows;
  for (const auto& [photo, best] : strongest) rows.insert(best.row);
  // Of many an even sample, in the order of the file.
  const std::vector<std::size_t> chosen(rows.begin(), rows.end());
  const std::size_t count = std::min(kMostLinks, chosen.size());
  for (std::size_t k = 0; k < count; ++k) {
    const auto& row = table.rows()[chosen[k * chosen.size() / count]];
    links.push_back({*find(row[uav_a], row[image_a]), *find(row[uav_b], row[image_b])});
  }
}

std::string loadWorld(const fs::path& file, SceneInputs& scene) {
  if (!fs::exists(file)) return {};
  std::ifstream in(file);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (json.is_discarded() || !json.is_object())
    throw RunError(fmt::format("{}: not a JSON object", file.string()));
  try {
    scene.georeferenced = json.contains("origin") && json["origin"].is_object();
    if (scene.georeferenced) scene.origin_height_m = json["origin"].value("h", 0.0);
    scene.height_datum = json.value("h_datum", "unknown");
    return json.value("center", "");
  } catch (const nlohmann::json::exception& e) {
    throw RunError(fmt::format("{}: {}", file.string(), e.what()));
  }
}

}  // namespace

SceneInputs loadScene(const fs::path& outdir, const SceneLimits& limits) {
  if (!fs::is_directory(outdir))
    throw UsageError(
        fmt::format("{}: no such folder; give the output folder of cf-run", outdir.string()));
  SceneInputs scene;
  const std::string centre_uav = loadWorld(outdir / "world.json", scene);
  std::map<std::string, Centres> centres;
  for (const auto& file : trackFiles(outdir / "trajectories")) {
    UavTrack track;
    track.name = file.stem().string();
    track.central = track.name == centre_uav;
    std::map<TimeNs, Eigen::Vector3d> by_time;
    for (const auto& pose : readTum(file)) {
      track.positions_m.push_back(pose.T_world_cam.translation());
      by_time[pose.time] = pose.T_world_cam.translation();
    }
    centres[track.name] = centresByPhoto(outdir / "images" / (track.name + ".csv"), by_time);
    scene.tracks.push_back(std::move(track));
  }
  loadLinks(outdir / "relative_poses.csv", centres, scene.links);
  if (limits.with_cloud) scene.cloud = loadCloud(outdir / "cloud" / "cloud.ply", limits.max_points);
  if (limits.with_voxels) scene.voxels = loadVoxels(outdir / "octomap.ot", limits.max_voxels);
  return scene;
}

}  // namespace cf
