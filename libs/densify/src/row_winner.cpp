// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "row_winner.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "cf/densify/stereo_matcher.h"

namespace cf {
namespace {

constexpr int kNone = -1;
constexpr Lanes kOrder = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
constexpr Cost kMaxSum = INT16_MAX / kLanes - 1;  // so that a sum and a lane fit one number

/// Index of the least of the sums; of several, the first.
CF_INLINE int winnerOf(const Cost* sum, int n) {
  int winner = 0;
  Cost least = INT16_MAX;
  for (int d = 0; d < n; d += kLanes) {
    const Lanes bounded = lesser(load<Lanes>(sum + d), Lanes{} + kMaxSum);
    const Cost best = leastOf(bounded * kLanes + kOrder);
    if (best / kLanes >= least) continue;
    least = static_cast<Cost>(best / kLanes);
    winner = d + best % kLanes;
  }
  return winner;
}

/// The partner's least sum and the reference pixel it belongs to, along one pixel's disparities.
CF_INLINE void collectPixel(const Cost* sum, int n, Cost u, Cost* least, Cost* match) {
  int d = 0;
  for (; d + kLanes <= n; d += kLanes) {
    const Lanes s = load<Lanes>(sum + d), l = load<Lanes>(least + d);
    const Lanes m = s < l ? Lanes{} + u : load<Lanes>(match + d);
    const Lanes kept = lesser(s, l);
    std::memcpy(match + d, &m, sizeof m);
    std::memcpy(least + d, &kept, sizeof kept);
  }
  for (; d < n; ++d) {
    if (sum[d] >= least[d]) continue;
    least[d] = sum[d];
    match[d] = u;
  }
}

/// Each pixel's winner, and the least sums that the partner's pixels see and whose they are.
CF_INLINE void collect(const Cost* sum, const RowLayout& layout, int partner_width, int* best,
                       Cost* partner_least, Cost* partner_match) {
  const int width = static_cast<int>(layout.min.size());
  // The part of the partner's row that the last pixel saw. From one pixel to the next it moves by
  // one: it stays in registers meanwhile (from memory it would come back late).
  Lanes least{}, match{};
  int held = kNone;  // where that part begins
  const auto release = [&] {
    if (held == kNone) return;
    std::memcpy(&partner_least[held], &least, sizeof least);
    std::memcpy(&partner_match[held], &match, sizeof match);
    held = kNone;
  };
  for (int u = 0; u < width; ++u) {
    const auto k = static_cast<std::size_t>(u);
    const Cost* s = sum + layout.start[k];
    const int n = layout.count[k];
    if (n == 0) continue;
    best[k] = winnerOf(s, n);
    const int first = partner_width - 1 - (u - layout.min[k]);
    if (n != kLanes || first < 0 || first + n > partner_width) {
      release();
      const int d0 = std::max(0, -first), at = std::max(0, first);
      const int usable = std::min(n - d0, partner_width - at);
      if (usable <= 0) continue;
      collectPixel(s + d0, usable, static_cast<Cost>(u), &partner_least[at], &partner_match[at]);
      continue;
    }
    Cost* const least_at = &partner_least[first];
    Cost* const match_at = &partner_match[first];
    if (held == first + 1) {
      least_at[kLanes] = least[kLanes - 1];
      match_at[kLanes] = match[kLanes - 1];
      least = fromBelow(least, *least_at);
      match = fromBelow(match, *match_at);
    } else {
      release();
      least = load<Lanes>(least_at);
      match = load<Lanes>(match_at);
    }
    held = first;
    const Lanes here = load<Lanes>(s);
    match = here < least ? Lanes{} + static_cast<Cost>(u) : match;
    least = lesser(here, least);
  }
  release();
}

CF_CLONES void winners(const Cost* sum, const RowLayout& layout, int partner_width, int* best,
                       Cost* partner_least, Cost* partner_match, std::int16_t* disparity) {
  const int width = static_cast<int>(layout.min.size());
  collect(sum, layout, partner_width, best, partner_least, partner_match);
  for (int u = 0; u < width; ++u) {
    const auto k = static_cast<std::size_t>(u);
    disparity[u] = kNoDisparity;
    const Cost* s = sum + layout.start[k];
    const int n = layout.count[k], d = best[k];
    if (n == 0) continue;
    const int x = u - layout.min[k] - d;
    if (x < 0 || x >= partner_width) continue;
    const int mutual = partner_match[partner_width - 1 - x];
    if (std::abs(mutual - u) > 1) continue;
    if (d == 0 || d == n - 1) continue;  // the minimum may lie beyond
    const int left = s[d - 1] - s[d], right = s[d + 1] - s[d];
    const int part = left + right > 0 ? (16 * (left - right)) / (2 * (left + right)) : 0;
    disparity[u] = static_cast<std::int16_t>(16 * (layout.min[k] + d) + part);
  }
}

}  // namespace

RowWinner::RowWinner(int width, int partner_width, int max_count)
    : partner_width_(partner_width),
      best_(static_cast<std::size_t>(width)),
      // Runs from right to left, so that it is read upwards with growing disparity.
      partner_least_(static_cast<std::size_t>(partner_width + 2 * max_count + width)),
      partner_match_(partner_least_.size()) {}

void RowWinner::run(const Cost* sum, const RowLayout& layout, std::int16_t* disparity) {
  std::fill(partner_least_.begin(), partner_least_.end(), kFar);
  winners(sum, layout, partner_width_, best_.data(), partner_least_.data(), partner_match_.data(),
          disparity);
}

}  // namespace cf
