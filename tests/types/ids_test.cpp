// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/types/ids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "cf/types/tile.h"

namespace cf {
namespace {

/// `<` must order `sorted` strictly: every pair agrees with the pair's places.
template <class T>
void expectStrictOrder(const std::vector<T>& sorted) {
  for (std::size_t i = 0; i < sorted.size(); ++i)
    for (std::size_t j = 0; j < sorted.size(); ++j) {
      EXPECT_EQ(sorted[i] < sorted[j], i < j) << i << " " << j;
      EXPECT_EQ(sorted[i] == sorted[j], i == j) << i << " " << j;
    }
}

TEST(Ids, orderByUavFirst) {
  expectStrictOrder<FrameId>({{0, 0}, {0, 1}, {0, 70000}, {1, 0}, {1, 2}});
  expectStrictOrder<SegmentId>({{0, 0}, {0, 1}, {1, 0}, {2, 0}});
  EXPECT_TRUE((FrameId{0, 1} != FrameId{1, 1}));
  EXPECT_FALSE((FrameId{1, 1} != FrameId{1, 1}));
}

TEST(TileIndex, ordersNegativeTilesToo) {
  expectStrictOrder<TileIndex>({{-2, 5}, {-1, -1}, {-1, 0}, {0, -1}, {0, 0}, {3, 0}});
}

}  // namespace
}  // namespace cf
