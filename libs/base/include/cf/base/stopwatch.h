// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <string>

namespace cf {

/// Wall and CPU seconds of one stage, summed over its calls.
struct StageSeconds {
  double wall_s = 0;
  double cpu_s = 0;  ///< CPU seconds of the whole process while the stage ran
};

/// Sums the time spent in each named stage; thread-safe.
class StageTimes {
 public:
  /// Adds the time from construction to destruction to one stage.
  class Scope {
   public:
    Scope(StageTimes& times, std::string stage);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    StageTimes& times_;
    std::string stage_;
    double wall_start_;
    double cpu_start_;
  };

  std::map<std::string, StageSeconds> all() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, StageSeconds> seconds_;
};

double wallSeconds();
double processCpuSeconds();
double peakRssMegabytes();

}  // namespace cf
