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
#include "row_winner.h"

namespace cf {
namespace {

static_assert(TileRanges::kCountStep == kLanes);

constexpr int kOutsideCost = 6;  // of a match beyond the partner image: as for unlike pixels
constexpr std::size_t kMaxCells = 10'000'000;  // of the cost volume held at once: 30 MB
constexpr int kBandOverlap = 24;               // rows

/// Set bits, in steps that the compiler can do for many numbers at once.
CF_INLINE std::uint16_t setBits(std::uint16_t bits) {
  auto x = static_cast<std::uint16_t>(bits - ((bits >> 1) & 0x5555));
  x = static_cast<std::uint16_t>((x & 0x3333) + ((x >> 2) & 0x3333));
  x = static_cast<std::uint16_t>((x + (x >> 4)) & 0x0F0F);
  return static_cast<std::uint16_t>((x + (x >> 8)) & 0x1F);
}

/// `mirrored` is the partner's census from right to left, so that it is read upwards with growing
/// disparity.
CF_CLONES void matchingCostRow(const std::uint16_t* reference, const std::uint16_t* mirrored,
                               int partner_width, const RowLayout& layout, int width,
                               std::uint8_t* cost) {
  for (int u = 0; u < width; ++u) {
    const auto k = static_cast<std::size_t>(u);
    const int n = layout.count[k], first = partner_width - 1 - (u - layout.min[k]);
    std::uint8_t* c = cost + layout.start[k];
    const std::uint16_t bits = reference[u];
    if (first >= 0 && first + n <= partner_width) {
      const std::uint16_t* p = mirrored + first;
      for (int d = 0; d < n; d += kLanes) {
        for (int lane = 0; lane < kLanes; ++lane) {
          c[d + lane] =
              static_cast<std::uint8_t>(setBits(static_cast<std::uint16_t>(bits ^ p[d + lane])));
        }
      }
    } else {
      for (int d = 0; d < n; ++d) {
        const int x = first + d;
        c[d] = static_cast<std::uint8_t>(
            x >= 0 && x < partner_width ? setBits(static_cast<std::uint16_t>(bits ^ mirrored[x]))
                                        : kOutsideCost);
      }
    }
  }
}

/// One step of a path. `before` holds the costs of the pixel before less their minimum, at this
/// pixel's disparities and one beyond at both ends; null where the path starts. `large` is P2.
CF_INLINE Lanes pathStep(Lanes cost, Lanes centre, Lanes below, Lanes above, Cost small,
                         Cost large) {
  return cost + lesser(lesser(centre, lesser(below, above) + small), Lanes{} + large);
}

/// The step for any number of disparities: adds the path's costs to `sum` (or sets it) and leaves
/// them less their minimum in `out`.
template <bool kSet>
CF_INLINE void pathStep(const std::uint8_t* cost, const Cost* before, int n, Cost small, Cost large,
                        Cost* out, Cost* sum) {
  Lanes least = Lanes{} + kFar;
  for (int d = 0; d < n; d += kLanes) {
    Lanes value = __builtin_convertvector(load<ByteLanes>(cost + d), Lanes);
    if (before) {
      value = pathStep(value, load<Lanes>(before + d), load<Lanes>(before + d - 1),
                       load<Lanes>(before + d + 1), small, large);
    }
    least = lesser(least, value);
    std::memcpy(out + d, &value, sizeof value);
    const Lanes total = kSet ? value : load<Lanes>(sum + d) + value;
    std::memcpy(sum + d, &total, sizeof total);
  }
  least = leastEverywhere(least);
  for (int d = 0; d < n; d += kLanes) {
    const Lanes value = load<Lanes>(out + d) - least;
    std::memcpy(out + d, &value, sizeof value);
  }
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

/// Two of the four paths: along the rows and down the columns, or both the other way.
class Sweep {
 public:
  Sweep(const cv::Mat& grey, const SemiGlobalPenalties& penalties, int direction, int max_count,
        std::size_t max_slots)
      : grey_(grey),
        penalties_(penalties),
        direction_(direction),
        now_(max_slots),
        last_(max_slots),
        scratch_(static_cast<std::size_t>(max_count) + 2),
        along_{scratch_, scratch_},
        large_along_(static_cast<std::size_t>(grey.cols)),
        large_down_(large_along_) {}

  /// Adds the two path costs of row v to `sum`; the first of all sweeps sets it. `last_layout` is
  /// null in the sweep's first row.
  void row(int v, const RowLayout& layout, const RowLayout* last_layout, const std::uint8_t* cost,
           Cost* sum) {
    setLarge(v, last_layout != nullptr);
    if (direction_ > 0) {
      steps<1>(layout, last_layout, cost, sum);
    } else {
      steps<-1>(layout, last_layout, cost, sum);
    }
    std::swap(now_, last_);
  }

 private:
  /// P2 of the steps into each pixel of the row.
  CF_CLONES void setLarge(int v, bool has_last) {
    const int width = grey_.cols;
    const Cost large = static_cast<Cost>(penalties_.large);
    const Cost floor = static_cast<Cost>(penalties_.large_floor);
    const uchar* grey = grey_.ptr<uchar>(v);
    const uchar* before = has_last ? grey_.ptr<uchar>(v - direction_) : grey;
    for (int u = 0; u < width; ++u) {
      const auto change = static_cast<Cost>(std::abs(grey[u] - before[u]));
      large_down_[static_cast<std::size_t>(u)] = std::max(floor, static_cast<Cost>(large - change));
    }
    const int from = direction_ > 0 ? 1 : 0, to = direction_ > 0 ? width : width - 1;
    for (int u = from; u < to; ++u) {
      const auto change = static_cast<Cost>(std::abs(grey[u] - grey[u - direction_]));
      large_along_[static_cast<std::size_t>(u)] =
          std::max(floor, static_cast<Cost>(large - change));
    }
  }

  template <int kStep>
  CF_CLONES void steps(const RowLayout& layout, const RowLayout* last_layout,
                       const std::uint8_t* cost, Cost* sum) {
    const int width = static_cast<int>(layout.min.size());
    const auto small = static_cast<Cost>(penalties_.small);
    // The path along the row: its costs at the pixel before, in a register while they fit one
    // (they would come back from memory late), otherwise in along_[0].
    Lanes along{};
    bool in_register = false;
    int along_min = 0, along_count = 0;
    for (int i = 0; i < width; ++i) {
      const int u = kStep > 0 ? i : width - 1 - i;
      const auto k = static_cast<std::size_t>(u);
      const int n = layout.count[k], min = layout.min[k];
      if (n == 0) {
        along_count = 0;
        continue;
      }
      const std::uint8_t* c = cost + layout.start[k];
      Cost* s = sum + layout.start[k];
      Cost* out = now_.data() + layout.slot(u);
      out[-1] = out[n] = kFar;
      const bool has_last = last_layout && last_layout->count[k] > 0;
      const Cost* down = has_last
                             ? aligned(last_.data() + last_layout->slot(u), last_layout->min[k],
                                       last_layout->count[k], min, n, scratch_.data())
                             : nullptr;
      const Cost large_along = large_along_[k], large_down = large_down_[k];
      if (n == kLanes && in_register && along_count == n && along_min == min) {
        const Lanes matching = __builtin_convertvector(load<ByteLanes>(c), Lanes);
        const Lanes value = pathStep(matching, along, fromBelow(along, kFar),
                                     fromAbove(along, kFar), small, large_along);
        along = value - leastEverywhere(value);
        Lanes value_down = matching;
        if (down) {
          value_down = pathStep(matching, load<Lanes>(down), load<Lanes>(down - 1),
                                load<Lanes>(down + 1), small, large_down);
        }
        const Lanes left = value_down - leastEverywhere(value_down);
        std::memcpy(out, &left, sizeof left);
        const Lanes total = kStep > 0 ? value + value_down : load<Lanes>(s) + value + value_down;
        std::memcpy(s, &total, sizeof total);
        continue;
      }
      if (in_register) std::memcpy(along_[0].data() + 1, &along, sizeof along);
      const Cost* before = nullptr;
      if (along_count > 0) {
        along_[0][0] = along_[0][static_cast<std::size_t>(along_count) + 1] = kFar;
        before =
            aligned(along_[0].data() + 1, along_min, along_count, min, n, along_scratch_.data());
      }
      pathStep<(kStep > 0)>(c, before, n, small, large_along, along_[1].data() + 1, s);
      std::swap(along_[0], along_[1]);
      pathStep<false>(c, down, n, small, large_down, out, s);
      along_min = min;
      along_count = n;
      in_register = n == kLanes;
      if (in_register) along = load<Lanes>(along_[0].data() + 1);
    }
  }

  const cv::Mat& grey_;
  const SemiGlobalPenalties& penalties_;
  const int direction_;           // +1: left to right and top to bottom, -1: the other way
  std::vector<Cost> now_, last_;  // path costs down the columns, of this row and the last
  std::vector<Cost> scratch_;
  std::vector<Cost> along_[2];  // of the pixel before and of this one
  std::vector<Cost> along_scratch_{scratch_};
  std::vector<Cost> large_along_, large_down_;
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
  RowWinner winner(width, census_partner.cols, max_count);
  std::vector<std::uint16_t> mirrored(static_cast<std::size_t>(census_partner.cols));
  for (const int direction : {1, -1}) {
    Sweep sweep(reference, penalties, direction, max_count, max_slots);
    for (int i = 0; i < band.size(); ++i) {
      const int v = direction > 0 ? band.start + i : band.end - 1 - i;
      const std::size_t at = base[static_cast<std::size_t>(v - band.start)];
      const RowLayout& layout = layoutOf(v);
      if (direction > 0) {
        const auto* partner = census_partner.ptr<std::uint16_t>(v);
        std::reverse_copy(partner, partner + census_partner.cols, mirrored.begin());
        matchingCostRow(census_reference.ptr<std::uint16_t>(v), mirrored.data(),
                        census_partner.cols, layout, width, &cost[at]);
      }
      sweep.row(v, layout, i > 0 ? &layoutOf(v - direction) : nullptr, &cost[at], &sum[at]);
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
