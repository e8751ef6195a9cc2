// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "cf/pipeline/run_options.h"
#include "cf/types/image_frame.h"

namespace cf {

/// Lets photos pass as far apart as they were taken, at [playback] rate times real time, but never
/// more than max_gap_s: a longer pause is cut and said.
class Pacer {
 public:
  /// `options` must outlive it.
  explicit Pacer(const PlaybackOptions& options) : options_(options) {}

  /// In order. Waits until the photo's moment has come, and returns it [wall seconds]; it may have
  /// passed. At a rate of 0 it is now.
  double await(const ImageFrame& photo);

 private:
  const PlaybackOptions& options_;
  struct Passed {
    TimeNs time = 0;
    double moment_s = 0;
  };
  std::optional<Passed> last_;
};

}  // namespace cf
