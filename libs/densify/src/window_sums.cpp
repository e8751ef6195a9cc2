// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "window_sums.h"

namespace cf {

CF_CLONES void WindowSums::exchange(const std::int32_t* coming, const std::int32_t* leaving,
                                    std::int32_t* columns, int n) {
  for (int u = 0; u < n; ++u) columns[u] += coming[u] - leaving[u];
}

CF_CLONES void WindowSums::sum(const std::int32_t* columns, int width, std::int32_t* out) {
  static_assert(kSide == 7);
  for (int u = 0; u < width; ++u) {
    const std::int32_t* c = columns + u;
    out[u] = c[0] + c[1] + c[2] + c[3] + c[4] + c[5] + c[6];
  }
}

}  // namespace cf
