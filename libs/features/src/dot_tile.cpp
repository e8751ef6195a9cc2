// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dot_tile.h"

#include <cstring>
#include <numeric>

#include "cf/base/instruction_sets.h"
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace cf {
namespace {

constexpr int kD = FeatureSet::kDescriptorSize;
constexpr int kPack = 16;  ///< descriptors whose products fill one register
constexpr int kQuads = kD / 4;

#if defined(__x86_64__)
bool hasByteProducts() { return __builtin_cpu_supports("avx512vnni") != 0; }

/// Byte products, AVX-512 VNNI: 8 x 32 sums stay in 16 registers.
__attribute__((target("avx512f,avx512vnni"))) void byteProducts(const std::int8_t* a,
                                                                const std::uint8_t* b,
                                                                const std::int32_t* shift,
                                                                std::int32_t* out) {
  __m512i left[kTileRows], right[kTileRows];
  for (int r = 0; r < kTileRows; ++r) {
    left[r] = _mm512_loadu_si512(shift);
    right[r] = _mm512_loadu_si512(shift + kPack);
  }
  for (int k = 0; k < kQuads; ++k) {
    const __m512i b_left = _mm512_loadu_si512(b + k * 4 * kPack);
    const __m512i b_right = _mm512_loadu_si512(b + (kQuads + k) * 4 * kPack);
    for (int r = 0; r < kTileRows; ++r) {
      std::int32_t quad;
      std::memcpy(&quad, a + r * kD + 4 * k, sizeof quad);
      const __m512i a_quad = _mm512_set1_epi32(quad);
      left[r] = _mm512_dpbusd_epi32(left[r], b_left, a_quad);
      right[r] = _mm512_dpbusd_epi32(right[r], b_right, a_quad);
    }
  }
  for (int r = 0; r < kTileRows; ++r) {
    _mm512_storeu_si512(out + r * kTileColumns, left[r]);
    _mm512_storeu_si512(out + r * kTileColumns + kPack, right[r]);
  }
}

#else
bool hasByteProducts() { return false; }

void byteProducts(const std::int8_t*, const std::uint8_t*, const std::int32_t*, std::int32_t*) {}
#endif

CF_CLONES void wideProducts(const std::int16_t* a, const std::int16_t* b, std::int32_t* out) {
  for (int j = 0; j < kTileColumns; ++j)
    for (int r = 0; r < kTileRows; ++r) {
      std::int32_t sum = 0;
      for (int k = 0; k < kD; ++k) sum += static_cast<std::int32_t>(a[r * kD + k]) * b[j * kD + k];
      out[r * kTileColumns + j] = sum;
    }
}

int tilesOf(std::size_t count, int size) { return (static_cast<int>(count) + size - 1) / size; }

}  // namespace

DotTiles::DotTiles(const FeatureSet& a, const FeatureSet& b)
    : tile_rows_(tilesOf(a.size(), kTileRows)),
      tile_columns_(tilesOf(b.size(), kTileColumns)),
      has_byte_products_(hasByteProducts()) {
  const auto rows = static_cast<std::size_t>(tile_rows_ * kTileRows);
  const auto columns = static_cast<std::size_t>(tile_columns_ * kTileColumns);
  if (!has_byte_products_) {
    wide_a_.assign(a.descriptor.begin(), a.descriptor.end());
    wide_a_.resize(rows * kD);
    wide_b_.assign(b.descriptor.begin(), b.descriptor.end());
    wide_b_.resize(columns * kD);
    return;
  }
  // One factor of the instruction is signed: sum(b a) = sum(b (a - 128)) + 128 sum(b).
  shifted_a_.resize(rows * kD);
  for (std::size_t i = 0; i < a.descriptor.size(); ++i)
    shifted_a_[i] = static_cast<std::int8_t>(a.descriptor[i] - 128);
  packed_b_.resize(columns * kD);
  shift_.resize(columns);
  for (std::size_t j = 0; j < b.size(); ++j) {
    shift_[j] = 128 * std::accumulate(b.row(j), b.row(j) + kD, std::int32_t{0});
    std::uint8_t* to = packed_b_.data() + j / kPack * kPack * kD + j % kPack * 4;
    for (int k = 0; k < kQuads; ++k) std::memcpy(to + k * 4 * kPack, b.row(j) + 4 * k, 4);
  }
}

void DotTiles::compute(int i, int j, std::int32_t* out) const {
  const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(i) * kTileRows * kD;
  const std::ptrdiff_t column = static_cast<std::ptrdiff_t>(j) * kTileColumns * kD;
  if (has_byte_products_)
    byteProducts(shifted_a_.data() + row, packed_b_.data() + column,
                 shift_.data() + static_cast<std::ptrdiff_t>(j) * kTileColumns, out);
  else
    wideProducts(wide_a_.data() + row, wide_b_.data() + column, out);
}

}  // namespace cf
