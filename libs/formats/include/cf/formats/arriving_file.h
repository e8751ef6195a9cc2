// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>

namespace cf {

/// A photo's file that may still be on its way: not there yet, or being copied.
class ArrivingFile {
 public:
  explicit ArrivingFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// It is complete: it ends as a JPEG does, or, of whatever kind, nothing was written to it for
  /// ten seconds, as far as one can tell from earlier calls. Once true, always true.
  bool isWhole();

 private:
  std::filesystem::path path_;
  bool whole_ = false;
  std::uintmax_t size_ = 0;
  std::filesystem::file_time_type written_{};
  double unchanged_since_s_ = 0;
};

}  // namespace cf
