// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "disparity_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "lanes.h"

namespace cf {
namespace {

using Floats = float __attribute__((vector_size(4 * kLanes)));
using Integers = std::int32_t __attribute__((vector_size(4 * kLanes)));

/// `rows` hold one pixel more on the left and whole vectors of them on the right.
CF_CLONES void smoothRow(const Cost* const* rows, int width, Cost step, Cost* out) {
  for (int u = 0; u < width; u += kLanes) {
    const Lanes centre = load<Lanes>(rows[1] + u);
    Lanes sum{}, weight = Lanes{} + Cost{4};  // of differences from the centre
    for (int j = 0; j < 3; ++j) {
      for (int i = -1; i <= 1; ++i) {
        if (j == 1 && i == 0) continue;
        // Great where there is none, even if it does not fit its type.
        const Lanes difference = load<Lanes>(rows[j] + u + i) - centre;
        const Lanes near = (difference <= step) & (difference >= static_cast<Cost>(-step));
        const auto w = static_cast<Cost>(j == 1 || i == 0 ? 2 : 1);
        sum += w * (difference & near);
        weight += w & near;
      }
    }
    const Floats mean =
        __builtin_convertvector(sum, Floats) / __builtin_convertvector(weight, Floats);
    const Integers rounded = __builtin_convertvector(mean + 64.5F, Integers) - 64;
    const Lanes smooth =
        centre + (__builtin_convertvector(rounded, Lanes) & (centre != kNoDisparity));
    std::memcpy(out + u, &smooth,
                sizeof(Cost) * static_cast<std::size_t>(std::min(kLanes, width - u)));
  }
}

/// Fills short gaps of a line whose ends agree; `last` is where the line was known last, -1 before.
CF_INLINE void fillBefore(std::int16_t* line, std::ptrdiff_t stride, int k, int max_gap,
                          int max_step, int& last) {
  const int d = line[k * stride];
  if (d == kNoDisparity) return;
  const int gap = k - last - 1;
  if (last >= 0 && gap > 0 && gap <= max_gap) {
    const int from = line[last * stride];
    for (int i = last + 1; i < k && std::abs(d - from) <= max_step; ++i) {
      line[i * stride] = static_cast<std::int16_t>(from + (d - from) * (i - last) / (k - last));
    }
  }
  last = k;
}

/// Pixels [first, end) of a row that belong together.
struct Run {
  int row, first, end;
};

/// 1 where the next pixel of the row does not belong to this one, and at the last.
CF_CLONES void markEnds(const std::int16_t* d, int n, int step, std::uint8_t* ends) {
  for (int u = 0; u + 1 < n; ++u) {
    const int difference = d[u + 1] - d[u];
    const int together = (d[u] != kNoDisparity) & (d[u + 1] != kNoDisparity) &
                         (difference <= step) & (difference >= -step);
    ends[u] = static_cast<std::uint8_t>(1 - together);
  }
  ends[n - 1] = 1;
}

/// 1 where a pixel belongs to the one of the row before.
CF_CLONES void markJoins(const std::int16_t* d, const std::int16_t* before, int n, int step,
                         std::uint8_t* joins) {
  for (int u = 0; u < n; ++u) {
    const int difference = d[u] - before[u];
    joins[u] = static_cast<std::uint8_t>((d[u] != kNoDisparity) & (before[u] != kNoDisparity) &
                                         (difference <= step) & (difference >= -step));
  }
}

/// Patches of pixels that belong together: each run of a row knows another of its patch, the root
/// itself.
class Patches {
 public:
  int add() {
    parent_.push_back(static_cast<int>(parent_.size()));
    pixels_.push_back(0);
    return parent_.back();
  }
  int root(int i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  void unite(int a, int b) {
    a = root(a);
    b = root(b);
    at(std::max(a, b)) = std::min(a, b);
  }
  void count(int run, int pixels) { pixels_[static_cast<std::size_t>(run)] += pixels; }
  /// Adds up the pixels of each patch at its root, which is the first of its runs.
  void finish() {
    for (int i = static_cast<int>(parent_.size()) - 1; i > 0; --i) {
      if (at(i) != i) count(at(i), pixels(i));
    }
    for (int i = 0; i < static_cast<int>(parent_.size()); ++i) at(i) = at(at(i));
    for (int i = 0; i < static_cast<int>(parent_.size()); ++i) {
      pixels_[static_cast<std::size_t>(i)] = pixels(at(i));
    }
  }
  int pixels(int run) const { return pixels_[static_cast<std::size_t>(run)]; }

 private:
  int& at(int i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<int> parent_, pixels_;
};

}  // namespace

void clearOutside(cv::Mat& disparity, const StereoInput& input) {
  for (int v = 0; v < disparity.rows; ++v) {
    auto* d = disparity.ptr<std::int16_t>(v);
    const auto* inside = input.reference_inside.ptr<uchar>(v);
    const auto* partner = input.partner_inside.ptr<uchar>(v);
    for (int u = 0; u < disparity.cols; ++u) {
      const int x = u - ((d[u] + 8) >> 4);
      if (!inside[u] || x < 0 || x >= input.partner.cols || !partner[x]) d[u] = kNoDisparity;
    }
  }
}

void fillGaps(cv::Mat& disparity, int max_gap_px, double max_step_px) {
  const int step = static_cast<int>(16 * max_step_px);
  const auto stride = static_cast<std::ptrdiff_t>(disparity.step1());
  for (int v = 0; v < disparity.rows; ++v) {
    int last = -1;
    for (int u = 0; u < disparity.cols; ++u) {
      fillBefore(disparity.ptr<std::int16_t>(v), 1, u, max_gap_px, step, last);
    }
  }
  // Columns side by side, as they lie in memory.
  std::vector<int> last(static_cast<std::size_t>(disparity.cols), -1);
  for (int v = 0; v < disparity.rows; ++v) {
    for (int u = 0; u < disparity.cols; ++u) {
      fillBefore(disparity.ptr<std::int16_t>(0) + u, stride, v, max_gap_px, step,
                 last[static_cast<std::size_t>(u)]);
    }
  }
}

void clearSpeckles(cv::Mat& disparity, int min_pixels, double max_step_px) {
  const int step = static_cast<int>(16 * max_step_px), width = disparity.cols;
  const auto n = static_cast<std::size_t>(width);
  Patches patches;
  std::vector<Run> runs;
  std::vector<std::uint8_t> ends(n), joins(n, 0);
  std::size_t above = 0, above_end = 0;  // the runs of the row before
  for (int v = 0; v < disparity.rows; ++v) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    markEnds(d, width, step, ends.data());
    if (v > 0) markJoins(d, disparity.ptr<std::int16_t>(v - 1), width, step, joins.data());
    for (int u = 0; u < width; ++u) {
      if (d[u] == kNoDisparity) continue;
      const auto* end = static_cast<const std::uint8_t*>(
          std::memchr(&ends[static_cast<std::size_t>(u)], 1, n - static_cast<std::size_t>(u)));
      const Run run{v, u, static_cast<int>(end - ends.data()) + 1};
      const int number = patches.add();
      patches.count(number, run.end - run.first);
      runs.push_back(run);
      while (above < above_end && runs[above].end <= run.first) ++above;
      for (std::size_t k = above; k < above_end && runs[k].first < run.end; ++k) {
        const int first = std::max(run.first, runs[k].first), last = std::min(run.end, runs[k].end);
        if (std::memchr(&joins[static_cast<std::size_t>(first)], 1,
                        static_cast<std::size_t>(last - first)))
          patches.unite(number, static_cast<int>(k));
      }
      u = run.end - 1;
    }
    above = above_end;
    above_end = runs.size();
  }
  patches.finish();
  for (std::size_t k = 0; k < runs.size(); ++k) {
    if (patches.pixels(static_cast<int>(k)) >= min_pixels) continue;
    auto* d = disparity.ptr<std::int16_t>(runs[k].row);
    std::fill(d + runs[k].first, d + runs[k].end, kNoDisparity);
  }
}

void smoothDisparity(cv::Mat& disparity, double max_step_px) {
  cv::Mat in;
  cv::copyMakeBorder(disparity, in, 1, 1, 1, kLanes, cv::BORDER_CONSTANT, kNoDisparity);
  const auto step = static_cast<Cost>(16 * max_step_px);
  for (int v = 0; v < disparity.rows; ++v) {
    const std::int16_t* rows[] = {in.ptr<std::int16_t>(v) + 1, in.ptr<std::int16_t>(v + 1) + 1,
                                  in.ptr<std::int16_t>(v + 2) + 1};
    smoothRow(rows, disparity.cols, step, disparity.ptr<std::int16_t>(v));
  }
}

}  // namespace cf
