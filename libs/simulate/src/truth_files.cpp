// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "truth_files.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cf/base/disk.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/csv.h"
#include "cf/formats/tum.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json jsonOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void writeJson(const fs::path& file, const Json& json) {
  writeFileAtomically(file, json.dump(2) + "\n");
}

Json worldJson(const SimulationSetup& setup, const LocalFrame& world) {
  return {{"origin",
           {{"lat", setup.origin.latitude_deg},
            {"lon", setup.origin.longitude_deg},
            {"h", setup.origin.height_m}}},
          {"h_datum", "ellipsoid"},
          {"frame", "ENU"},
          {"utm", world.utmZone()},
          {"center", setup.uavs.front().name}};
}

void writePoses(const fs::path& truth, const std::vector<PlannedUav>& uavs) {
  createFolder(truth / "trajectories");
  std::string images;
  std::vector<TimedPose> all;
  for (const PlannedUav& uav : uavs) {
    std::vector<TimedPose> poses;
    for (const PlannedPhoto& photo : uav.photos) {
      poses.push_back({photo.time, photo.motion.T_world_cam});
      images += fmt::format("{}/{}\t{}\n", uav.options.name, photo.name, timeText(photo.time));
    }
    writeTum(truth / "trajectories" / (uav.options.name + ".tum"), poses);
    all.insert(all.end(), poses.begin(), poses.end());
  }
  writeTum(truth / "poses.tum", all);
  writeFileAtomically(truth / "images.tsv", images);
}

void writeCameras(const fs::path& truth, const std::vector<PlannedUav>& uavs) {
  createFolder(truth / "cameras");
  for (const PlannedUav& uav : uavs) {
    const TrueCamera& c = uav.camera;
    const std::vector<std::pair<const char*, double>> keys = {
        {"fx", c.focal}, {"fy", c.focal}, {"cx", c.cx}, {"cy", c.cy}, {"k1", c.k1},
        {"k2", c.k2},    {"p1", c.p1},    {"p2", c.p2}, {"k3", c.k3}};
    std::string text = fmt::format("[camera]\nwidth = {}\nheight = {}\n", c.width, c.height);
    for (const auto& [key, value] : keys) text += fmt::format("{} = {}\n", key, value);
    writeFileAtomically(truth / "cameras" / (uav.options.name + ".ini"), text);
  }
}

void writeFixes(const fs::path& file, const GnssRecord& gnss) {
  CsvWriter csv(file, {"t", "e", "n", "u", "true_e", "true_n", "true_u", "outlier"});
  for (const SimulatedFix& fix : gnss.fixes) {
    CsvRow row = {timeText(fix.fix.time)};
    for (const Eigen::Vector3d& p : {fix.measured_m, fix.true_m})
      for (int a = 0; a < 3; ++a) row.push_back(fmt::format("{:.6f}", p[a]));
    row.push_back(fix.outlier ? "1" : "0");
    csv.row(row);
  }
  csv.close();
}

Json gnssJson(const PlannedUav& uav) {
  const GnssOptions& o = uav.options.gnss;
  int outliers = 0;
  for (const SimulatedFix& fix : uav.gnss.fixes) outliers += fix.outlier ? 1 : 0;
  Json outages = Json::array();
  for (const auto& [from, to] : uav.gnss.outages_s) outages.push_back({from, to});
  return {{"sigma_m", jsonOf(uav.gnss.sigma_m)},
          {"walk_m_per_sqrt_s", {o.walk_h, o.walk_h, o.walk_v}},
          {"bias_m", jsonOf(uav.gnss.bias_m)},
          {"fixes", uav.gnss.fixes.size()},
          {"outliers", outliers},
          {"outages", outages},
          {"time_offset_s", o.time_offset_s},
          {"lever_arm_m", {o.lever_forward_m, o.lever_left_m, o.lever_up_m}},
          {"datum", o.datum},
          {"datum_offset_m", o.datum_offset_m}};
}

void writeGnss(const fs::path& truth, const std::vector<PlannedUav>& uavs) {
  createFolder(truth / "gnss");
  Json all = Json::object();
  for (const PlannedUav& uav : uavs) {
    writeFixes(truth / "gnss" / (uav.options.name + ".csv"), uav.gnss);
    all[uav.options.name] = gnssJson(uav);
  }
  writeJson(truth / "gnss.json", all);
}

Json flightJson(const PlannedUav& uav) {
  const FlightOptions& f = uav.options.flight;
  return {{"photos", uav.photos.size()},
          {"strips", uav.strips},
          {"duration_s", uav.duration_s},
          {"height_m", f.height_m},
          {"ground_z_m", uav.ground_z_m},
          {"gsd_m", uav.gsd_m()},
          {"photo_on_ground_m", {uav.footprint.across_m, uav.footprint.along_m}},
          {"forward_overlap", f.forward_overlap},
          {"side_overlap", f.side_overlap},
          {"speed_mps", f.speed_mps},
          {"focal_px", uav.camera.focal},
          {"told_focal_px", uav.told.fx}};
}

Json simulationJson(const SimulationSetup& setup, const Eigen::AlignedBox2d& area,
                    const std::vector<PlannedUav>& uavs) {
  Json flights = Json::object();
  std::size_t photos = 0;
  for (const PlannedUav& uav : uavs) {
    flights[uav.options.name] = flightJson(uav);
    photos += uav.photos.size();
  }
  return {{"seed", setup.simulation.seed},
          {"photos", photos},
          {"scene_area_m", {area.min().x(), area.min().y(), area.max().x(), area.max().y()}},
          {"reference_spacing_m", setup.simulation.reference_spacing_m},
          {"uavs", flights}};
}

}  // namespace

void writeTruthFiles(const fs::path& truth, const SimulationSetup& setup, const LocalFrame& world,
                     const Eigen::AlignedBox2d& area, const std::vector<PlannedUav>& uavs) {
  createFolder(truth);
  writeJson(truth / "world.json", worldJson(setup, world));
  writePoses(truth, uavs);
  writeCameras(truth, uavs);
  writeGnss(truth, uavs);
  writeJson(truth / "simulation.json", simulationJson(setup, area, uavs));
}

}  // namespace cf
