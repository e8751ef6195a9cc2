// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

#include "cf/base/instruction_sets.h"

namespace cf {

using Cost = std::int16_t;

// Sixteen at a time, in the compiler's own vector notation.
inline constexpr int kLanes = 16;
using Lanes = Cost __attribute__((vector_size(2 * kLanes)));
using ByteLanes = std::uint8_t __attribute__((vector_size(kLanes)));

template <class V>
CF_INLINE V load(const void* from) {
  V value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class V>
CF_INLINE V lesser(V a, V b) {
  return a < b ? a : b;
}

#if defined(__clang__)
#define CF_SHUFFLE(v, ...) __builtin_shufflevector(v, v, __VA_ARGS__)
#define CF_SHUFFLE2(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define CF_SHUFFLE(v, ...) __builtin_shuffle(v, decltype(v){__VA_ARGS__})
#define CF_SHUFFLE2(a, b, ...) __builtin_shuffle(a, b, decltype(a){__VA_ARGS__})
#endif

/// The least of all lanes, in each of them.
CF_INLINE ByteLanes leastEverywhere(ByteLanes v) {
  v = lesser(v, CF_SHUFFLE(v, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7));
  v = lesser(v, CF_SHUFFLE(v, 4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11));
  v = lesser(v, CF_SHUFFLE(v, 2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13));
  return lesser(v, CF_SHUFFLE(v, 1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14));
}

/// Each lane's lower neighbour; the first gets the last lane of `before`.
CF_INLINE ByteLanes fromBelow(ByteLanes before, ByteLanes v) {
  return CF_SHUFFLE2(before, v, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30);
}
/// Each lane's upper neighbour; the last gets the first lane of `after`.
CF_INLINE ByteLanes fromAbove(ByteLanes v, ByteLanes after) {
  return CF_SHUFFLE2(v, after, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
}

}  // namespace cf
