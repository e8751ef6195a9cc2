// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "elas_support.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cf {
namespace {

constexpr int kGrid = 5;             // px
constexpr int kMinTexture = 96;      // sum of absolute responses of a support descriptor
constexpr double kUniqueness = 0.9;  // greatest ratio of the best difference to the second best
constexpr int kAround = 4;           // cells of the grid in which points support each other
constexpr int kAlike = 6;            // px, of disparities that do
constexpr int kMinAlike = 4;         // of those around
constexpr int kUnknown = INT16_MIN;

struct Best {
  int at = kUnknown;  // index of the least difference
  int least = std::numeric_limits<int>::max();
  int second = least;  // of those not beside it
};

/// Compares one descriptor to the n from `to` on.
CF_CLONES void differences(const std::uint8_t* from, const std::uint8_t* to, int n, int* out) {
  for (int k = 0; k < n; ++k) {
    out[k] = difference<DescriptorRow::kSupport>(from, to + DescriptorRow::kSupport * k);
  }
}

CF_CLONES int texture(const std::uint8_t* descriptor) {
  int sum = 0;
  for (int k = 0; k < DescriptorRow::kSupport - 1; ++k) sum += std::abs(descriptor[k] - 128);
  return sum;
}

CF_CLONES int leastOf(const int* values, int n) {
  int least = std::numeric_limits<int>::max();
  for (int k = 0; k < n; ++k) least = std::min(least, values[k]);
  return least;
}

Best bestOf(const int* difference, int n) {
  Best best;
  best.least = leastOf(difference, n);
  best.at = static_cast<int>(std::find(difference, difference + n, best.least) - difference);
  const int before = std::max(0, best.at - 1), after = std::min(n, best.at + 2);
  best.second = std::min(leastOf(difference, before), leastOf(difference + after, n - after));
  return best;
}

/// Searches one grid row after the other.
class SupportSearch {
 public:
  SupportSearch(const StereoInput& input, const SobelImages& reference, const SobelImages& partner)
      : input_(input),
        reference_(reference),
        partner_(partner),
        difference_(static_cast<std::size_t>(std::max(reference.size.width, partner.size.width))) {}

  /// Disparity of each grid point [px] or kUnknown.
  cv::Mat run() {
    const cv::Size size = reference_.size;
    cv::Mat grid(size.height / kGrid, size.width / kGrid, CV_16S, cv::Scalar(kUnknown));
    for (int j = 0; j < grid.rows; ++j) {
      const int v = j * kGrid + kGrid / 2;
      row_.makeSupport(reference_, v);
      partner_row_.makeSupport(partner_, v);
      for (int i = 0; i < grid.cols; ++i) {
        grid.at<std::int16_t>(j, i) =
            static_cast<std::int16_t>(disparityAt(i * kGrid + kGrid / 2, v));
      }
    }
    return grid;
  }

 private:
  static const std::uint8_t* descriptor(const DescriptorRow& row, int u) {
    return row.values.data() + static_cast<std::ptrdiff_t>(DescriptorRow::kSupport) * u;
  }

  Best search(const std::uint8_t* from, const DescriptorRow& in, int first, int last) {
    if (last - first < 2) return {};
    differences(from, descriptor(in, first), last - first + 1, difference_.data());
    Best best = bestOf(difference_.data(), last - first + 1);
    best.at += first;
    return best;
  }

  int disparityAt(int u, int v) {
    const std::uint8_t* own = descriptor(row_, u);
    if (!input_.reference_inside.at<uchar>(v, u) || texture(own) < kMinTexture) return kUnknown;
    const int low = input_.min_disparity_px, high = input_.max_disparity_px;
    const Best there = search(own, partner_row_, std::max(0, u - high),
                              std::min(partner_.size.width - 1, u - low));
    if (there.at == kUnknown || there.least > kUniqueness * there.second) return kUnknown;
    if (!input_.partner_inside.at<uchar>(v, there.at)) return kUnknown;
    const Best back = search(descriptor(partner_row_, there.at), row_, std::max(0, there.at + low),
                             std::min(reference_.size.width - 1, there.at + high));
    if (back.at == kUnknown || std::abs(back.at - u) > 1) return kUnknown;
    if (back.least > kUniqueness * back.second) return kUnknown;
    return u - there.at;
  }

  const StereoInput& input_;
  const SobelImages &reference_, &partner_;
  DescriptorRow row_, partner_row_;
  std::vector<int> difference_;
};

bool hasAlike(const cv::Mat& grid, int i, int j) {
  const int d = grid.at<std::int16_t>(j, i);
  int alike = -1;  // it is alike itself
  for (int y = std::max(0, j - kAround); y <= std::min(grid.rows - 1, j + kAround); ++y) {
    const auto* row = grid.ptr<std::int16_t>(y);
    for (int x = std::max(0, i - kAround); x <= std::min(grid.cols - 1, i + kAround); ++x) {
      alike += std::abs(row[x] - d) <= kAlike;
    }
  }
  return alike >= kMinAlike;
}

}  // namespace

std::vector<SupportPoint> supportPoints(const StereoInput& input, const SobelImages& reference,
                                        const SobelImages& partner) {
  const cv::Mat grid = SupportSearch(input, reference, partner).run();
  std::vector<SupportPoint> points;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.cols; ++i) {
      const int d = grid.at<std::int16_t>(j, i);
      if (d == kUnknown || !hasAlike(grid, i, j)) continue;
      points.push_back({i * kGrid + kGrid / 2, j * kGrid + kGrid / 2, d});
    }
  }
  return points;
}

}  // namespace cf
