// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "uav_input.h"

namespace cf {

/// The photos of all UAVs in time order (ties by UAV), each with the fixes until then.
///
/// Of complete rawlogs the order is theirs alone. Rawlogs that grow are merged in the same order as
/// long as every one keeps coming: a photo waits until no other UAV can have an earlier one, or has
/// been silent, or the photo has waited, for [playback] hold_up_s. Photos whose files are not whole
/// yet are waited for, beside those of the other UAVs. The flight has ended when the writers of all
/// rawlogs have said so, or none has grown for [playback] follow_s.
class PhotoFeed {
 public:
  /// `options` must outlive it.
  PhotoFeed(std::vector<UavInput> inputs, const PlaybackOptions& options);

  bool follows() const { return options_->follow_s > 0; }
  const std::vector<UavInput>& inputs() const { return inputs_; }
  /// Those that came so far and were not taken up.
  std::size_t photosKnown() const;

  /// Following: waits until the map can be given a place: the UAV `center` (among the inputs) has
  /// photos and fixes, or another had for hold_up_s, or the flight has ended.
  void awaitStart(std::size_t center);

  struct Item {
    std::size_t input = 0;
    std::optional<ImageFrame> photo;  ///< none after the input's last
    std::vector<GnssFix> fixes;       ///< that were not given before, up to the photo's time
    double ready_s = 0;               ///< wall time from which on it could have been taken
  };
  /// The next one, when it is there; none after the last of all.
  std::optional<Item> next();

 private:
  void look();
  bool isHere(UavInput::Waiting& waiting) const;
  bool comesBefore(std::size_t a, std::size_t b) const;
  bool holdsUp(std::size_t other, std::size_t first) const;
  std::optional<std::size_t> ready();
  Item take(std::size_t input);

  std::vector<UavInput> inputs_;
  const PlaybackOptions* options_;
  double looked_s_ = 0;
  double waited_s_ = 0;       ///< wall time until which nothing was ready
  bool ended_ = false;        ///< said that it has
  std::size_t finished_ = 0;  ///< inputs whose last item was given
};

}  // namespace cf
