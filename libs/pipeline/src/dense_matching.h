// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <filesystem>

#include "cf/base/result.h"
#include "cf/base/stopwatch.h"
#include "cf/densify/densify.h"
#include "cf/types/depth_frame.h"
#include "photo_store.h"
#include "stereo_pairs.h"

namespace cf {

/// Depth frames of stereo pairs, kept in a folder as they are matched: what an interrupted run has
/// left there need not be matched again. Thread-safe for different pairs.
class DenseMatching {
 public:
  /// What is given by reference must outlive it.
  DenseMatching(std::filesystem::path folder, const DensifyOptions& options, PhotoStore& photos,
                StageTimes& times);

  /// The pair's depth for the poses and cameras that it has now. Failures: those of matchPair, and
  /// "no_photo".
  Result<DepthFrame> frame(const StereoPair& pair);
  int found() const { return found_; }  ///< pairs that had been matched by an earlier run

 private:
  std::filesystem::path file(const StereoPair& pair) const;

  const std::filesystem::path folder_;
  const DensifyOptions& options_;
  PhotoStore& photos_;
  StageTimes& times_;
  std::atomic<int> found_{0};
};

}  // namespace cf
