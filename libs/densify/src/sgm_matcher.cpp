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
constexpr std::size_t kOutliers = 33;  // one of so many at both ends does not widen a tile's range
constexpr int kMinSide = 64;           // px, of the coarsest level
constexpr int kMargin = 3;             // px of the finer level, beyond what the coarser one found
constexpr int kNear = 3, kWide = 12;   // px of the coarser level around a tile
constexpr int kSpeckle = 120;          // px, smaller patches are dropped
constexpr double kMinKnown = 0.02;     // share of the pixels around a tile that must be known
constexpr int kEverywhereStride = 4;
constexpr int kCoarseSpeckle = 24;  // px of a coarser level
constexpr double kSpeckleStepPx = 1.5;
constexpr std::size_t kFillLevels = 3;  // the finest and those that fill its holes

struct DisparityRange {
  int min = 0, max = 0;  // px, both included
};

/// Least and greatest disparity [1/16 px] in an area, and the share of its pixels that have one.
struct AreaRange {
  int min = 0, max = 0, median = 0;
  double known = 0;
};

AreaRange rangeIn(const cv::Mat& disparity, cv::Rect area, int stride) {
  AreaRange range;
  std::vector<std::int16_t> known;
  for (int v = area.y; v < area.y + area.height; v += stride) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    for (int u = area.x; u < area.x + area.width; u += stride) {
      if (d[u] == kNoDisparity) continue;
      known.push_back(d[u]);
    }
  }
  if (known.empty()) return range;
  const std::size_t outer = known.size() / kOutliers;
  const auto first = known.begin(), last = known.end();
  const auto low = first + static_cast<std::ptrdiff_t>(outer), high = last - 1 - (low - first);
  const auto middle = first + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(first, middle, last);
  range.median = *middle;
  std::nth_element(first, low, middle + 1);
  range.min = *low;
  std::nth_element(middle, high, last);
  range.max = *high;
  range.known = static_cast<double>(known.size()) * stride * stride / std::max(1, area.area());
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
  const cv::Rect all(0, 0, coarse.cols, coarse.rows);
  const AreaRange everywhere = rangeIn(coarse, all, kEverywhereStride);
  constexpr int kSide = TileRanges::kTile / 2;
  for (int row = 0; row < ranges.rows; ++row) {
    for (int column = 0; column < ranges.columns; ++column) {
      const cv::Rect tile(column * kSide, row * kSide, kSide, kSide);
      const auto around = [&](int by) {
        return rangeIn(coarse,
                       cv::Rect(tile.x - by, tile.y - by, kSide + 2 * by, kSide + 2 * by) & all,
                       by / kNear);
      };
      AreaRange found = around(kNear);
      if (found.known < 0.5) found = around(kWide);
      if (found.known < kMinKnown) found = everywhere;
      DisparityRange range = whole;
      if (found.known > 0) {
        range.min = std::clamp(2 * found.min / 16 - kMargin, whole.min, whole.max);
        range.max = std::clamp(2 * found.max / 16 + kMargin, whole.min, whole.max);
      }
      if (range.max - range.min >= kMaxSearch) {
        range.min = std::clamp(2 * found.median / 16 - kMaxSearch / 2, range.min,
                               range.max - kMaxSearch + 1);
        range.max = range.min + kMaxSearch - 1;
      }
      const cv::Rect fine_tile(2 * tile.x, 2 * tile.y, TileRanges::kTile, TileRanges::kTile);
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
      clearSpeckles(disparity, k > 0 ? kCoarseSpeckle : kSpeckle, kSpeckleStepPx);
      coarse = disparity.clone();
      if (k >= kFillLevels) continue;
      if (k == 0) refineDisparity(disparity, level);
      smoothDisparity(disparity, 1);
      StereoOutput here{disparity, confidenceOf(disparity, level)};
      if (!output.disparity.empty()) fillFromCoarse(here, output);
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
