// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <filesystem>

#include "cf/formats/seam_file.h"
#include "cf/pipeline/run_options.h"
#include "step_source.h"

namespace cf {

/// Follows the files in which the agents of all UAVs write. An agent whose next message does not
/// come for [playback] wait_s is taken to have ended: a warning, and what came is used.
class SeamSteps : public StepSource {
 public:
  /// Waits for all UAVs' first messages in <folder>/<uav>.seam. Throws RunError where a file is
  /// damaged or is not that of the configuration's UAV.
  SeamSteps(const std::filesystem::path& folder, const RunOptions& options);

  tbb::filter<void, Step> steps() override;
  std::vector<SeamDone> done() override;
  std::uint64_t bytes() const override;

 private:
  struct Stream {
    std::filesystem::path path;
    SeamReader reader;
    bool stopped = false;
    SeamDone done;  ///< as far as it is known
  };
  struct Place {
    std::size_t uav = 0;
    std::uint32_t photo = 0;  ///< one past the last: the UAV's last step
  };
  /// Of all steps.
  std::vector<Place> order() const;
  ImageFrame photoAt(const Place& place) const;
  bool isLast(const Place& place) const { return place.photo == hellos_[place.uav].photos.size(); }
  Step next(tbb::flow_control& control);
  void begin(std::uint16_t uav, const std::string& name);
  std::optional<SeamMessage> await(Stream& stream) const;
  void stop(std::size_t uav, std::size_t photos);
  void note(std::size_t uav, const ChainStep& step, const Place& place);
  void finish(std::size_t uav);

  const double wait_s_;
  std::deque<Stream> streams_;
  std::vector<Place> order_;
  std::size_t next_ = 0;
};

}  // namespace cf
