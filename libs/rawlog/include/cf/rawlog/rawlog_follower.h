// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "cf/base/time.h"
#include "cf/rawlog/rawlog_reader.h"

namespace cf {

/// Reads a rawlog while it is written: readRecording() piece by piece. Compressed ones too, as far
/// as their writer has flushed what it holds back.
///
/// A photo is handed out when a record of a later time has come: all that belongs to it, its fix
/// above all, is there then, so that the pieces together are what readRecording() gives of the
/// complete rawlog, if it is in time order.
class RawlogFollower {
 public:
  /// The file need not be there yet.
  explicit RawlogFollower(std::filesystem::path rawlog, RawlogLabels labels = {});
  ~RawlogFollower();
  RawlogFollower(RawlogFollower&&) noexcept;

  /// What has become complete since the call before; without warnings. Throws as readRecording(),
  /// but for what may still come.
  UavRecording poll();
  /// The rest of what is there, and all warnings. The last call.
  UavRecording finish();

  /// Whole records so far.
  std::size_t records() const;
  /// No photo of this time or before is still to come.
  TimeNs knownUntil() const;
  /// The writer has said that nothing follows (RawlogWriter::finish()).
  bool ended() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cf
