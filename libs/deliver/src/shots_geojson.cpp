// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <nlohmann/json.hpp>

#include "cf/deliver/hand_over.h"
#include "cf/formats/atomic_file.h"
#include "cf/geodesy/grid_frame.h"
#include "geographic.h"
#include "out_path.h"

namespace cf {
namespace {

using Json = nlohmann::ordered_json;

Json triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json shotOf(const UavRecord& uav, const PhotoPose& pose, const LocalFrame& frame,
            const GridFrame& grid) {
  const PhotoRecord& photo = photoOf(uav, pose.photo);
  const CameraModel& camera = uav.camera_after;
  const Eigen::Vector3d centre = pose.T_world_cam.translation();
  const Eigen::Matrix3d R_grid_world = grid.T_grid_world(centre).rotation();
  const Eigen::AngleAxisd turn(
      Eigen::Matrix3d((R_grid_world * pose.T_world_cam.linear()).transpose()));
  return {{"type", "Feature"},
          {"properties",
           {{"filename", photo.name},
            {"camera", uav.name},
            {"focal", camera.fx / std::max(camera.width, camera.height)},
            {"width", camera.width},
            {"height", camera.height},
            {"capture_time", seconds(photo.time)},
            {"translation", triple(grid.toGrid(centre))},
            {"rotation", triple(turn.angle() * turn.axis())},
            {"uav", uav.name}}},
          {"geometry", {{"type", "Point"}, {"coordinates", lonLatHeight(frame, centre)}}}};
}

}  // namespace

void writeShotsGeojson(const RunRecord& run, const std::filesystem::path& outdir) {
  if (run.world.relative) return;
  const LocalFrame frame = frameOf(run.world);
  const GridFrame grid(frame, run.world.h_datum);
  Json shots = Json::array();
  for (const UavRecord& uav : run.uavs)
    for (const PhotoPose& pose : uav.final_trajectory)
      shots.push_back(shotOf(uav, pose, frame, grid));
  const Json all = {{"type", "FeatureCollection"}, {"features", std::move(shots)}};
  writeFileAtomically(outPath(outdir, "", "shots.geojson"),
                      all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace cf
