// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "semi_global.h"

#include <algorithm>
#include <memory>

#include "census.h"
#include "cf/densify/stereo_matcher.h"
#include "lanes.h"
#include "path_sweep.h"
#include "row_layout.h"
#include "row_winner.h"

namespace cf {
namespace {

constexpr int kOutsideCost = 6;  // of a match beyond the partner image: as for unlike pixels
constexpr std::size_t kMaxCells = 12'000'000;  // of the cost volume held at once, two bytes each
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
                               int partner_width, const RowLayout& layout, std::uint8_t* cost) {
  for (const PixelRun& run : layout.runs) {
    const int n = run.count;
    std::uint8_t* c = cost + run.cells;
    for (int u = run.first; u < run.end; ++u, c += n) {
      const int first = partner_width - 1 - (u - run.min);
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
}

/// The cost volume of a band: matching costs and sums of path costs. Not initialised: each is
/// written before it is read, and they are large.
struct BandVolume {
  std::unique_ptr<std::uint8_t[]> cost;
  std::unique_ptr<PathCost[]> sum;
  std::size_t cells = 0;

  void reserve(std::size_t wanted) {
    if (wanted <= cells) return;
    cells = wanted;
    cost.reset(new std::uint8_t[cells]);
    sum.reset(new PathCost[cells]);
  }
};

/// The rows [first, end) as if they were the whole image; writes the winners of [keep, keep_end).
void matchBand(const cv::Mat& reference, const cv::Mat& census_reference,
               const cv::Mat& census_partner, const std::vector<RowLayout>& layouts,
               const SemiGlobalPenalties& penalties, cv::Range band, cv::Range keep,
               BandVolume& volume, cv::Mat& disparity) {
  const auto layoutOf = [&](int v) -> const RowLayout& {
    return layouts[static_cast<std::size_t>(v / TileRanges::kTile)];
  };
  std::vector<std::size_t> base;
  std::size_t total = 0, max_slots = 0;
  int max_count = 0;
  for (int v = band.start; v < band.end; ++v) {
    const RowLayout& layout = layoutOf(v);
    base.push_back(total);
    total += layout.cells;
    max_slots = std::max(max_slots, layout.slots);
    max_count = std::max(max_count, layout.max_count);
  }
  volume.reserve(total);
  std::uint8_t* const cost = volume.cost.get();
  PathCost* const sum = volume.sum.get();
  RowWinner winner(census_partner.cols);
  std::vector<std::uint16_t> mirrored(static_cast<std::size_t>(census_partner.cols));
  for (const int direction : {1, -1}) {
    PathSweep sweep(reference, penalties, direction, max_count, max_slots);
    for (int i = 0; i < band.size(); ++i) {
      const int v = direction > 0 ? band.start + i : band.end - 1 - i;
      const std::size_t at = base[static_cast<std::size_t>(v - band.start)];
      const RowLayout& layout = layoutOf(v);
      if (direction > 0) {
        const auto* partner = census_partner.ptr<std::uint16_t>(v);
        std::reverse_copy(partner, partner + census_partner.cols, mirrored.begin());
        matchingCostRow(census_reference.ptr<std::uint16_t>(v), mirrored.data(),
                        census_partner.cols, layout, &cost[at]);
      }
      sweep.row(v, layout, i > 0 ? &layoutOf(v - direction) : nullptr, &cost[at], &sum[at]);
      if (direction < 0 && v >= keep.start && v < keep.end) {
        winner.run(&sum[at], layout, reference.cols, disparity.ptr<std::int16_t>(v));
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
    cells += layouts.back().cells * TileRanges::kTile;
  }
  // In as few bands as the memory bound allows; they overlap so that no seam shows.
  const int bands = static_cast<int>(cells / kMaxCells) + 1;
  const int rows = (reference.rows + bands - 1) / bands;
  cv::Mat disparity(reference.size(), CV_16S);
  // Kept for the thread's next pair: asking the system for this much memory again and again costs
  // more than many a step of the matching.
  thread_local BandVolume volume;
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
