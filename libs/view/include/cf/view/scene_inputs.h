// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cf {

/// A point of the coloured cloud, world frame. Floats hold a millimetre out to 8 km.
struct ColouredPoint {
  Eigen::Vector3f position_m = Eigen::Vector3f::Zero();
  std::uint8_t rgb[3] = {0, 0, 0};
};

/// An occupied voxel of the OctoMap: an axis-parallel cube and which of its faces are exposed.
struct Voxel {
  Eigen::Vector3f centre_m = Eigen::Vector3f::Zero();
  float size_m = 0;
  std::uint8_t rgb[3] = {0, 0, 0};
  std::uint8_t faces = 0;  ///< bits: -x 1, +x 2, -y 4, +y 8, -z 16, +z 32
};

/// The final trajectory of one UAV, world frame, in time order.
struct UavTrack {
  std::string name;
  bool central = false;
  std::vector<Eigen::Vector3d> positions_m;  ///< camera centres
};

/// The two camera centres of a relative pose between two UAVs, world frame. Of those that a photo
/// has with one other UAV, the one with most inliers is shown; of very many, an even sample.
struct RelativeLink {
  Eigen::Vector3d a_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d b_m = Eigen::Vector3d::Zero();
};

/// Everything that a picture of a run shows.
struct SceneInputs {
  std::vector<ColouredPoint> cloud;
  std::vector<UavTrack> tracks;  ///< by name
  std::vector<RelativeLink> links;
  std::vector<Voxel> voxels;   ///< loaded only when asked for
  bool georeferenced = true;   ///< false: a relative map; neither north nor metres are known
  double origin_height_m = 0;  ///< height of the world's origin above its datum
  std::string height_datum = "unknown";  ///< ellipsoid | msl | unknown
};

/// What to read and how much of it.
struct SceneLimits {
  std::size_t max_points = 4'000'000;  ///< a larger cloud is thinned evenly at random, fixed seed
  std::size_t max_voxels = 600'000;    ///< a larger OctoMap is shown at a coarser level
  bool with_cloud = true;
  bool with_voxels = false;
};

/// Reads a run's output folder (DESIGN's output contract): cloud/cloud.ply, trajectories/*.tum,
/// images/*.csv, relative_poses.csv, world.json, octomap.ot. Trajectories, relative poses and
/// world.json may be absent; throws RunError if the cloud or OctoMap asked for is absent or broken,
/// UsageError if the folder is not there.
SceneInputs loadScene(const std::filesystem::path& outdir, const SceneLimits& limits = {});

}  // namespace cf
