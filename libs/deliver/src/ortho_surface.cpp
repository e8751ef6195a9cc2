// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ortho_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace cf {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr int kLevels = 5;  ///< 2^5 = kLattice
static_assert(1 << kLevels == OrthoSurface::kLattice);
/// Holes of up to twice so many cells of the lattice are bridged.
constexpr int kBridge = 5;
/// Share of a lattice cell's heights below its own: ground rather than roofs.
constexpr double kLatticeQuantile = 0.3;
/// Nodes around which heights must be dense, and how much; holes narrower are bridged.
constexpr int kDense = 31, kNarrow = 15;
constexpr double kDenseShare = 0.6;
constexpr double kInsideShare = 0.75;
/// Smoothing of the rim and of the surface in large holes, in cells of the lattice: photos laid on
/// steep slopes that nobody measured would swirl.
constexpr double kRimCells = 2, kSmoothCells = 3;
/// Lattice cells around a window whose data reach into its holes.
constexpr int kFillMargin = 2;

/// 255 where there is a height. (OpenCV's own comparison takes NaN to be equal to NaN in part.)
cv::Mat hasHeight(const cv::Mat& heights) {
  cv::Mat mask(heights.size(), CV_8UC1);
  for (int y = 0; y < heights.rows; ++y)
    std::transform(heights.ptr<float>(y), heights.ptr<float>(y) + heights.cols,
                   mask.ptr<std::uint8_t>(y),
                   [](float z) { return static_cast<std::uint8_t>(std::isnan(z) ? 0 : 255); });
  return mask;
}

/// Means of 2 x 2 cells, of those that have a height.
cv::Mat halved(const cv::Mat& heights) {
  cv::Mat out(heights.rows / 2, heights.cols / 2, CV_32FC1);
  for (int y = 0; y < out.rows; ++y) {
    const auto *a = heights.ptr<float>(2 * y), *b = heights.ptr<float>(2 * y + 1);
    for (int x = 0; x < out.cols; ++x) {
      float sum = 0;
      int count = 0;
      for (const float z : {a[2 * x], a[2 * x + 1], b[2 * x], b[2 * x + 1]})
        if (!std::isnan(z)) {
          sum += z;
          ++count;
        }
      out.at<float>(y, x) = count > 0 ? sum / static_cast<float>(count) : kNone;
    }
  }
  return out;
}

/// Cells without a height take it from a raster of half the size that has all.
void fillFrom(const cv::Mat& coarse, cv::Mat& heights) {
  cv::Mat smooth;
  cv::resize(coarse, smooth, heights.size(), 0, 0, cv::INTER_LINEAR);
  heights.copyTo(smooth, hasHeight(heights));
  heights = smooth;
}

/// Spreads heights into all cells, from near ones.
cv::Mat spread(const cv::Mat& heights) {
  if (cv::countNonZero(hasHeight(heights)) == static_cast<int>(heights.total()))
    return heights.clone();
  if (heights.total() <= 1) return cv::Mat::zeros(heights.size(), CV_32FC1);
  cv::Mat even;
  cv::copyMakeBorder(heights, even, 0, heights.rows % 2, 0, heights.cols % 2, cv::BORDER_CONSTANT,
                     cv::Scalar(kNone));
  if (even.rows == 1) cv::copyMakeBorder(even, even, 0, 1, 0, 0, cv::BORDER_REPLICATE);
  if (even.cols == 1) cv::copyMakeBorder(even, even, 0, 0, 0, 1, cv::BORDER_REPLICATE);
  fillFrom(spread(halved(even)), even);
  return even(cv::Rect(0, 0, heights.cols, heights.rows)).clone();
}

int divideUp(int a, int b) { return (a + b - 1) / b; }
int floorTo(int a, int step) { return (a >= 0 ? a / step : -((-a + step - 1) / step)) * step; }

}  // namespace

OrthoSurface::OrthoSurface(const std::filesystem::path& dsm, double gsd_m) : dsm_(dsm) {
  const double cell_m = dsm_.grid().cell_m;
  if (gsd_m < cell_m)
    pixels_per_node_ = std::max(1, static_cast<int>(std::lround(cell_m / gsd_m)));
  else
    cells_per_node_ = std::max(1, static_cast<int>(std::lround(gsd_m / cell_m)));
  node_m_ = cell_m * cells_per_node_;
  size_ = {divideUp(dsm_.grid().width, cells_per_node_),
           divideUp(dsm_.grid().height, cells_per_node_)};

  const cv::Size cells(divideUp(size_.width, kLattice), divideUp(size_.height, kLattice));
  cv::Mat heights(cells, CV_32FC1, cv::Scalar(kNone)), tops = heights.clone();
  cv::Mat has_data = cv::Mat::zeros(cells, CV_8UC1);
  std::vector<float> column;
  for (int y = 0; y < cells.height; ++y) {
    const cv::Mat row = nodes({0, y * kLattice, cells.width * kLattice, kLattice});
    for (int x = 0; x < cells.width; ++x) {
      column.clear();
      for (int v = 0; v < kLattice; ++v) {
        const auto* z = row.ptr<float>(v) + x * kLattice;
        std::copy_if(z, z + kLattice, std::back_inserter(column),
                     [](float value) { return !std::isnan(value); });
      }
      if (column.empty()) continue;
      has_data.at<std::uint8_t>(y, x) = 255;
      tops.at<float>(y, x) = *std::max_element(column.begin(), column.end());
      if (static_cast<double>(column.size()) < kDenseShare * kLattice * kLattice) continue;
      const auto low = column.begin() + static_cast<std::ptrdiff_t>(
                                            kLatticeQuantile * static_cast<double>(column.size()));
      std::nth_element(column.begin(), low, column.end());
      heights.at<float>(y, x) = *low;
    }
  }
  const cv::Mat disc =
      cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * kBridge + 1, 2 * kBridge + 1));
  cv::Mat bordered;
  cv::copyMakeBorder(has_data, bordered, kBridge, kBridge, kBridge, kBridge, cv::BORDER_CONSTANT);
  cv::morphologyEx(bordered, bordered, cv::MORPH_CLOSE, disc);
  cv::GaussianBlur(bordered, bordered, {0, 0}, kRimCells);
  inside_ = bordered(cv::Rect(kBridge, kBridge, cells.width, cells.height)).clone();
  cv::GaussianBlur(spread(heights), smooth_, {0, 0}, kSmoothCells, 0, cv::BORDER_REPLICATE);
  lattice_ = smooth_.clone();
  heights.copyTo(lattice_, hasHeight(heights));
  cv::patchNaNs(tops, -1e9);
  cv::dilate(tops, lattice_top_, cv::Mat::ones(7, 7, CV_8UC1));
}

cv::Mat OrthoSurface::nodes(const cv::Rect& area) const {
  const int n = cells_per_node_;
  cv::Mat cells;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    cells = dsm_.heights({area.x * n, area.y * n, area.width * n, area.height * n});
  }
  if (n == 1) return cells;
  cv::Mat out(area.size(), CV_32FC1);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      float sum = 0;
      int count = 0;
      for (int v = 0; v < n; ++v)
        for (int u = 0; u < n; ++u)
          if (const float z = cells.at<float>(y * n + v, x * n + u); !std::isnan(z)) {
            sum += z;
            ++count;
          }
      out.at<float>(y, x) = count > 0 ? sum / static_cast<float>(count) : kNone;
    }
  return out;
}

OrthoSurface::Window OrthoSurface::window(const cv::Rect& area) const {
  // Whole lattice cells, so that the pyramid over them is the same in every window.
  const cv::Point low(floorTo(area.x, kLattice) - kFillMargin * kLattice,
                      floorTo(area.y, kLattice) - kFillMargin * kLattice);
  const cv::Point high(floorTo(area.br().x - 1, kLattice) + (kFillMargin + 1) * kLattice,
                       floorTo(area.br().y - 1, kLattice) + (kFillMargin + 1) * kLattice);
  const cv::Rect wide(low, high);
  cv::Mat heights = nodes(wide);
  // Scattered heights among holes say little and would make waves: only dense ones count.
  cv::Mat has = hasHeight(heights), density;
  cv::boxFilter(has, density, CV_8U, {kDense, kDense});
  has &= density > 255 * kDenseShare;
  // Small holes among them are bridged by what is around, larger ones by the lattice.
  cv::Mat small;
  cv::morphologyEx(has, small, cv::MORPH_CLOSE, cv::Mat::ones(kNarrow, kNarrow, CV_8UC1));
  heights.setTo(cv::Scalar(kNone), ~has);
  std::vector<cv::Mat> pyramid = {heights};
  for (int level = 0; level < kLevels; ++level) pyramid.push_back(halved(pyramid.back()));
  cv::Mat& coarse = pyramid.back();
  cv::Mat smooth(coarse.size(), CV_32FC1), inside(coarse.size(), CV_8UC1);
  const cv::Rect cells({0, 0}, lattice_.size());
  for (int y = 0; y < coarse.rows; ++y)
    for (int x = 0; x < coarse.cols; ++x) {
      const cv::Point cell(low.x / kLattice + x, low.y / kLattice + y);
      const cv::Point nearest(std::clamp(cell.x, 0, lattice_.cols - 1),
                              std::clamp(cell.y, 0, lattice_.rows - 1));
      smooth.at<float>(y, x) = smooth_.at<float>(nearest);
      inside.at<std::uint8_t>(y, x) = cells.contains(cell) ? inside_.at<std::uint8_t>(cell) : 0;
    }
  smooth.copyTo(coarse, ~hasHeight(coarse));
  for (std::size_t level = kLevels; level > 0; --level)
    fillFrom(pyramid[level], pyramid[level - 1]);
  cv::Mat fine_smooth, fine_inside;
  cv::resize(smooth, fine_smooth, wide.size(), 0, 0, cv::INTER_LINEAR);
  cv::resize(inside, fine_inside, wide.size(), 0, 0, cv::INTER_LINEAR);
  heights = pyramid[0];
  fine_smooth.copyTo(heights, ~small);
  // The rim is where data end, or half a cell inside where they are scattered; no specks.
  cv::Mat shown = small | (fine_inside > 255 * kInsideShare);
  cv::morphologyEx(shown, shown, cv::MORPH_OPEN, cv::Mat::ones(kNarrow, kNarrow, CV_8UC1));
  const cv::Rect part(area.tl() - low, area.size());
  return {heights(part).clone(), shown(part).clone()};
}

}  // namespace cf
