// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>
#include <utility>

#include "cf/base/log.h"

namespace cf {
namespace {

constexpr double kPoll_s = 0.1;
/// Of fewer it cannot be told whether one is far from the others.
constexpr std::size_t kFixesToStart = 3;

void pause() { std::this_thread::sleep_for(std::chrono::duration<double>(kPoll_s)); }

}  // namespace

PhotoFeed::PhotoFeed(std::vector<UavInput> inputs, const PlaybackOptions& options)
    : inputs_(std::move(inputs)), options_(&options) {}

std::size_t PhotoFeed::photosKnown() const {
  std::size_t count = 0;
  for (const UavInput& input : inputs_) count += input.photos().size();
  return count;
}

void PhotoFeed::awaitStart(std::size_t center) {
  constexpr double kSay_s = 2;
  const double since = wallSeconds();
  std::optional<double> other_since;
  bool said = false;
  const auto canStart = [](const UavInput& input) {
    return !input.photos().empty() && (input.isClosed() || input.fixes() >= kFixesToStart);
  };
  for (;; pause()) {
    look();
    const double now = wallSeconds();
    const bool over = std::all_of(inputs_.begin(), inputs_.end(),
                                  [](const UavInput& input) { return input.isClosed(); });
    if (over || canStart(inputs_[center])) return;
    const auto other = std::find_if(inputs_.begin(), inputs_.end(), canStart);
    if (other != inputs_.end() && !other_since) other_since = now;
    if (other_since && now - *other_since >= options_->hold_up_s) {
      logInfo(fmt::format("{} has no photos with fixes yet: the flight begins with {}",
                          inputs_[center].name(), other->name()));
      return;
    }
    if (!said && now - since > kSay_s) logInfo("waiting for the first photos and fixes");
    said = said || now - since > kSay_s;
  }
}

std::optional<PhotoFeed::Item> PhotoFeed::next() {
  for (;; pause()) {
    look();
    if (const auto input = ready()) return take(*input);
    waited_s_ = wallSeconds();
    const bool more = std::any_of(inputs_.begin(), inputs_.end(), [](const UavInput& input) {
      return !input.isClosed() || !input.photos().empty();
    });
    if (more) continue;
    if (finished_ == inputs_.size()) return std::nullopt;
    Item last{finished_++, {}, {}, wallSeconds()};
    last.fixes = inputs_[last.input].takeFixes(std::numeric_limits<TimeNs>::max());
    return last;
  }
}

/// Reads on, and judges whether the flight has ended.
void PhotoFeed::look() {
  const double now = wallSeconds();
  if (!follows() || ended_ || now - looked_s_ < kPoll_s) return;
  looked_s_ = now;
  double grown_s = 0;
  for (UavInput& input : inputs_) {
    input.look();
    grown_s = std::max(grown_s, input.grown_s());
  }
  ended_ = std::all_of(inputs_.begin(), inputs_.end(),
                       [](const UavInput& input) { return input.isClosed(); });
  if (ended_ || now - grown_s < options_->follow_s) return;
  logInfo(fmt::format("no rawlog has grown for {:g} s: the flight has ended", options_->follow_s));
  for (UavInput& input : inputs_) input.close();
  ended_ = true;
}

/// A file that does not come is given up: the photo is then reported as damaged.
bool PhotoFeed::isHere(UavInput::Waiting& waiting) const {
  return !follows() || waiting.file.isWhole() ||
         wallSeconds() - waiting.came_s >= options_->follow_s;
}

/// The next photo of `a` before that of `b`.
bool PhotoFeed::comesBefore(std::size_t a, std::size_t b) const {
  return std::pair(inputs_[a].photos().front().photo.time, a) <
         std::pair(inputs_[b].photos().front().photo.time, b);
}

/// That `other` may have, or has on its way, a photo before the next one of `first`.
bool PhotoFeed::holdsUp(std::size_t other, std::size_t first) const {
  const double now = wallSeconds();
  const UavInput& input = inputs_[other];
  const UavInput::Waiting& waiting = inputs_[first].photos().front();
  if (now - input.grown_s() >= options_->hold_up_s || now - waiting.came_s >= options_->hold_up_s)
    return false;
  if (!input.photos().empty()) return comesBefore(other, first);
  return input.knownUntil() < waiting.photo.time;
}

/// The input whose photo is to be taken up next, if it is time to.
std::optional<std::size_t> PhotoFeed::ready() {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    if (!inputs_[i].photos().empty() && isHere(inputs_[i].photos().front()))
      if (!first || comesBefore(i, *first)) first = i;
  if (!first || !follows()) return first;
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    if (i != *first && holdsUp(i, *first)) return std::nullopt;
  return first;
}

PhotoFeed::Item PhotoFeed::take(std::size_t input) {
  UavInput& from = inputs_[input];
  const UavInput::Waiting& waiting = from.photos().front();
  Item item{input, waiting.photo, from.takeFixes(waiting.photo.time),
            std::max(waiting.came_s, waited_s_)};
  from.photos().pop_front();
  return item;
}

}  // namespace cf
