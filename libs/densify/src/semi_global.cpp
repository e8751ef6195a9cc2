// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "semi_global.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "census.h"
#include "cf/densify/stereo_matcher.h"
#include "lanes.h"

namespace cf {
namespace {

static_assert(TileRanges::kCountStep == kLanes);

constexpr Cost kFar = 0x3FFF;     // path cost of a disparity that was not searched
constexpr int kOutsideCost = 16;  // of a match beyond the partner image: as for unlike pixels
constexpr std::size_t kMaxCells = 10'000'000;  // of the cost volume held at once: 30 MB
constexpr int kBandOverlap = 24;               // rows
constexpr int kPaths = 2;                      // in one sweep: along the row and from the last

/// Where the disparities of one row's pixels lie in its part of the cost volume.
struct RowLayout {
  std::vector<int> min, count, start;
  int total = 0;

  RowLayout(const TileRanges& ranges, int tile_row, int width) {
    for (int u = 0; u < width; ++u) {
      const std::size_t tile = ranges.at(u / TileRanges::kTile, tile_row);
      min.push_back(ranges.min_px[tile]);
      count.push_back(ranges.count_px[tile]);
      start.push_back(total);
      total += count.back();
    }
  }
  /// In a path buffer each pixel has one entry of kFar before and after its own.
  std::size_t slot(int u) const {
    const auto k = static_cast<std::size_t>(u);
    return static_cast<std::size_t>(start[k]) + 2 * k + 1;
  }
  std::size_t slots() const { return static_cast<std::size_t>(total) + 2 * min.size(); }
};

/// Path costs of one row and their minimum at each pixel.
struct PathRow {
  std::vector<Cost> cost;
  std::vector<Cost> least;
};

CF_CLONES void matchingCostRow(const std::uint32_t* reference, const std::uint32_t* partner,
                               int partner_width, const RowLayout& layout, int width,
                               std::uint8_t* cost) {
  for (int u = 0; u < width; ++u) {
    const auto k = static_cast<std::size_t>(u);
    const int n = layout.count[k], x0 = u - layout.min[k];
    std::uint8_t* c = cost + layout.start[k];
    const std::uint32_t bits = reference[u];
    if (x0 < partner_width && x0 - n + 1 >= 0) {
      const std::uint32_t* p = partner + x0;
      for (int d = 0; d < n; ++d) {
        c[d] = static_cast<std::uint8_t>(__builtin_popcount(bits ^ p[-d]));
      }
    } else {
      for (int d = 0; d < n; ++d) {
        const int x = x0 - d;
        c[d] = static_cast<std::uint8_t>(
            x >= 0 && x < partner_width ? __builtin_popcount(bits ^ partner[x]) : kOutsideCost);
      }
    }
  }
}

/// One step of one path: `before` holds the costs of the pixel before at this pixel's disparities.
/// Without one (`before` null) the path starts here.
template <bool kAdd>
CF_INLINE Cost pathStep(const std::uint8_t* cost, const Cost* before, Cost least_before, int n,
                        Cost small, Cost large, Cost* out, Cost* sum) {
  Lanes least = Lanes{} + kFar;
  const Lanes jump = Lanes{} + static_cast<Cost>(least_before + large);
  for (int d = 0; d < n; d += kLanes) {
    Lanes value = __builtin_convertvector(load<ByteLanes>(cost + d), Lanes);
    if (before) {
      const Lanes beside = lesser(load<Lanes>(before + d - 1), load<Lanes>(before + d + 1)) + small;
      value += lesser(lesser(load<Lanes>(before + d), beside), jump) - least_before;
    }
    std::memcpy(out + d, &value, sizeof value);
    least = lesser(least, value);
    const Lanes total = kAdd ? load<Lanes>(sum + d) + value : value;
    std::memcpy(sum + d, &total, sizeof total);
  }
  return leastOf(least);
}

/// The same step where all disparities fit one vector.
CF_INLINE Lanes pathStep(Lanes cost, Lanes centre, Lanes below, Lanes above, Cost least_before,
                         Cost small, Cost large) {
  const Lanes beside = lesser(below, above) + small;
  const Lanes jump = Lanes{} + static_cast<Cost>(least_before + large);
  return cost + lesser(lesser(centre, beside), jump) - least_before;
}

/// `from`'s path costs at the disparities [min, min + n) and one more at both ends.
CF_INLINE const Cost* aligned(const Cost* from, int from_min, int from_n, int min, int n,
                              Cost* scratch) {
  if (from_min == min && from_n == n) return from;
  const int shift = min - from_min;  // this pixel's disparity d is the other's d + shift
  const int first = std::clamp(-shift, -1, n + 1), last = std::clamp(from_n - shift, first, n + 1);
  std::fill(scratch, scratch + first + 1, kFar);
  std::copy(from + first + shift, from + last + shift, scratch + first + 1);
  std::fill(scratch + last + 1, scratch + n + 2, kFar);
  return scratch + 1;
}

struct Sweep {
  const cv::Mat& grey;
  const SemiGlobalPenalties& penalties;
  int direction;  // +1: left to right and top to bottom, -1: the other way
  PathRow now[kPaths], last[kPaths];
  std::vector<Cost> scratch;
};

/// Adds the two path costs of row v to `sum`. `last_layout` is null in the sweep's first row.
CF_CLONES void sweepRow(Sweep& sweep, int v, const RowLayout& layout, const RowLayout* last_layout,
                        const std::uint8_t* cost, Cost* sum) {
  const int width = static_cast<int>(layout.min.size());
  const int step = sweep.direction;
  const auto small = static_cast<Cost>(sweep.penalties.small);
  const uchar* grey = sweep.grey.ptr<uchar>(v);
  const uchar* grey_last = last_layout ? sweep.grey.ptr<uchar>(v - step) : grey;
  // Path costs of the pixel before along the row, kept in a register where they fit one: they
  // would come back from memory late.
  Lanes along{};
  int along_min = 0;
  bool has_along = false;
  for (int i = 0; i < width; ++i) {
    const int u = step > 0 ? i : width - 1 - i;
    const auto k = static_cast<std::size_t>(u);
    const int n = layout.count[k], min = layout.min[k];
    const bool had_along = has_along && along_min == min;
    has_along = false;
    if (n == 0) continue;
    const std::uint8_t* c = cost + layout.start[k];
    Cost* s = sum + layout.start[k];
    // Path 0 comes along the row, path 1 from the last row.
    for (int path = 0; path < kPaths; ++path) {
      PathRow& row = sweep.now[path];
      const PathRow& from_row = path == 0 ? row : sweep.last[path];
      const RowLayout* from_layout = path == 0 ? &layout : last_layout;
      const int from = path == 0 ? u - step : u;
      const auto q = static_cast<std::size_t>(from);
      Cost* out = row.cost.data() + layout.slot(u);
      out[-1] = out[n] = kFar;
      const bool sets = step > 0 && path == 0;  // the first of all paths sets the sum
      if (!from_layout || from < 0 || from >= width || from_layout->count[q] == 0) {
        row.least[k] = sets ? pathStep<false>(c, nullptr, 0, n, small, 0, out, s)
                            : pathStep<true>(c, nullptr, 0, n, small, 0, out, s);
        continue;
      }
      const int change = std::abs(grey[u] - (path == 0 ? grey[from] : grey_last[from]));
      const auto large =
          static_cast<Cost>(std::max(sweep.penalties.large_floor, sweep.penalties.large - change));
      const Cost least = from_row.least[q];
      const bool in_register = path == 0 && had_along;
      const Cost* before =
          in_register ? nullptr
                      : aligned(from_row.cost.data() + from_layout->slot(from), from_layout->min[q],
                                from_layout->count[q], min, n, sweep.scratch.data());
      if (n != kLanes) {
        row.least[k] = sets ? pathStep<false>(c, before, least, n, small, large, out, s)
                            : pathStep<true>(c, before, least, n, small, large, out, s);
        continue;
      }
      const Lanes matching = __builtin_convertvector(load<ByteLanes>(c), Lanes);
      const Lanes value = in_register
                              ? pathStep(matching, along, fromBelow(along, kFar),
                                         fromAbove(along, kFar), least, small, large)
                              : pathStep(matching, load<Lanes>(before), load<Lanes>(before - 1),
                                         load<Lanes>(before + 1), least, small, large);
      std::memcpy(out, &value, sizeof value);
      row.least[k] = leastOf(value);
      const Lanes total = sets ? value : load<Lanes>(s) + value;
      std::memcpy(s, &total, sizeof total);
      if (path == 0) {
        along = value;
        along_min = min;
        has_along = true;
      }
    }
  }
}

/// Index of the least of the sums.
CF_INLINE int winnerOf(const Cost* sum, int n) {
  Lanes least = load<Lanes>(sum);
  for (int d = kLanes; d < n; d += kLanes) least = lesser(least, load<Lanes>(sum + d));
  const Cost value = leastOf(least);
  // Of several, the first.
  const Lanes order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  for (int d = 0;; d += kLanes) {
    const Cost at = leastOf(load<Lanes>(sum + d) == Lanes{} + value ? order : Lanes{} + kLanes);
    if (at < kLanes) return d + at;
  }
}

/// Is every sum but those beside the winner above the limit?
CF_INLINE bool isUnique(const Cost* sum, int n, int winner, Cost limit) {
  Lanes rivals{};
  for (int d = 0; d < n; d += kLanes) rivals -= load<Lanes>(sum + d) <= Lanes{} + limit;
  int count = sumOf(rivals);
  for (int d = std::max(0, winner - 1); d <= std::min(n - 1, winner + 1); ++d) {
    count -= sum[d] <= limit;
  }
  return count == 0;
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

/// Best disparity of each reference pixel of a row, sub-pixel, checked against the partner's best.
class RowWinner {
 public:
  RowWinner(int width, int partner_width, int max_count, int uniqueness_percent)
      : width_(width),
        partner_width_(partner_width),
        uniqueness_(uniqueness_percent),
        best_(static_cast<std::size_t>(width)),
        // Runs from right to left, so that it is read upwards with growing disparity.
        partner_least_(static_cast<std::size_t>(partner_width + 2 * max_count + width)),
        partner_match_(partner_least_.size()) {}

  CF_CLONES void run(const Cost* sum, const RowLayout& layout, std::int16_t* disparity) {
    std::fill(partner_least_.begin(), partner_least_.end(), kFar);
    collect(sum, layout);
    for (int u = 0; u < width_; ++u) {
      const auto k = static_cast<std::size_t>(u);
      disparity[u] = kNoDisparity;
      const Cost* s = sum + layout.start[k];
      const int n = layout.count[k], d = best_[k];
      if (n == 0) continue;
      const int x = u - layout.min[k] - d;
      if (x < 0 || x >= partner_width_) continue;
      const int mutual = partner_match_[static_cast<std::size_t>(partner_width_ - 1 - x)];
      if (std::abs(mutual - u) > 1) continue;
      if (d == 0 || d == n - 1) continue;  // the minimum may lie beyond
      if (!isUnique(s, n, d, static_cast<Cost>(s[d] * (100 + uniqueness_) / 100))) continue;
      const int left = s[d - 1] - s[d], right = s[d + 1] - s[d];
      const int part = left + right > 0 ? (16 * (left - right)) / (2 * (left + right)) : 0;
      disparity[u] = static_cast<std::int16_t>(16 * (layout.min[k] + d) + part);
    }
  }

 private:
  CF_INLINE void collect(const Cost* sum, const RowLayout& layout) {
    for (int u = 0; u < width_; ++u) {
      const auto k = static_cast<std::size_t>(u);
      const Cost* s = sum + layout.start[k];
      const int n = layout.count[k];
      if (n == 0) continue;
      best_[k] = winnerOf(s, n);
      int first = partner_width_ - 1 - (u - layout.min[k]), d0 = 0;
      if (first < 0) {
        d0 = -first;
        first = 0;
      }
      const int usable = std::min(n - d0, partner_width_ - first);
      if (usable <= 0) continue;
      const auto at = static_cast<std::size_t>(first);
      collectPixel(s + d0, usable, static_cast<Cost>(u), &partner_least_[at], &partner_match_[at]);
    }
  }

  int width_, partner_width_, uniqueness_;
  std::vector<int> best_;
  std::vector<Cost> partner_least_, partner_match_;
};

/// The cost volume of a band: matching costs and sums of path costs. Not initialised: each is
/// written before it is read, and they are large.
struct BandVolume {
  std::unique_ptr<std::uint8_t[]> cost;
  std::unique_ptr<Cost[]> sum;
  std::size_t cells = 0;

  void reserve(std::size_t wanted) {
    if (wanted <= cells) return;
    cells = wanted;
    cost.reset(new std::uint8_t[cells]);
    sum.reset(new Cost[cells]);
  }
};

/// The rows [first, end) as if they were the whole image; writes the winners of [keep, keep_end).
void matchBand(const cv::Mat& reference, const cv::Mat& census_reference,
               const cv::Mat& census_partner, const std::vector<RowLayout>& layouts,
               const SemiGlobalPenalties& penalties, cv::Range band, cv::Range keep,
               BandVolume& volume, cv::Mat& disparity) {
  const int width = reference.cols;
  const auto layoutOf = [&](int v) -> const RowLayout& {
    return layouts[static_cast<std::size_t>(v / TileRanges::kTile)];
  };
  std::vector<std::size_t> base;
  std::size_t total = 0, max_slots = 0;
  int max_count = 0;
  for (int v = band.start; v < band.end; ++v) {
    const RowLayout& layout = layoutOf(v);
    base.push_back(total);
    total += static_cast<std::size_t>(layout.total);
    max_slots = std::max(max_slots, layout.slots());
    max_count = std::max(max_count, *std::max_element(layout.count.begin(), layout.count.end()));
  }
  volume.reserve(total);
  std::uint8_t* const cost = volume.cost.get();
  Cost* const sum = volume.sum.get();
  RowWinner winner(width, census_partner.cols, max_count, penalties.uniqueness_percent);
  for (const int direction : {1, -1}) {
    Sweep sweep{reference, penalties, direction, {}, {}, {}};
    sweep.scratch.resize(static_cast<std::size_t>(max_count) + 2);
    for (int path = 0; path < kPaths; ++path) {
      for (PathRow* row : {&sweep.now[path], &sweep.last[path]}) {
        row->cost.resize(max_slots);
        row->least.resize(static_cast<std::size_t>(width));
      }
    }
    for (int i = 0; i < band.size(); ++i) {
      const int v = direction > 0 ? band.start + i : band.end - 1 - i;
      const std::size_t at = base[static_cast<std::size_t>(v - band.start)];
      const RowLayout& layout = layoutOf(v);
      if (direction > 0) {
        matchingCostRow(reinterpret_cast<const std::uint32_t*>(census_reference.ptr<int>(v)),
                        reinterpret_cast<const std::uint32_t*>(census_partner.ptr<int>(v)),
                        census_partner.cols, layout, width, &cost[at]);
      }
      sweepRow(sweep, v, layout, i > 0 ? &layoutOf(v - direction) : nullptr, &cost[at], &sum[at]);
      for (int path = 0; path < kPaths; ++path) std::swap(sweep.now[path], sweep.last[path]);
      if (direction < 0 && v >= keep.start && v < keep.end) {
        winner.run(&sum[at], layout, disparity.ptr<std::int16_t>(v));
      }
    }
  }
}

}  // namespace

cv::Mat semiGlobalMatch(const cv::Mat& reference, const cv::Mat& partner, const TileRanges& ranges,
                        const SemiGlobalPenalties& penalties) {
  const cv::Mat census_reference = census(reference), census_partner = census(partner);
  std::vector<RowLayout> layouts;
  std::size_t cells = 0;
  for (int row = 0; row < ranges.rows; ++row) {
    layouts.emplace_back(ranges, row, reference.cols);
    cells += static_cast<std::size_t>(layouts.back().total) * TileRanges::kTile;
  }
  // In as few bands as the memory bound allows; they overlap so that no seam shows.
  const int bands = static_cast<int>(cells / kMaxCells) + 1;
  const int rows = (reference.rows + bands - 1) / bands;
  cv::Mat disparity(reference.size(), CV_16S);
  BandVolume volume;
  for (int start = 0; start < reference.rows; start += rows) {
    const cv::Range keep(start, std::min(reference.rows, start + rows));
    const cv::Range band(std::max(0, keep.start - kBandOverlap),
                         std::min(reference.rows, keep.end + kBandOverlap));
    matchBand(reference, census_reference, census_partner, layouts, penalties, band, keep, volume,
              disparity);
  }
  return disparity;
}

}  // namespace cf
