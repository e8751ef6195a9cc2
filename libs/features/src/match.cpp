// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/match.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace cf {
namespace {

constexpr int kD = FeatureSet::kDescriptorSize;

/// Dot products of one row with `count` rows of 128. Integer, so every clone gives the same result.
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"))) void dotRows(
    const std::int16_t* a, const std::int16_t* rows, int count, std::int32_t* out) {
  for (int j = 0; j < count; ++j) {
    const std::int16_t* b = rows + static_cast<std::ptrdiff_t>(j) * kD;
    std::int32_t sum = 0;
    for (int k = 0; k < kD; ++k) sum += static_cast<std::int32_t>(a[k]) * b[k];
    out[j] = sum;
  }
}

struct Widened {
  std::vector<std::int16_t> rows;
  std::vector<std::int32_t> squared_norm;

  explicit Widened(const FeatureSet& set)
      : rows(set.descriptor.begin(), set.descriptor.end()), squared_norm(set.size()) {
    for (std::size_t i = 0; i < set.size(); ++i) {
      std::int32_t sum = 0;
      for (int k = 0; k < kD; ++k) {
        const std::int32_t v = rows[i * kD + static_cast<std::size_t>(k)];
        sum += v * v;
      }
      squared_norm[i] = sum;
    }
  }
};

}  // namespace

std::vector<FeatureMatch> matchFeatures(const FeatureSet& a, const FeatureSet& b,
                                        const MatchOptions& options) {
  std::vector<FeatureMatch> matches;
  if (a.size() < 2 || b.size() < 2) return matches;
  constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
  const Widened wa(a), wb(b);
  const int nb = static_cast<int>(b.size());
  std::vector<std::int32_t> dots(b.size());
  std::vector<std::int32_t> column_best(b.size(), kFar);
  std::vector<int> column_arg(b.size(), -1);
  std::vector<int> row_arg(a.size(), -1);
  const double ratio2 = options.ratio * options.ratio;
  for (std::size_t i = 0; i < a.size(); ++i) {
    dotRows(wa.rows.data() + i * kD, wb.rows.data(), nb, dots.data());
    std::int32_t best = kFar, second = kFar;
    int arg = -1;
    for (int j = 0; j < nb; ++j) {
      const auto js = static_cast<std::size_t>(j);
      const std::int32_t d = wa.squared_norm[i] + wb.squared_norm[js] - 2 * dots[js];
      if (d < best) {
        second = best;
        best = d;
        arg = j;
      } else if (d < second) {
        second = d;
      }
      if (d < column_best[js]) {
        column_best[js] = d;
        column_arg[js] = static_cast<int>(i);
      }
    }
    if (best < ratio2 * second) row_arg[i] = arg;
  }
  for (std::size_t i = 0; i < a.size(); ++i)
    if (row_arg[i] >= 0 && column_arg[static_cast<std::size_t>(row_arg[i])] == static_cast<int>(i))
      matches.push_back({static_cast<int>(i), row_arg[i]});
  return matches;
}

}  // namespace cf
