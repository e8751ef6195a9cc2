// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "row_winner.h"

#include <algorithm>
#include <cstring>

#include "cf/densify/stereo_matcher.h"
#include "lanes.h"

namespace cf {
namespace {

constexpr PathCost kNone = 0xFF;

using Ints = std::int32_t __attribute__((vector_size(4 * kLanes)));
using Floats = float __attribute__((vector_size(4 * kLanes)));

/// Of sixteen pixels side by side, a lane each: the least sum, where it is (of several, the first)
/// by block of sixteen disparities and place in it, and the sums beside it.
struct Winners {
  ByteLanes block, place, least, below, above;
};

/// Sums of sixteen pixels at sixteen disparities, turned: sums[d] has a lane for each pixel.
CF_INLINE void transpose(ByteLanes* sums) {
  ByteLanes turned[kLanes];
  for (int round = 0; round < 4; ++round) {
    for (int k = 0; k < kLanes / 2; ++k) {
      const ByteLanes a = sums[k], b = sums[k + kLanes / 2];
      turned[2 * k] = CF_SHUFFLE2(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
      turned[2 * k + 1] =
          CF_SHUFFLE2(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
    }
    for (int k = 0; k < kLanes; ++k) sums[k] = turned[k];
  }
}

/// `pixels` up to sixteen, `n` sums each.
CF_INLINE Winners winnersOf(const PathCost* sum, int pixels, int n) {
  Winners w;
  w.block = w.place = w.below = w.above = ByteLanes{};
  w.least = ByteLanes{} + kNone;
  ByteLanes last = w.least, block{};
  ByteLanes just_won{};  // the sum above the winner comes next
  for (int first = 0; first < n; first += kLanes, block += 1) {
    const ByteLanes before = w.least;
    ByteLanes sums[kLanes];
    for (int i = 0; i < kLanes; ++i)
      sums[i] = load<ByteLanes>(sum + std::min(i, pixels - 1) * n + first);
    transpose(sums);
    for (int d = 0; d < kLanes; ++d) {
      const ByteLanes here = sums[d];
      w.above = just_won ? here : w.above;
      just_won = here < w.least;
      w.least = lesser(here, w.least);
      w.place = just_won ? ByteLanes{} + static_cast<PathCost>(d) : w.place;
      w.below = just_won ? last : w.below;
      last = here;
    }
    w.block = w.least < before ? block : w.block;
  }
  return w;
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
    for (int first = run.first; first < run.end; first += kLanes) {
      const int pixels = std::min(kLanes, run.end - first);
      const PathCost* s = sum + run.cell(first);
      const Winners w = winnersOf(s, pixels, n);
      // Sub-pixel by the parabola through the least: ratios of small whole numbers, exact in
      // floats.
      const Ints best = __builtin_convertvector(w.least, Ints);
      const Ints below = __builtin_convertvector(w.below, Ints) - best;
      const Ints above = __builtin_convertvector(w.above, Ints) - best;
      const Ints both = below + above;
      const Floats ratio = __builtin_convertvector(8 * (below - above), Floats) /
                           __builtin_convertvector(both > 0 ? both : Ints{} + 1, Floats);
      const Ints at =
          kLanes * __builtin_convertvector(w.block, Ints) + __builtin_convertvector(w.place, Ints);
      const Ints found = 16 * (run.min + at) + __builtin_convertvector(ratio, Ints);
      // Without branches: which way they go is as good as chance.
      for (int i = 0; i < pixels; ++i, s += n) {
        const int u = first + i, d = std::clamp(at[i], 1, n - 2), x = u - run.min - d;
        const int there = std::clamp(x, 0, partner_width - 1);
        // The partner's best is this pixel or one beside it.
        const PathCost partners = least[partner_width - 1 - there];
        const PathCost before = s[u > run.first ? d - 1 - n : d];
        const PathCost after = s[u + 1 < run.end ? n + d + 1 : d];
        const int same = (s[d] == partners) | (before == partners) | (after == partners);
        // At either end the minimum may lie beyond.
        const int good = (d == at[i]) & (x == there) & same;
        disparity[u] = good ? static_cast<std::int16_t>(found[i]) : kNoDisparity;
      }
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
