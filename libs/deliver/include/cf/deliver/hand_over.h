// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "cf/deliver/run_record.h"

namespace cf {

/// The result as other programs take it (docs/products.md). Each writes into OUTDIR, which is made
/// if need be; RunError names a file that cannot be written.

/// colmap/: the photos with a pose, the cameras and the sparse points as COLMAP's text model.
/// World coordinates are the map's ENU, colmap/origin.txt says where that is; poses are
/// T_cam_world; pixels count from the photo's corner, half a pixel more than CameraModel's. An
/// image is called <uav>/<photo>, and colmap/images/<uav> is a link to the folder of the UAV's
/// photos, if they are at hand.
void writeColmapModel(const RunRecord& run, const std::filesystem::path& outdir);

/// shots.geojson as OpenDroneMap's report has it: a point for each photo with a pose, in WGS84.
/// Properties: filename, camera, focal (focal length over the photo's longer side), width, height
/// [px], capture_time [s since 1970], translation (camera centre in the UTM zone of the origin
/// [m]), rotation (rotation vector [rad] from the axes of that grid to those of the camera), and
/// uav. Nothing is written for a relative map; the same holds for map.kml.
void writeShotsGeojson(const RunRecord& run, const std::filesystem::path& outdir);

/// map.kml: the UAVs' tracks, the photos and the outline of the map (hull of the ground that three
/// photos see).
void writeMapKml(const RunRecord& run, const std::filesystem::path& outdir);

/// All of them.
void handOver(const RunRecord& run, const std::filesystem::path& outdir);

}  // namespace cf
