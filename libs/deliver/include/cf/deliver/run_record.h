// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cf/base/stopwatch.h"
#include "cf/base/time.h"
#include "cf/deliver/cloud_sketch.h"
#include "cf/deliver/ground_control_record.h"
#include "cf/deliver/self_check.h"
#include "cf/types/camera_model.h"
#include "cf/types/gnss_fix.h"
#include "cf/types/keyframe.h"
#include "cf/types/photo_record.h"
#include "cf/types/pose_table.h"
#include "cf/types/seam_point.h"

namespace cf {

/// As images/<uav>.csv names it.
const char* name(PhotoStatus status);

/// How well a final pose is known.
struct PhotoCovariance {
  int component = 0;  ///< photos joined by matches share one
  PoseCovariance covariance;
};

/// Something that whoever uses the map should know, and what can be done about it.
struct Warning {
  std::string text;
  std::string advice;  ///< may be empty

  Warning(std::string what, std::string to_do = {})  // NOLINT: a sentence is a warning
      : text(std::move(what)), advice(std::move(to_do)) {}
};

/// How long one photo took.
struct PhotoLatency {
  FrameId photo;
  double taken_s = 0;    ///< when it was taken up, since the run began
  double latency_s = 0;  ///< until first something of it was in the map
};

/// Memory in use at one time of the run.
struct MemorySample {
  double time_s = 0;  ///< since it began
  double rss_mb = 0;
};

struct UavRecord {
  std::string name;
  std::vector<PhotoRecord> photos;                       ///< in time order
  std::vector<PhotoPose> final_trajectory;               ///< by photo; those of status posed
  std::map<std::uint32_t, PhotoCovariance> covariances;  ///< of final poses, by photo; if known
  std::vector<PhotoPose> online_trajectory;  ///< as known when each photo had been processed
  /// By photo: T_local_cam of its segment in VO units, in place of T_world_cam.
  std::vector<PhotoPose> local_trajectory;
  CameraModel camera_before, camera_after;
  std::vector<ScaleRow> scale_history;  ///< in time order
  GnssQuality gnss;
  /// By photo: what its receiver said, in the world at the photo's time, with the σ that it tags.
  std::map<std::uint32_t, GnssPosition> fixes;
  int segments = 0;
  std::string pose_graph;              ///< MRPT's text form
  std::filesystem::path photo_folder;  ///< where its photos lie, if they are at hand
};

/// The frame of everything delivered: ENU at a WGS84 origin, or, relative, a local frame of
/// arbitrary origin and heading (and scale) because no photo had a GNSS position.
struct WorldRecord {
  bool relative = false;
  double latitude_deg = 0, longitude_deg = 0, height_m = 0;  ///< of the origin
  HeightDatum h_datum = HeightDatum::kUnknown;
  std::string utm;     ///< "15N"
  std::string center;  ///< name of the central UAV
};

/// How a run kept up with a flight.
struct RealTimeRecord {
  double most_behind_s = 0;       ///< that a photo was taken up after it could have been
  std::size_t left_out_live = 0;  ///< photos that the live map is without
};

/// Everything that a run knows at its end.
struct RunRecord {
  std::string version;
  WorldRecord world;
  std::vector<UavRecord> uavs;  ///< in the order of the configuration: FrameId::uav
  std::vector<RelativePose> relative_poses;
  std::vector<SparsePoint> sparse_points;
  /// Where the photos saw them, of all their observations in order: distorted, pixels of the photo
  /// as recorded. Empty: not kept.
  std::vector<Eigen::Vector2f> sparse_pixels;
  std::vector<SeamPoint> seam_points;
  CloudSketch cloud;  ///< empty: no dense map
  std::map<std::string, StageSeconds> stages;
  std::vector<PhotoLatency> latencies;      ///< of photos that are in the map, in order
  std::vector<MemorySample> memory;         ///< in time order
  std::optional<RealTimeRecord> real_time;  ///< none: as fast as possible
  std::uint64_t bytes_over_seam = 0;
  double wall_s = 0;
  double peak_rss_mb = 0;
  int components = 0;                                 ///< groups of photos joined by matches
  std::optional<GroundControlRecord> ground_control;  ///< none: no list was given
  std::vector<SelfCheck> self_check;                  ///< selfCheck() of all this
  std::vector<Warning> warnings;
};

}  // namespace cf
