// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "row_winner.h"

#include <algorithm>
#include <cstring>

#include "cf/densify/stereo_matcher.h"
#include "lanes.h"

namespace cf {
namespace {

constexpr Lanes kOrder = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
constexpr PathCost kNone = 0xFF;

/// Index of the least of the sums; of several, the first.
CF_INLINE int winnerOf(const PathCost* sum, int n) {
  int winner = 0;
  Cost least = INT16_MAX;
  for (int d = 0; d < n; d += kLanes) {
    const Lanes wide = __builtin_convertvector(load<ByteLanes>(sum + d), Lanes);
    const Cost best = leastOf(wide * kLanes + kOrder);
    if (best / kLanes >= least) continue;
    least = static_cast<Cost>(best / kLanes);
    winner = d + best % kLanes;
  }
  return winner;
}

/// The least sums that the partner's pixels see. `least` runs from right to left, so that it is
/// read upwards with growing disparity; entry 0 is the one of the run's last pixel at its least
/// disparity.
///
/// From one pixel to the next the part that a pixel sees moves by one: it stays in registers
/// meanwhile (from memory it would come back late).
template <int kBlocks>
CF_INLINE void collectRun(const PathCost* sum, int pixels, PathCost* least) {
  constexpr int kCount = kBlocks * kLanes;
  PathCost* at = least + pixels;
  ByteLanes held[kBlocks];
  for (int k = 0; k < kBlocks; ++k) held[k] = load<ByteLanes>(at + k * kLanes);
  for (int i = 0; i < pixels; ++i) {
    at[kCount - 1] = held[kBlocks - 1][kLanes - 1];
    --at;
    const ByteLanes first = ByteLanes{} + *at;
    for (int k = kBlocks - 1; k >= 0; --k) {
      held[k] = lesser(fromBelow(k > 0 ? held[k - 1] : first, held[k]),
                       load<ByteLanes>(sum + i * kCount + k * kLanes));
    }
  }
  for (int k = 0; k < kBlocks; ++k) std::memcpy(at + k * kLanes, &held[k], sizeof held[k]);
}

CF_INLINE void collectWideRun(const PathCost* sum, int pixels, int n, PathCost* least) {
  for (int i = 0; i < pixels; ++i) {
    PathCost* at = least + pixels - 1 - i;
    for (int d = 0; d < n; d += kLanes) {
      const ByteLanes kept = lesser(load<ByteLanes>(sum + i * n + d), load<ByteLanes>(at + d));
      std::memcpy(at + d, &kept, sizeof kept);
    }
  }
}

/// `least` is the partner's, entry 0 of its rightmost pixel.
CF_CLONES void collect(const PathCost* sum, const RowLayout& layout, int partner_width,
                       PathCost* least) {
  for (const PixelRun& run : layout.runs) {
    const int pixels = run.end - run.first;
    const PathCost* s = sum + run.cells;
    PathCost* at = least + (partner_width - run.end + run.min);
    switch (run.count / kLanes) {
      case 1:
        collectRun<1>(s, pixels, at);
        break;
      case 2:
        collectRun<2>(s, pixels, at);
        break;
      case 3:
        collectRun<3>(s, pixels, at);
        break;
      default:
        collectWideRun(s, pixels, run.count, at);
    }
  }
}

CF_CLONES void winners(const PathCost* sum, const RowLayout& layout, int partner_width,
                       const PathCost* least, std::int16_t* disparity) {
  for (const PixelRun& run : layout.runs) {
    const int n = run.count;
    const PathCost* s = sum + run.cells;
    for (int u = run.first; u < run.end; ++u, s += n) {
      const int d = winnerOf(s, n), x = u - run.min - d;
      if (x < 0 || x >= partner_width) continue;
      if (d == 0 || d == n - 1) continue;  // the minimum may lie beyond
      // The partner's best is this pixel or one beside it.
      const PathCost best = least[partner_width - 1 - x];
      if (s[d] != best && !(u + 1 < run.end && s[n + d + 1] == best) &&
          !(u > run.first && s[d - 1 - n] == best)) {
        continue;
      }
      const int left = s[d - 1] - s[d], right = s[d + 1] - s[d];
      const int part = left + right > 0 ? (16 * (left - right)) / (2 * (left + right)) : 0;
      disparity[u] = static_cast<std::int16_t>(16 * (run.min + d) + part);
    }
  }
}

}  // namespace

void RowWinner::run(const PathCost* sum, const RowLayout& layout, int width,
                    std::int16_t* disparity) {
  std::fill_n(disparity, width, kNoDisparity);
  int first = 0, last = partner_width_;
  for (const PixelRun& run : layout.runs) {
    first = std::min(first, partner_width_ - run.end + run.min);
    last = std::max(last, partner_width_ - run.first + run.min + run.count);
  }
  partner_least_.assign(static_cast<std::size_t>(last - first + 1), kNone);
  PathCost* const least = partner_least_.data() - first;
  collect(sum, layout, partner_width_, least);
  winners(sum, layout, partner_width_, least, disparity);
}

}  // namespace cf
