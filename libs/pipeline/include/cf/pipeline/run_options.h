// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cf/align/aligner.h"
#include "cf/base/options.h"
#include "cf/deliver/deliver_options.h"
#include "cf/densify/densify.h"
#include "cf/fuse/fuse_options.h"
#include "cf/fuse/octomap_builder.h"
#include "cf/georeference/georeferencer.h"
#include "cf/odometry/odometry.h"
#include "cf/view/view_camera.h"

namespace cf {

class Config;

/// [world]
struct WorldOptions {
  std::string origin;  ///< "LAT, LON, H"; empty: the first fix of the central UAV
  void visit(OptionVisitor& v);
};

/// [cluster]
struct ClusterOptions {
  std::string center;  ///< name of the central UAV; empty: the first
  void visit(OptionVisitor& v);
};

/// [uav.<name>]
struct UavOptions {
  std::string name;
  std::string rawlog;       ///< path relative to the ini
  std::string image_label;  ///< empty: the only camera of the rawlog
  std::string gnss_label;   ///< empty: the only receiver of the rawlog
  std::string sigma;        ///< "H,V": replaces the fixes' standard deviations
  std::string camera;       ///< ini of a calibration: replaces the rawlog's
  void visit(OptionVisitor& v);
};

/// [gcp]
struct GcpOptions {
  std::string file;           ///< gcp_list.txt, relative to the ini; empty: none
  std::string use = "check";  ///< or control
  std::string size;           ///< "WxH" of the photos in which they were marked; empty: as recorded
  void visit(OptionVisitor& v);
};

/// [playback]
struct PlaybackOptions {
  double rate = 0;        ///< times real time; 0 = as fast as possible
  double max_gap_s = 60;  ///< longest pause between photos at a rate
  double follow_s = 0;    ///< rawlogs grow until none has for so long; 0 = they are complete
  double hold_up_s = 10;  ///< that a silent UAV holds up others that are followed
  double max_lag_s = 20;  ///< behind real time, from which on the live map leaves photos out
  double wait_s = 60;     ///< for an agent's next message
  bool inRealTime() const { return rate > 0 || follow_s > 0; }
  void visit(OptionVisitor& v);
};

/// [view]
struct ViewOptions {
  bool snapshots = true;
  double live_every_s = 0;       ///< between pictures of the growing map; 0 = none
  double live_megapixels = 0.3;  ///< matched for it
  std::string size = "1920x1080";
  void visit(OptionVisitor& v);
};

/// [system]
struct SystemOptions {
  int threads = 0;        ///< 0 = one for each core
  int max_memory_mb = 0;  ///< of the whole process; 0 = three quarters of the machine's
  void visit(OptionVisitor& v);
};

/// Everything that a run is told.
struct RunOptions {
  WorldOptions world;
  ClusterOptions cluster;
  std::vector<UavOptions> uavs;
  PlaybackOptions playback;
  OdometryOptions odometry;
  GeoreferenceOptions georeference;
  AlignOptions align;
  GcpOptions gcp;
  DensifyOptions densify;
  FuseOptions fuse;
  OctomapOptions octomap;
  DeliverOptions deliver;
  ViewOptions view;
  SystemOptions system;
};

/// Reads all sections; throws UsageError on anything unknown or out of range, on a configuration
/// without a UAV, and on a central UAV that is none of them.
RunOptions loadRunOptions(Config& config);

/// "A,B" or "A, B, C" as numbers; throws UsageError naming `what`.
std::vector<double> parseNumbers(const std::string& text, std::size_t count,
                                 const std::string& what);

}  // namespace cf
