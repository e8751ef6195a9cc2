// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace cf {

class Config;

/// One UAV's part of a run by itself: odometry and georeference, as they can run aboard. The body
/// of cf-run --role agent.
struct AgentRequest {
  std::string uav;             ///< name in the configuration
  std::filesystem::path seam;  ///< folder in which its messages go to <uav>.seam
  bool overwrite = false;      ///< of an earlier file
  bool resume = false;         ///< go on with the file that an interrupted agent has left
};

struct AgentSummary {
  std::size_t photos = 0;
  std::uint64_t bytes = 0;  ///< written
  std::filesystem::path file;
};

/// Plays the UAV's rawlog, or follows it while it grows. Resumed, the rawlog is played from its
/// start, and what the file holds already is compared instead of written. Throws UsageError for a bad configuration, and where the origin of the
/// world that all share is not known; RunError for what cannot be read or written.
AgentSummary runAgent(Config& config, const AgentRequest& request);

}  // namespace cf
