// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace cf {

struct ChangeOptions {
  /// Gets difference.tif, sigma.tif, significance.tif, change.png and change.json; it is made.
  std::filesystem::path outdir;
  std::optional<double> cell_m;  ///< of the rasters; none: the finer of both surface models
  double min_area_m2 = 1;        ///< of a change that is listed and coloured
  int min_views = 2;             ///< depth frames that must have seen a surface, in either run
};

/// What has changed between two runs of one place: brings B onto A by the ground that stayed, takes
/// the differences of height B - A and says how significant they are. One JSON object as
/// docs/change.md describes it; the files of ChangeOptions. Throws RunError where a run has no
/// surface model, has no place on earth, or has too little ground in common with the other.
std::string evaluateChange(const std::filesystem::path& out_a, const std::filesystem::path& out_b,
                           const ChangeOptions& options);

}  // namespace cf
