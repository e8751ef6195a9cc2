// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "cf/base/instruction_sets.h"
#include "cf/features/match.h"

namespace cf {
namespace {

constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
constexpr double kPerCell = 4;  ///< features that a cell of the grid holds on average

/// Squared distances of one descriptor to `count` others.
CF_CLONES void squaredDistances(const std::uint8_t* a, const std::uint8_t* const* b, int count,
                                std::int32_t* out) {
  for (int i = 0; i < count; ++i) {
    std::int32_t sum = 0;
    for (int k = 0; k < FeatureSet::kDescriptorSize; ++k) {
      const auto d = static_cast<std::int16_t>(a[k] - b[i][k]);
      sum += d * d;
    }
    out[i] = sum;
  }
}

/// Features by their place, row after row of a grid: those of neighbouring cells of a row follow
/// each other.
class Grid {
 public:
  explicit Grid(const std::vector<Eigen::Vector2d>& position) : position_(position) {
    Eigen::Vector2d high = position.front();
    low_ = high;
    for (const auto& p : position) {
      low_ = low_.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Eigen::Vector2d size = (high - low_).cwiseMax(1e-12);
    cell_ = std::sqrt(size.prod() * kPerCell / static_cast<double>(position.size()));
    // Places on one line, or all in one point, must not make a grid without end.
    cell_ = std::max(cell_, size.maxCoeff() / 256);
    columns_ = static_cast<int>(size.x() / cell_) + 1;
    rows_ = static_cast<int>(size.y() / cell_) + 1;
    begin_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
    std::vector<std::size_t> cell_of;
    for (const auto& p : position) {
      cell_of.push_back(static_cast<std::size_t>(row(p.y()) * columns_ + column(p.x())));
      ++begin_[cell_of.back() + 1];
    }
    for (std::size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
    feature_.resize(position.size());
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < position.size(); ++i)
      feature_[static_cast<std::size_t>(next[cell_of[i]]++)] = static_cast<int>(i);
  }

  void within(const SearchDisc& disc, std::vector<int>& found) const {
    found.clear();
    const double r = disc.radius, r2 = r * r;
    if (!(r >= 0)) return;
    const int left = column(disc.centre.x() - r), right = column(disc.centre.x() + r);
    const int bottom = row(disc.centre.y() + r);
    for (int y = row(disc.centre.y() - r); y <= bottom; ++y) {
      const int end = begin_[static_cast<std::size_t>(y * columns_ + right) + 1];
      for (int i = begin_[static_cast<std::size_t>(y * columns_ + left)]; i < end; ++i) {
        const int f = feature_[static_cast<std::size_t>(i)];
        if ((position_[static_cast<std::size_t>(f)] - disc.centre).squaredNorm() <= r2)
          found.push_back(f);
      }
    }
  }

 private:
  int column(double x) const { return at(x - low_.x(), columns_); }
  int row(double y) const { return at(y - low_.y(), rows_); }
  int at(double distance, int cells) const {
    return static_cast<int>(std::clamp(distance / cell_, 0.0, cells - 1.0));
  }

  const std::vector<Eigen::Vector2d>& position_;
  Eigen::Vector2d low_;
  double cell_ = 1;
  int columns_ = 1, rows_ = 1;
  std::vector<int> begin_;    ///< of each cell in `feature_`
  std::vector<int> feature_;  ///< by cell
};

}  // namespace

std::vector<FeatureMatch> matchFeaturesWithin(const FeatureSet& a, const FeatureSet& b,
                                              const std::vector<SearchDisc>& disc_a,
                                              const std::vector<Eigen::Vector2d>& position_b,
                                              const MatchOptions& options) {
  std::vector<FeatureMatch> matches;
  if (a.size() == 0 || b.size() < 2) return matches;
  const Grid grid(position_b);
  std::vector<std::int32_t> best_of_b(b.size(), kFar), distance;
  std::vector<int> row_of_b(b.size(), -1), nearest(a.size(), -1), candidates;
  std::vector<const std::uint8_t*> rows;
  const double ratio2 = options.ratio * options.ratio;
  for (std::size_t i = 0; i < a.size(); ++i) {
    grid.within(disc_a[i], candidates);
    rows.clear();
    for (const int j : candidates) rows.push_back(b.row(static_cast<std::size_t>(j)));
    distance.resize(candidates.size());
    squaredDistances(a.row(i), rows.data(), static_cast<int>(rows.size()), distance.data());
    std::int32_t best = kFar, second = kFar;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const auto j = static_cast<std::size_t>(candidates[k]);
      const std::int32_t d = distance[k];
      if (d < best_of_b[j]) {
        best_of_b[j] = d;
        row_of_b[j] = static_cast<int>(i);
      }
      second = std::min(second, std::max(d, best));
      if (d >= best) continue;
      best = d;
      nearest[i] = candidates[k];
    }
    if (candidates.size() < 2 || !(best < ratio2 * second)) nearest[i] = -1;
  }
  for (std::size_t i = 0; i < a.size(); ++i)
    if (nearest[i] >= 0 && row_of_b[static_cast<std::size_t>(nearest[i])] == static_cast<int>(i))
      matches.push_back({static_cast<int>(i), nearest[i]});
  return matches;
}

}  // namespace cf
