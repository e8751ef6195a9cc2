// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <mutex>
#include <string>

namespace cf {

/// Time of one stage.
struct StageSeconds {
  double wall_s = 0;  ///< during which the stage was at work on at least one thread
  double cpu_s = 0;
};

/// Whose CPU seconds a scope counts: its own thread's, or, where it is all that runs and spreads
/// over threads itself, the process's.
enum class CpuClock { kThread, kProcess };

/// Sums the time spent in each named stage; thread-safe.
class StageTimes {
 public:
  /// Adds the time from construction to destruction to one stage.
  class Scope {
   public:
    Scope(StageTimes& times, std::string stage, CpuClock clock = CpuClock::kThread);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    StageTimes& times_;
    std::string stage_;
    CpuClock clock_;
    double cpu_start_;
  };

  std::map<std::string, StageSeconds> all() const;

 private:
  struct Stage {
    StageSeconds sum;
    int active = 0;
    double active_since = 0;
  };
  mutable std::mutex mutex_;
  std::map<std::string, Stage> stages_;
};

double wallSeconds();
double threadCpuSeconds();
double processCpuSeconds();
double peakRssMegabytes();

}  // namespace cf
