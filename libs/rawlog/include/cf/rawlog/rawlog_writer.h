// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "cf/types/gnss_fix.h"
#include "cf/types/image_frame.h"

namespace cf {

/// Sensor labels in a rawlog. Empty, when reading: the only sensor of that kind.
struct RawlogLabels {
  std::string image_label;
  std::string gnss_label;
};

/// The folder that holds the external images of a rawlog: "<dir>/<stem>_Images".
std::filesystem::path imagesFolderOf(const std::filesystem::path& rawlog);

/// Writes one UAV's recording as an MRPT rawlog (docs/rawlog.md), gzip-compressed. Records should
/// be written in time order; MRPT keeps times in units of 100 ns, to which they are rounded down.
class RawlogWriter {
 public:
  enum class Visible {
    kWhenFinished,  ///< the file appears under its name when finish() has succeeded
    kAtOnce         ///< and grows there for others to follow: each flush() is on disk
  };
  /// Throws RunError if the file cannot be written.
  explicit RawlogWriter(const std::filesystem::path& rawlog,
                        const RawlogLabels& labels = {"CAMERA", "GPS"},
                        Visible visible = Visible::kWhenFinished);
  /// Without finish() a file that is not visible yet is removed.
  ~RawlogWriter();
  RawlogWriter(const RawlogWriter&) = delete;
  RawlogWriter& operator=(const RawlogWriter&) = delete;

  /// Everything of the photo but its pixels. `photo.file` must lie inside imagesFolderOf(rawlog);
  /// it need not exist yet.
  void write(const ImageFrame& photo);
  void write(const GnssFix& fix);
  /// Everything written is in the file afterwards.
  void flush();
  /// Notes that nothing follows, closes the file and gives it its name. Throws RunError if it could
  /// not be written completely.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cf
