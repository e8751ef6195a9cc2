// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "path_sweep.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "lanes.h"

namespace cf {
namespace {

static_assert(TileRanges::kCountStep == kLanes);

/// The disparities of a pixel as many vectors.
constexpr int kMaxBlocks = 4;

CF_INLINE void store(PathCost* to, ByteLanes value) { std::memcpy(to, &value, sizeof value); }

/// Path costs at the disparities [min, min + n) and one more at both ends, from those at
/// [from_min, from_min + from_n), which have kFar at both ends.
CF_INLINE void moved(const PathCost* from, int from_min, int from_n, int min, int n, PathCost* to) {
  const int shift = min - from_min;  // disparity d of the one is d + shift of the other
  const int first = std::clamp(-shift, 0, n), last = std::clamp(from_n - shift, first, n);
  std::memset(to - 1, kFar, static_cast<std::size_t>(n + 2));
  std::memcpy(to + first, from + first + shift, static_cast<std::size_t>(last - first));
}

/// The paths of all pixels of a run whose disparities fit kBlocks vectors. `along` holds the path
/// costs of the pixel before the run, less their minimum, and takes those of its last pixel; `down`
/// holds those of the row before at this row's slots, and takes this row's.
///
/// A step is cost + min(same disparity, the ones beside it + P1, P2), all less the minimum of the
/// pixel before. Along the row that minimum is subtracted late: it is known last.
template <int kStep, int kBlocks>
CF_INLINE void stepRun(const PixelRun& run, PathCost small, const PathCost* large_along,
                       const PathCost* large_down, const std::uint8_t* cost, PathCost* along,
                       PathCost* down, PathCost* sum) {
  constexpr int kCount = kBlocks * kLanes;
  ByteLanes path[kBlocks];
  for (int k = 0; k < kBlocks; ++k) path[k] = load<ByteLanes>(along + k * kLanes);
  ByteLanes least{};
  const ByteLanes far = ByteLanes{} + kFar;
  const int pixels = run.end - run.first;
  for (int i = 0; i < pixels; ++i) {
    const int at = kStep > 0 ? i : pixels - 1 - i, u = run.first + at;
    const std::uint8_t* c = cost + at * kCount;
    PathCost* s = sum + at * kCount;
    PathCost* vertical = down + at * (kCount + 2);
    const ByteLanes most_along = ByteLanes{} + large_along[u];
    const ByteLanes most_down = ByteLanes{} + large_down[u];
    ByteLanes next[kBlocks], below_it[kBlocks];
    for (int k = 0; k < kBlocks; ++k) {
      const ByteLanes matching = load<ByteLanes>(c + k * kLanes);
      const ByteLanes beside = lesser(fromBelow(k > 0 ? path[k - 1] : far, path[k]),
                                      fromAbove(path[k], k + 1 < kBlocks ? path[k + 1] : far));
      next[k] = matching + lesser(lesser(path[k], beside + small) - least, most_along);
      const PathCost* v = vertical + k * kLanes;
      const ByteLanes beside_down = lesser(load<ByteLanes>(v - 1), load<ByteLanes>(v + 1));
      below_it[k] = matching + lesser(lesser(load<ByteLanes>(v), beside_down + small), most_down);
    }
    least = next[0];
    ByteLanes least_down = below_it[0];
    for (int k = 1; k < kBlocks; ++k) {
      least = lesser(least, next[k]);
      least_down = lesser(least_down, below_it[k]);
    }
    least = leastEverywhere(least);
    least_down = leastEverywhere(least_down);
    for (int k = 0; k < kBlocks; ++k) {
      path[k] = next[k];
      store(vertical + k * kLanes, below_it[k] - least_down);
      const ByteLanes both = next[k] + below_it[k];
      store(s + k * kLanes, kStep > 0 ? both : load<ByteLanes>(s + k * kLanes) + both);
    }
  }
  for (int k = 0; k < kBlocks; ++k) store(along + k * kLanes, path[k] - least);
}

/// The same for any number of disparities. `next` has room for one pixel's.
template <int kStep>
CF_INLINE void stepWideRun(const PixelRun& run, PathCost small, const PathCost* large_along,
                           const PathCost* large_down, const std::uint8_t* cost, PathCost* along,
                           PathCost* down, PathCost* sum, PathCost* next) {
  const int n = run.count, pixels = run.end - run.first;
  const auto step = [n, small](const std::uint8_t* c, const PathCost* before, PathCost large,
                               bool adds, PathCost* out, PathCost* s) {
    ByteLanes least = ByteLanes{} + kFar;
    for (int d = 0; d < n; d += kLanes) {
      const ByteLanes beside =
          lesser(load<ByteLanes>(before + d - 1), load<ByteLanes>(before + d + 1));
      const ByteLanes value =
          load<ByteLanes>(c + d) +
          lesser(lesser(load<ByteLanes>(before + d), beside + small), ByteLanes{} + large);
      least = lesser(least, value);
      store(out + d, value);
      store(s + d, adds ? load<ByteLanes>(s + d) + value : value);
    }
    least = leastEverywhere(least);
    for (int d = 0; d < n; d += kLanes) store(out + d, load<ByteLanes>(out + d) - least);
  };
  for (int i = 0; i < pixels; ++i) {
    const int at = kStep > 0 ? i : pixels - 1 - i, u = run.first + at;
    const std::uint8_t* c = cost + at * n;
    PathCost *s = sum + at * n, *vertical = down + at * (n + 2);
    step(c, along, large_along[u], kStep < 0, next, s);
    std::memcpy(along, next, static_cast<std::size_t>(n));
    step(c, vertical, large_down[u], true, next, s);
    std::memcpy(vertical, next, static_cast<std::size_t>(n));
  }
}

template <int kStep>
CF_CLONES void steps(const RowLayout& layout, PathCost small, const PathCost* large_along,
                     const PathCost* large_down, const std::uint8_t* cost, PathCost* along,
                     PathCost* scratch, PathCost* down, PathCost* sum) {
  const PixelRun* before = nullptr;
  const auto count = static_cast<int>(layout.runs.size());
  for (int i = 0; i < count; ++i) {
    const PixelRun& run = layout.runs[static_cast<std::size_t>(kStep > 0 ? i : count - 1 - i)];
    const bool goes_on =
        before && (kStep > 0 ? before->end == run.first : before->first == run.end);
    if (goes_on) {
      moved(along, before->min, before->count, run.min, run.count, scratch);
      std::swap(along, scratch);
    } else {
      // A path that begins: all disparities are alike.
      std::memset(along, 0, static_cast<std::size_t>(run.count));
      along[-1] = along[run.count] = kFar;
    }
    before = &run;
    const std::uint8_t* c = cost + run.cells;
    PathCost *s = sum + run.cells, *d = down + run.slots + 1;
    switch (run.count / kLanes) {
      case 1:
        stepRun<kStep, 1>(run, small, large_along, large_down, c, along, d, s);
        break;
      case 2:
        stepRun<kStep, 2>(run, small, large_along, large_down, c, along, d, s);
        break;
      case 3:
        stepRun<kStep, 3>(run, small, large_along, large_down, c, along, d, s);
        break;
      default:
        stepWideRun<kStep>(run, small, large_along, large_down, c, along, d, s, scratch);
    }
  }
}

CF_CLONES void largeRow(const std::uint8_t* grey, const std::uint8_t* before, int n, int large,
                        int floor, PathCost* out) {
  for (int u = 0; u < n; ++u) {
    out[u] = static_cast<PathCost>(std::max(floor, large - std::abs(grey[u] - before[u])));
  }
}

}  // namespace

PathSweep::PathSweep(const cv::Mat& grey, const SemiGlobalPenalties& penalties, int direction,
                     int max_count, std::size_t max_slots)
    : grey_(grey),
      penalties_(penalties),
      direction_(direction),
      down_(max_slots),
      last_down_(max_slots),
      along_(static_cast<std::size_t>(max_count) + 2),
      along_scratch_(along_),
      large_along_(static_cast<std::size_t>(grey.cols)),
      large_down_(large_along_) {}

void PathSweep::row(int v, const RowLayout& layout, const RowLayout* last_layout,
                    const std::uint8_t* cost, PathCost* sum) {
  setLarge(v, last_layout != nullptr);
  if (last_layout != &layout) moveDown(layout, last_layout);
  const auto small = static_cast<PathCost>(penalties_.small);
  (direction_ > 0 ? steps<1> : steps<-1>)(layout, small, large_along_.data(), large_down_.data(),
                                          cost, along_.data() + 1, along_scratch_.data() + 1,
                                          down_.data(), sum);
}

void PathSweep::setLarge(int v, bool has_last) {
  const int width = grey_.cols, large = penalties_.large, floor = penalties_.large_floor;
  const auto* grey = grey_.ptr<std::uint8_t>(v);
  largeRow(grey, has_last ? grey_.ptr<std::uint8_t>(v - direction_) : grey, width, large, floor,
           large_down_.data());
  const int from = direction_ > 0 ? 1 : 0;
  largeRow(grey + from, grey + from - direction_, width - 1, large, floor,
           large_along_.data() + from);
}

/// The path costs down the columns from the slots of the row before to those of this row.
void PathSweep::moveDown(const RowLayout& layout, const RowLayout* last_layout) {
  std::swap(down_, last_down_);
  std::size_t k = 0;
  for (const PixelRun& run : layout.runs) {
    for (int u = run.first; u < run.end; ++u) {
      PathCost* const to = down_.data() + run.slot(u);
      while (last_layout && k < last_layout->runs.size() && last_layout->runs[k].end <= u) ++k;
      if (last_layout && k < last_layout->runs.size() && last_layout->runs[k].first <= u) {
        const PixelRun& last = last_layout->runs[k];
        moved(last_down_.data() + last.slot(u), last.min, last.count, run.min, run.count, to);
      } else {
        std::memset(to, 0, static_cast<std::size_t>(run.count));
        to[-1] = to[run.count] = kFar;
      }
    }
  }
}

}  // namespace cf
