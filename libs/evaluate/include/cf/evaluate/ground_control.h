// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cf/geometry/similarity.h"

namespace cf {

/// Size of the photos in which somebody marked points [px].
struct PhotoSize {
  int width = 0, height = 0;
};

struct GroundControlOptions {
  /// How the triangulated points are brought onto the surveyed ones; none: as they are.
  std::optional<AlignmentModel> align;
  /// Of the photos that the list was made with, if not the run's; errors are then in its pixels.
  std::optional<PhotoSize> size;
};

/// Triangulates the points of a gcp_list.txt (libs/formats) with the poses and refined cameras of a
/// run, whose world.json says where the map lies: each point from all photos with a pose in which
/// it is marked, least squares in pixels. One JSON object as docs/evaluation.md describes it.
/// Throws UsageError on a list that cannot be understood, RunError where the run's files are not
/// there, the marks do not fit its photos, or the points cannot be aligned.
std::string evaluateGroundControl(const std::filesystem::path& out_dir,
                                  const std::filesystem::path& gcp_list,
                                  const GroundControlOptions& options);

}  // namespace cf
