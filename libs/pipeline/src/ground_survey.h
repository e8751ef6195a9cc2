// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cf/align/aligner.h"
#include "cf/deliver/run_record.h"
#include "cf/evaluate/marked_points.h"
#include "cf/pipeline/run_options.h"
#include "uav_input.h"
#include "world.h"

namespace cf {

/// The ground points of [gcp]: read at the beginning, so that what is wrong with them is known
/// before the flight is played; held against the map, or the map brought onto them, at its end.
class GroundSurvey {
 public:
  /// Throws UsageError on a list that cannot be used as it is to be.
  GroundSurvey(const std::filesystem::path& file, const GcpOptions& options);

  bool controls() const { return control_; }
  /// Of complete recordings: throws UsageError where none of the marked photos is among theirs, and
  /// as joinMarks() where marks do not fit them.
  void checkPhotos(const std::vector<UavInput>& inputs) const;
  /// What the final map has to do with them goes into the record. As control, moves the map onto
  /// them by a similarity; a relative map gets its place on earth by that, and heights count from
  /// what those of the list do. Throws RunError where that cannot be done.
  void apply(World& world, Alignment& alignment, RunRecord& record) const;

 private:
  struct Placed;
  MapPhotos photosOf(const Alignment& alignment, const RunRecord& record) const;
  void warnOfUnknownPhotos(RunRecord& record) const;
  Placed place(const World& world, const Alignment& alignment, RunRecord& record) const;

  GcpList list_;
  std::vector<Geodetic> places_;  ///< of its points
  HeightDatum datum_ = HeightDatum::kUnknown;
  std::optional<PhotoSize> size_;
  bool control_ = false;
};

}  // namespace cf
