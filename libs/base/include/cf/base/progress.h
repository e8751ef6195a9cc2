// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace cf {

/// Progress with rate and time left on stderr: one rewritten line on a terminal, a plain line at
/// most every five seconds otherwise.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();
  /// `note` is appended, e.g. the scale and inliers of the last photo.
  void advance(const std::string& note = {});

 private:
  using Clock = std::chrono::steady_clock;
  void print(const std::string& note, bool last);

  std::string what_;
  std::size_t total_;
  std::size_t done_ = 0;
  bool terminal_;
  Clock::time_point start_;
  Clock::time_point printed_;
};

}  // namespace cf
