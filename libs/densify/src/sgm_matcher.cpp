// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "cf/densify/stereo_matcher.h"
#include "disparity_filter.h"
#include "elas_matcher.h"
#include "semi_global.h"

namespace cf {
namespace {

constexpr int kFullSearch = 64;        // px, disparities searched everywhere at the coarsest level
constexpr int kMaxSearch = 64;         // px, disparities searched in a tile of a finer level
constexpr std::size_t kOutliers = 33;  // one of so many at both ends is not searched for everywhere
constexpr int kMinSide = 64;           // px, of the coarsest level
constexpr int kMargin = 3;             // px of the finer level, beyond what the coarser one found
constexpr int kNear = 1, kWide = 3;    // tiles around a tile
constexpr int kSpeckle = 120;          // px, smaller patches are dropped
constexpr double kMinKnown = 0.02;     // share of the pixels around a tile that must be known
constexpr int kEverywhereStride = 4;
constexpr int kCoarseSpeckle = 24;  // px of a coarser level
constexpr double kSpeckleStepPx = 1.5;
constexpr int kMaxGap = 5;  // px
constexpr double kMaxGapStepPx = 1;
constexpr std::size_t kFillLevels = 3;  // the finest and those that fill its holes

struct DisparityRange {
  int min = 0, max = 0;  // px, both included
};

/// What is known of the disparities [1/16 px] in an area.
struct AreaRange {
  int min = INT16_MAX, max = INT16_MIN;
  int sum = 0, known = 0, pixels = 0;

  void add(const AreaRange& other) {
    min = std::min(min, other.min);
    max = std::max(max, other.max);
    sum += other.sum;
    known += other.known;
    pixels += other.pixels;
  }
  bool isKnown(double share) const { return known > 0 && known >= share * pixels; }
};

/// The ranges of square cells of an image.
class CellRanges {
 public:
  CellRanges(const cv::Mat& disparity, int side)
      : columns_((disparity.cols + side - 1) / side), rows_((disparity.rows + side - 1) / side) {
    cells_.resize(static_cast<std::size_t>(columns_ * rows_));
    for (int v = 0; v < disparity.rows; ++v) {
      const auto* d = disparity.ptr<std::int16_t>(v);
      AreaRange* row = &cells_[static_cast<std::size_t>(v / side * columns_)];
      for (int u = 0; u < disparity.cols; ++u) {
        AreaRange& cell = row[u / side];
        ++cell.pixels;
        if (d[u] == kNoDisparity) continue;
        cell.min = std::min<int>(cell.min, d[u]);
        cell.max = std::max<int>(cell.max, d[u]);
        cell.sum += d[u];
        ++cell.known;
      }
    }
  }
  /// Of the cells up to `radius` away.
  AreaRange around(int column, int row, int radius) const {
    AreaRange all;
    for (int j = std::max(0, row - radius); j <= std::min(rows_ - 1, row + radius); ++j) {
      for (int i = std::max(0, column - radius); i <= std::min(columns_ - 1, column + radius); ++i)
        all.add(cells_[static_cast<std::size_t>(j * columns_ + i)]);
    }
    return all;
  }

 private:
  int columns_, rows_;
  std::vector<AreaRange> cells_;
};

/// The disparities [1/16 px] but for the outermost at both ends.
AreaRange everywhereIn(const cv::Mat& disparity) {
  std::vector<std::int16_t> known;
  for (int v = 0; v < disparity.rows; v += kEverywhereStride) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    for (int u = 0; u < disparity.cols; u += kEverywhereStride) {
      if (d[u] != kNoDisparity) known.push_back(d[u]);
    }
  }
  AreaRange range;
  if (known.empty()) return range;
  std::sort(known.begin(), known.end());
  const std::size_t outer = known.size() / kOutliers;
  range.min = known[outer];
  range.max = known[known.size() - 1 - outer];
  range.sum = known[known.size() / 2];
  range.known = range.pixels = 1;
  return range;
}

/// Can any pixel of a tile match at one of the disparities? Looks at the tile's middle row.
bool matchable(const StereoInput& level, cv::Rect tile, DisparityRange range) {
  const int v = std::min(tile.y + tile.height / 2, level.reference.rows - 1);
  const auto any = [v](const cv::Mat& inside, int first, int last) {
    first = std::clamp(first, 0, inside.cols - 1);
    last = std::clamp(last, 0, inside.cols - 1);
    return cv::countNonZero(inside(cv::Rect(first, v, last - first + 1, 1))) > 0;
  };
  return any(level.reference_inside, tile.x, tile.x + tile.width) &&
         any(level.partner_inside, tile.x - range.max, tile.x + tile.width - range.min);
}

/// What to search at the next finer level, from the disparities of this one.
TileRanges refinedRanges(const cv::Mat& coarse, const StereoInput& level) {
  const DisparityRange whole{level.min_disparity_px, level.max_disparity_px};
  TileRanges ranges(level.reference.size(), whole.min, whole.max - whole.min + 1);
  const AreaRange everywhere = everywhereIn(coarse);
  const CellRanges cells(coarse, TileRanges::kTile / 2);
  for (int row = 0; row < ranges.rows; ++row) {
    for (int column = 0; column < ranges.columns; ++column) {
      AreaRange found = cells.around(column, row, kNear);
      if (!found.isKnown(0.5)) found = cells.around(column, row, kWide);
      if (!found.isKnown(kMinKnown)) found = everywhere;
      DisparityRange range = whole;
      if (found.known > 0) {
        range.min = std::clamp(2 * found.min / 16 - kMargin, whole.min, whole.max);
        range.max = std::clamp(2 * found.max / 16 + kMargin, whole.min, whole.max);
        if (range.max - range.min >= kMaxSearch) {
          const int middle = 2 * (found.sum / found.known) / 16;
          range.min = std::clamp(middle - kMaxSearch / 2, range.min, range.max - kMaxSearch + 1);
          range.max = range.min + kMaxSearch - 1;
        }
      }
      const cv::Rect fine_tile(column * TileRanges::kTile, row * TileRanges::kTile,
                               TileRanges::kTile, TileRanges::kTile);
      const std::size_t at = ranges.at(column, row);
      if (!matchable(level, fine_tile, range)) {
        ranges.count_px[at] = 0;
        continue;
      }
      // Aligned, so that neighbouring tiles often share their range.
      ranges.min_px[at] = static_cast<int>(std::floor(range.min / 4.0)) * 4;
      ranges.count_px[at] = TileRanges::roundedUp(range.max - ranges.min_px[at] + 1);
    }
  }
  return ranges;
}

cv::Mat halved(const cv::Mat& inside, cv::Size size) {
  cv::Mat half;
  cv::resize(inside, half, size, 0, 0, cv::INTER_NEAREST);
  return half;
}

/// One level of the pyramid: pixel k of it is pixel 2 k of the finer one.
StereoInput coarser(const StereoInput& fine) {
  StereoInput half;
  cv::pyrDown(fine.reference, half.reference);
  cv::pyrDown(fine.partner, half.partner);
  half.reference_inside = halved(fine.reference_inside, half.reference.size());
  half.partner_inside = halved(fine.partner_inside, half.partner.size());
  half.min_disparity_px = fine.min_disparity_px / 2 - 1;
  half.max_disparity_px = fine.max_disparity_px / 2 + 1;
  return half;
}

class SgmMatcher : public StereoMatcher {
 public:
  StereoOutput match(const StereoInput& input) const override {
    std::vector<StereoInput> levels{input};
    while (levels.back().max_disparity_px - levels.back().min_disparity_px > kFullSearch &&
           std::min(levels.back().reference.cols, levels.back().reference.rows) > 2 * kMinSide) {
      levels.push_back(coarser(levels.back()));
    }
    StereoOutput output;
    cv::Mat coarse;
    for (std::size_t k = levels.size(); k-- > 0;) {
      const StereoInput& level = levels[k];
      const cv::Size size = level.reference.size();
      const TileRanges ranges =
          coarse.empty() ? TileRanges(size, level.min_disparity_px,
                                      level.max_disparity_px - level.min_disparity_px + 1)
                         : refinedRanges(coarse, level);
      cv::Mat disparity = semiGlobalMatch(level.reference, level.partner, ranges);
      clearOutside(disparity, level);
      if (k > 0) {
        const cv::Mat raw = disparity.clone();
        clearSpeckles(disparity, kCoarseSpeckle, kSpeckleStepPx);
        fillByVote(disparity, raw);
        clearOutside(disparity, level);
      } else {
        clearSpeckles(disparity, kSpeckle, kSpeckleStepPx);
      }
      coarse = disparity.clone();
      if (k >= kFillLevels) continue;
      if (k == 0) {
        fillGaps(disparity, kMaxGap, kMaxGapStepPx);
        refineDisparity(disparity, level);
      }
      smoothDisparity(disparity, 1);
      StereoOutput here{disparity, confidenceOf(disparity, level)};
      if (!output.disparity.empty()) fillFromCoarse(here, output, level.partner.cols);
      output = here;
    }
    return output;
  }
};

}  // namespace

std::unique_ptr<StereoMatcher> makeStereoMatcher(const DensifyOptions& options) {
  if (options.matcher == "elas") return std::make_unique<ElasMatcher>();
  CV_Assert(options.matcher == "sgm");
  return std::make_unique<SgmMatcher>();
}

}  // namespace cf
