// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/match.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "cf/base/instruction_sets.h"
#include "dot_tile.h"

namespace cf {
namespace {

constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t kPadding = 1 << 30;  ///< squared norm that is farther than any descriptor

/// Squared norms, padded to whole tiles.
std::vector<std::int32_t> squaredNorms(const FeatureSet& set, int padded) {
  std::vector<std::int32_t> norms(static_cast<std::size_t>(padded), kPadding);
  for (std::size_t i = 0; i < set.size(); ++i) {
    norms[i] = 0;
    for (int k = 0; k < FeatureSet::kDescriptorSize; ++k) {
      const std::int32_t v = set.row(i)[k];
      norms[i] += v * v;
    }
  }
  return norms;
}

constexpr int kLanes = 16;
using Lanes = std::int32_t __attribute__((vector_size(4 * kLanes)));

CF_INLINE Lanes load(const std::int32_t* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}
CF_INLINE void store(const Lanes& lanes, std::int32_t* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

/// Nearest and second nearest of one descriptor of a among every 16th of b.
struct RowBest {
  std::int32_t best[kLanes], second[kLanes], block[kLanes];
};

/// Squared distances from the products of a tile, entered into the bests of its rows and columns.
/// The first of equals stays. Blocks are sixteen columns wide.
CF_CLONES void enter(const std::int32_t* dots, const std::int32_t* row_norm, int first_row,
                     int rows, int first_block, const std::int32_t* column_norm, RowBest* row_best,
                     std::int32_t* column_best, std::int32_t* column_row) {
  for (int c = 0; c < kTileColumns; c += kLanes) {
    const Lanes norm = load(column_norm + c);
    Lanes nearest = load(column_best + c), nearest_row = load(column_row + c);
    for (int r = 0; r < rows; ++r) {
      RowBest& row = row_best[r];
      const Lanes d = row_norm[r] + norm - 2 * load(dots + r * kTileColumns + c);
      const Lanes best = load(row.best), second = load(row.second), block = load(row.block);
      const Lanes loser = d < best ? best : d;
      store(loser < second ? loser : second, row.second);
      store(d < best ? Lanes{} + (first_block + c / kLanes) : block, row.block);
      store(d < best ? d : best, row.best);
      nearest_row = d < nearest ? Lanes{} + (first_row + r) : nearest_row;
      nearest = d < nearest ? d : nearest;
    }
    store(nearest, column_best + c);
    store(nearest_row, column_row + c);
  }
}

/// Column of the nearest, or -1 if the second nearest is too like it.
int distinctNearest(const RowBest& row, double ratio) {
  std::int32_t best = kFar, second = kFar;
  int nearest = -1;
  for (int c = 0; c < kLanes; ++c) {
    const int column = row.block[c] * kLanes + c;
    const bool wins = row.best[c] < best || (row.best[c] == best && column < nearest);
    second = std::min({second, row.second[c], wins ? best : row.best[c]});
    if (!wins) continue;
    best = row.best[c];
    nearest = column;
  }
  return best < ratio * ratio * second ? nearest : -1;
}

}  // namespace

std::vector<FeatureMatch> matchFeatures(const FeatureSet& a, const FeatureSet& b,
                                        const MatchOptions& options) {
  std::vector<FeatureMatch> matches;
  if (a.size() < 2 || b.size() < 2) return matches;
  const DotTiles tiles(a, b);
  const int columns = tiles.tileColumns() * kTileColumns;
  const auto norm_a = squaredNorms(a, tiles.tileRows() * kTileRows);
  const auto norm_b = squaredNorms(b, columns);
  std::vector<std::int32_t> column_best(norm_b.size(), kFar), column_row(norm_b.size(), -1);
  std::vector<int> nearest(a.size(), -1);
  const int rows = static_cast<int>(a.size());
  for (int i = 0; i < tiles.tileRows(); ++i) {
    RowBest best[kTileRows];
    for (RowBest& row : best) {
      std::fill(std::begin(row.best), std::end(row.best), kFar);
      std::fill(std::begin(row.second), std::end(row.second), kFar);
      std::fill(std::begin(row.block), std::end(row.block), 0);
    }
    const int first = i * kTileRows, count = std::min(kTileRows, rows - first);
    for (int j = 0; j < tiles.tileColumns(); ++j) {
      std::int32_t dots[kTileRows * kTileColumns];
      tiles.compute(i, j, dots);
      const auto column = static_cast<std::size_t>(j * kTileColumns);
      enter(dots, norm_a.data() + first, first, count, j * (kTileColumns / kLanes),
            norm_b.data() + column, best, column_best.data() + column, column_row.data() + column);
    }
    for (int r = 0; r < count; ++r)
      nearest[static_cast<std::size_t>(first + r)] = distinctNearest(best[r], options.ratio);
  }
  for (int i = 0; i < rows; ++i) {
    const int j = nearest[static_cast<std::size_t>(i)];
    if (j >= 0 && column_row[static_cast<std::size_t>(j)] == i) matches.push_back({i, j});
  }
  return matches;
}

}  // namespace cf
