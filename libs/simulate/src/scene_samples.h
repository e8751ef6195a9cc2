// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cf {

/// Many rays, what they hit and how bright it is, structure of arrays. Scene coordinates [m].
struct Samples {
  explicit Samples(int capacity) { resize(capacity); }

  void resize(int size) {
    n = size;
    for (auto* v : {&ox, &oy, &oz, &dx, &dy, &dz, &t, &x, &y, &z, &nx, &ny, &nz, &footprint, &sun,
                    &blue, &green, &red}) {
      v->resize(static_cast<std::size_t>(size));
    }
    object.resize(static_cast<std::size_t>(size));
  }

  int n = 0;
  std::vector<float> ox, oy, oz, dx, dy, dz;  ///< rays; their length is the caller's
  std::vector<float> t;                       ///< first hit, in units of d; < 0: nothing
  std::vector<float> x, y, z, nx, ny, nz;     ///< of the hit; the normal looks back along the ray
  std::vector<std::uint32_t> object;
  std::vector<float> footprint;         ///< [m]
  std::vector<float> sun;               ///< cosine of the sunlight's angle; 0 in the shade
  std::vector<float> blue, green, red;  ///< linear
};

}  // namespace cf
