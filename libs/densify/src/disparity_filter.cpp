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
  const int step = static_cast<int>(16 * max_step_px);
  Patches patches;
  std::vector<int> run(static_cast<std::size_t>(disparity.cols)), above(run);  // of each pixel
  for (int v = 0; v < disparity.rows; ++v) {
    const auto* d = disparity.ptr<std::int16_t>(v);
    const auto* before = v > 0 ? disparity.ptr<std::int16_t>(v - 1) : nullptr;
    std::swap(run, above);
    int united = -1;  // the run above that this pixel's run was joined with last
    int current = -1, first = 0;
    for (int u = 0; u < disparity.cols; ++u) {
      const auto k = static_cast<std::size_t>(u);
      if (d[u] == kNoDisparity) {
        if (current >= 0) patches.count(current, u - first);
        run[k] = current = -1;
        continue;
      }
      if (current < 0 || std::abs(d[u] - d[u - 1]) > step) {
        if (current >= 0) patches.count(current, u - first);
        current = patches.add();
        first = u;
        united = -1;
      }
      run[k] = current;
      if (!before || before[u] == kNoDisparity || above[k] == united) continue;
      if (std::abs(d[u] - before[u]) > step) continue;
      united = above[k];
      patches.unite(current, united);
    }
    if (current >= 0) patches.count(current, disparity.cols - first);
  }
  patches.finish();
  int current = -1;
  for (int v = 0; v < disparity.rows; ++v) {
    auto* d = disparity.ptr<std::int16_t>(v);
    int last = kNoDisparity;
    for (int u = 0; u < disparity.cols; ++u) {
      const int here = d[u];
      if (here != kNoDisparity) {
        if (last == kNoDisparity || std::abs(here - last) > step) ++current;
        if (patches.pixels(current) < min_pixels) d[u] = kNoDisparity;
      }
      last = here;
    }
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
