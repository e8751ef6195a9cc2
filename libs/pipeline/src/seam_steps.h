// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <filesystem>
#include <optional>

#include "cf/formats/seam_file.h"
#include "cf/geodesy/local_frame.h"
#include "cf/pipeline/run_options.h"
#include "step_source.h"

namespace cf {

/// Follows the files in which the agents of all UAVs write, and merges their photos in time order.
///
/// Of complete recordings each agent says when its next photo was taken, and the one that is next
/// is waited for; an agent whose message does not come for [playback] wait_s is taken to have
/// ended: a warning, and what came is used. Agents that follow rawlogs do not know their next
/// photos: with [playback] follow_s a photo waits until no other agent can have an earlier one, or
/// has been silent, or the photo has waited, for hold_up_s; agents may come late; the flight has
/// ended when all have said so, or none has written anything for follow_s and wait_s.
class SeamSteps : public StepSource {
 public:
  /// Waits for the first messages in <folder>/<uav>.seam: those of all UAVs, or, following, for one
  /// that the map can begin with. Throws RunError where a file is damaged or is not that of the
  /// configuration's UAV.
  SeamSteps(const std::filesystem::path& folder, const RunOptions& options);

  /// Throws RunError, now or when it comes, for an agent that georeferences elsewhere.
  void requireOrigin(const Geodetic& origin);

  bool follows() const override { return options_.follow_s > 0; }
  tbb::filter<void, Step> steps() override;
  std::vector<SeamDone> done() override;
  std::uint64_t bytes() const override;

 private:
  /// The next message of an agent, that was not taken yet.
  struct Head {
    SeamStep message;
    double came_s = 0;
  };
  struct Stream {
    explicit Stream(const std::filesystem::path& file) : path(file), reader(file) {}
    const std::filesystem::path path;
    SeamReader reader;
    std::optional<Head> head;
    double grown_s = 0;    ///< wall time of its newest message
    bool greeted = false;  ///< its Hello has come
    bool stopped = false;  ///< nothing more is waited for
    std::size_t came = 0;  ///< photos
    TimeNs next_from = 0;  ///< of photos that came no more is older
    SeamDone done;         ///< as far as it is known
  };
  void awaitStart(std::size_t center);
  bool look(std::size_t uav);
  void greet(std::size_t uav, SeamHello hello);
  void checkOrigin(const SeamHello& hello) const;
  bool comesBefore(std::size_t a, std::size_t b) const;
  bool holdsUp(std::size_t other, std::optional<std::size_t> first) const;
  Step next(tbb::flow_control& control);
  Step take(std::size_t uav);
  Step takeLast(std::size_t uav);
  bool isSilent(std::size_t uav);
  double longestWait() const { return options_.wait_s + (follows() ? options_.follow_s : 0); }
  void stop(std::size_t uav);
  void note(std::size_t uav, const SeamStep& message);
  void finish(std::size_t uav);

  const PlaybackOptions& options_;
  std::deque<Stream> streams_;
  std::optional<Geodetic> origin_;
  double waiting_since_ = 0;  ///< wall time
  bool said_ = false;         ///< that it waits
  std::size_t finished_ = 0;  ///< streams whose last step was given
};

}  // namespace cf
