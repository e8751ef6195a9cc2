// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "cf/pipeline/run_options.h"
#include "cf/types/image_frame.h"

namespace cf {

/// What decides how much memory a run takes.
struct FlightSize {
  std::size_t photos = 0;  ///< as far as they are known
  double photo_mp = 0;     ///< the largest, as recorded; 0: they are not decoded here
  void add(const ImageFrame& photo);
};

/// How much of a run is in memory at once, so that it stays below [system] max_memory_mb. Results
/// do not depend on it.
struct MemoryPlan {
  double limit_mb = 0;
  double least_mb = 0;                ///< about what the run takes when it saves wherever it can
  std::size_t steps_in_flight = 16;   ///< photos between their rawlogs and the live map
  std::size_t photos_in_memory = 12;  ///< decoded for dense matching
  std::size_t photos_matched = 3;     ///< on their way through dense matching and fusion
  int tile_mb = 300;                  ///< of tiles; [fuse] max_memory_mb at most
  int crops_mb = 300;                 ///< of photos' parts for the orthophoto
  bool side_by_side = true;           ///< DSM and OctoMap, orthophoto and pictures
};

/// [system] max_memory_mb, or three quarters of what the machine has, or lets us have.
double memoryLimit(const RunOptions& options);

/// By figures measured on flights (docs/architecture.md).
MemoryPlan planMemory(const RunOptions& options, const FlightSize& flight);

/// A line about a run that does not fit: what it needs and what would lessen that. Empty: it fits.
std::string objectionTo(const MemoryPlan& plan, const RunOptions& options,
                        const FlightSize& flight);

}  // namespace cf
