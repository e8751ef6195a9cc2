// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/arriving_file.h"

#include <fstream>
#include <system_error>

#include "cf/base/stopwatch.h"

namespace cf {
namespace {

constexpr double kQuiet_s = 10;

bool endsAsJpeg(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const auto marker = [&in] {
    const int first = in.get(), second = in.get();
    return first == 0xFF ? second : -1;
  };
  if (marker() != 0xD8) return false;
  in.seekg(-2, std::ios::end);
  return marker() == 0xD9;
}

}  // namespace

bool ArrivingFile::isWhole() {
  namespace fs = std::filesystem;
  std::error_code error;
  if (whole_ || !fs::is_regular_file(path_, error)) return whole_;
  const std::uintmax_t size = fs::file_size(path_, error);
  if (error || size == 0) return false;
  const fs::file_time_type written = fs::last_write_time(path_, error);
  const double now = wallSeconds();
  if (size != size_ || written != written_) {
    size_ = size;
    written_ = written;
    unchanged_since_s_ = now;
  }
  whole_ = endsAsJpeg(path_) || now - unchanged_since_s_ >= kQuiet_s;
  return whole_;
}

}  // namespace cf
