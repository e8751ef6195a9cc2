// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cf/deliver/deliver.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/csv.h"
#include "cf/formats/pose_covariance_csv.h"
#include "cf/formats/tum.h"
#include "geographic.h"
#include "out_path.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<TimedPose> timed(const UavRecord& uav, const std::vector<PhotoPose>& poses) {
  std::vector<TimedPose> out;
  for (const auto& pose : poses) out.push_back({photoOf(uav, pose.photo).time, pose.T_world_cam});
  return out;
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
    for (const auto& pose : uav.final_trajectory)
      line.push_back(lonLatHeight(frame, pose.T_world_cam.translation()));
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

}  // namespace cf
