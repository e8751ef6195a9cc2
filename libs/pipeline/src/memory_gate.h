// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>

namespace cf {

/// Holds photos back while the process has nine tenths of the memory that it may have, as long as
/// others that are under way can be expected to give some back. Thread-safe.
///
/// It never stops a pipeline: a photo that is alone goes on, and any does when none that is under
/// way has come to its end for two seconds (they may be waiting for the thread that waits here).
class MemoryGate {
 public:
  explicit MemoryGate(double limit_mb) : full_mb_(0.9 * limit_mb) {}

  /// Before a photo is taken up.
  void enter();
  /// When it has come to its end.
  void leave();

 private:
  const double full_mb_;
  std::mutex mutex_;
  std::condition_variable left_;
  std::size_t inside_ = 0;
  std::size_t count_ = 0;  ///< that came to their end
};

}  // namespace cf
