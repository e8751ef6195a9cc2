// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tbb/parallel_pipeline.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cf/formats/seam_message.h"
#include "cf/types/image_frame.h"

namespace cf {

/// A step on its way to the centre.
struct SourceStep {
  ChainStep step;
  std::optional<ImageFrame> photo;  ///< without pixels; none: what is left after the UAV's last
  double taken_s = 0;               ///< wall time at which the photo was there to be taken up
};

/// Where the steps of all UAVs come from: chains in this process (ChainSteps), or files in which
/// other processes write them (SeamSteps). Whatever it is, it gives the same steps in the same
/// order: of photos in time order (ties by UAV), of each UAV in the order of their numbers, then
/// the last of each UAV.
class StepSource {
 public:
  using Step = std::shared_ptr<SourceStep>;

  virtual ~StepSource() = default;
  StepSource(const StepSource&) = delete;
  StepSource& operator=(const StepSource&) = delete;

  /// What each UAV has said first; of one that has said nothing yet its number and name.
  const std::vector<SeamHello>& hellos() const { return hellos_; }
  /// Of all UAVs, as far as it is known at the start; of a recording that grows at least one.
  virtual std::size_t photoCount() const;
  /// More may come.
  virtual bool follows() const { return false; }

  /// The first stages of a pipeline that is run once; the source must outlive it.
  virtual tbb::filter<void, Step> steps() = 0;

  /// After that: what each UAV has said last.
  virtual std::vector<SeamDone> done() = 0;
  /// That crossed the seam, or would have.
  virtual std::uint64_t bytes() const = 0;
  /// What was wrong; already logged.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// That a photo was taken up later than its moment, in real time.
  double mostBehind_s() const { return most_behind_s_; }

 protected:
  StepSource() = default;

  std::vector<SeamHello> hellos_;
  std::vector<std::string> warnings_;
  double most_behind_s_ = 0;
};

}  // namespace cf
