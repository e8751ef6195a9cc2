// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cf/deliver/deliver.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/csv.h"
#include "cf/formats/pose_covariance_csv.h"
#include "cf/formats/tum.h"
#include "cf/geodesy/local_frame.h"
#include "escape.h"
#include "out_path.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

LocalFrame frameOf(const WorldRecord& world) {
  return LocalFrame(world.latitude_deg, world.longitude_deg, world.height_m);
}

std::vector<TimedPose> timed(const UavRecord& uav, const std::vector<PhotoPose>& poses) {
  std::vector<TimedPose> out;
  for (const auto& pose : poses) out.push_back({photoOf(uav, pose.photo).time, pose.T_world_cam});
  return out;
}

// So that coordinates stay short: 1e-9 degrees is 0.1 mm.
double rounded(double value, double step) { return std::round(value / step) * step; }

json coordinates(const LocalFrame& frame, const PhotoPose& pose) {
  const Geodetic g = frame.toGeodetic(pose.T_world_cam.translation());
  return {rounded(g.longitude_deg, 1e-9), rounded(g.latitude_deg, 1e-9), rounded(g.height_m, 1e-4)};
}

}  // namespace

void writeTrajectories(const RunRecord& run, const fs::path& outdir) {
  for (const auto& uav : run.uavs) {
    writeTum(outPath(outdir, "trajectories", uav.name + ".tum"), timed(uav, uav.final_trajectory));
    writeTum(outPath(outdir, "trajectories", uav.name + ".online.tum"),
             timed(uav, uav.online_trajectory));
    if (run.world.relative) continue;
    const LocalFrame frame = frameOf(run.world);
    CsvWriter csv(outPath(outdir, "trajectories", uav.name + ".ecef.csv"),
                  {"image", "t", "x", "y", "z"});
    for (const auto& pose : uav.final_trajectory) {
      const PhotoRecord& photo = photoOf(uav, pose.photo);
      const Eigen::Vector3d p = frame.toEcef(pose.T_world_cam.translation());
      csv.row({photo.name, timeText(photo.time), fmt::format("{:.4f}", p.x()),
               fmt::format("{:.4f}", p.y()), fmt::format("{:.4f}", p.z())});
    }
    csv.close();
  }
}

void writeCovariances(const RunRecord& run, const fs::path& outdir) {
  for (const auto& uav : run.uavs) {
    std::vector<PoseCovarianceRow> rows;
    for (const auto& [index, known] : uav.covariances) {
      const PhotoRecord& photo = photoOf(uav, index);
      rows.push_back({photo.name, photo.time, known.component, known.covariance});
    }
    writePoseCovariances(outPath(outdir, "trajectories", uav.name + ".covariance.csv"), rows);
  }
}

void writeOdometry(const RunRecord& run, const fs::path& outdir) {
  for (const auto& uav : run.uavs)
    writeTum(outPath(outdir, "odometry", uav.name + ".tum"), timed(uav, uav.local_trajectory));
}

void writeGeojson(const RunRecord& run, const fs::path& outdir) {
  if (run.world.relative) return;
  const LocalFrame frame = frameOf(run.world);
  json features = json::array();
  for (const auto& uav : run.uavs) {
    json line = json::array();
    for (const auto& pose : uav.final_trajectory) line.push_back(coordinates(frame, pose));
    if (line.size() > 1)
      features.push_back({{"type", "Feature"},
                          {"properties", {{"uav", uav.name}, {"photos", line.size()}}},
                          {"geometry", {{"type", "LineString"}, {"coordinates", line}}}});
    for (std::size_t i = 0; i < line.size(); ++i) {
      const PhotoRecord& photo = photoOf(uav, uav.final_trajectory[i].photo);
      features.push_back(
          {{"type", "Feature"},
           {"properties",
            {{"uav", uav.name}, {"image", photo.name}, {"time", isoText(photo.time)}}},
           {"geometry", {{"type", "Point"}, {"coordinates", line[i]}}}});
    }
  }
  const json all = {{"type", "FeatureCollection"}, {"features", features}};
  writeFileAtomically(outPath(outdir, "trajectories", "all.geojson"),
                      all.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

void writeKml(const RunRecord& run, const fs::path& outdir) {
  if (run.world.relative) return;
  const LocalFrame frame = frameOf(run.world);
  std::string kml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n"
      "<name>Trajectories</name>\n";
  for (const auto& uav : run.uavs) {
    if (uav.final_trajectory.empty()) continue;
    // aabbggrr; the central UAV is white as in the pictures.
    const char* colour = uav.name == run.world.center ? "ffffffff" : "ff00d6ff";
    kml += fmt::format(
        "<Placemark>\n<name>{}</name>\n<Style><LineStyle><color>{}</color><width>3</width>"
        "</LineStyle></Style>\n<LineString><altitudeMode>absolute</altitudeMode>\n<coordinates>\n",
        markupEscaped(uav.name), colour);
    for (const auto& pose : uav.final_trajectory) {
      const Geodetic g = frame.toGeodetic(pose.T_world_cam.translation());
      kml += fmt::format("{:.9f},{:.9f},{:.3f}\n", g.longitude_deg, g.latitude_deg, g.height_m);
    }
    kml += "</coordinates></LineString>\n</Placemark>\n";
  }
  kml += "</Document>\n</kml>\n";
  writeFileAtomically(outPath(outdir, "trajectories", "all.kml"), kml);
}

}  // namespace cf
