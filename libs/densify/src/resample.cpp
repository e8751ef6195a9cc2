// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "resample.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace cf {
namespace {

constexpr int kBits = cv::INTER_BITS, kOne = cv::INTER_TAB_SIZE;
constexpr int kBlock = 64;  ///< px
constexpr int kHalf = kOne * kOne / 2, kShift = 2 * kBits;

/// One pixel anywhere, its four neighbours held within the image.
template <int kChannels>
void pixelAt(const cv::Mat& image, int x, int y, int tx, int ty, uchar* out) {
  const int x0 = std::clamp(x, 0, image.cols - 1), x1 = std::clamp(x + 1, 0, image.cols - 1);
  const uchar* above = image.ptr(std::clamp(y, 0, image.rows - 1));
  const uchar* below = image.ptr(std::clamp(y + 1, 0, image.rows - 1));
  for (int c = 0; c < kChannels; ++c) {
    const auto at = [&](const uchar* row, int column) { return int{row[kChannels * column + c]}; };
    const int top = at(above, x0) * (kOne - tx) + at(above, x1) * tx;
    const int bottom = at(below, x0) * (kOne - tx) + at(below, x1) * tx;
    out[c] = static_cast<uchar>((top * (kOne - ty) + bottom * ty + kHalf) >> kShift);
  }
}

#ifdef __SSE2__

/// For each fraction: as weights of the rows, eight times each; and of the columns in turn.
struct Weights {
  alignas(16) std::array<std::array<std::int16_t, 8>, kOne> above, below, columns;
  Weights() {
    for (std::size_t t = 0; t < kOne; ++t) {
      const auto after = static_cast<std::int16_t>(t);
      const auto before = static_cast<std::int16_t>(kOne - after);
      above[t].fill(before);
      below[t].fill(after);
      for (std::size_t i = 0; i < 8; ++i) columns[t][i] = i % 2 ? after : before;
    }
  }
};

__m128i eight(const std::array<std::int16_t, 8>& weights) {
  return _mm_load_si128(reinterpret_cast<const __m128i*>(weights.data()));
}

/// Three channels at `p`, into the first three bytes.
std::uint32_t colourAt(const uchar* p, std::size_t step, std::size_t tx, std::size_t ty,
                       const Weights& weights) {
  const __m128i zero = _mm_setzero_si128();
  const auto row = [&](const uchar* from) {
    return _mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from)), zero);
  };
  const __m128i both = _mm_add_epi16(_mm_mullo_epi16(row(p), eight(weights.above[ty])),
                                     _mm_mullo_epi16(row(p + step), eight(weights.below[ty])));
  const __m128i beside = _mm_unpacklo_epi16(both, _mm_srli_si128(both, 6));
  __m128i sum = _mm_madd_epi16(beside, eight(weights.columns[tx]));
  sum = _mm_srli_epi32(_mm_add_epi32(sum, _mm_set1_epi32(kHalf)), kShift);
  sum = _mm_packs_epi32(sum, sum);
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_packus_epi16(sum, sum)));
}

#endif

void colourRow(const cv::Mat& image, const RemapTable& table, int v, int first, int end,
               uchar* out) {
  const auto* xy = table.fixed_xy.ptr<short>(v);
  const auto* fraction = table.fraction.ptr<ushort>(v);
  const int width = table.fixed_xy.cols;
#ifdef __SSE2__
  static const Weights weights;
  const uchar* const data = image.data;
  const std::size_t step = image.step;
  // Eight bytes are read where six are wanted, and four written for three.
  const int last_x = image.cols - 4, last_y = image.rows - 2;
#else
  const int last_x = -1, last_y = -1;
#endif
  out += 3 * first;
  for (int u = first; u < end; ++u, out += 3) {
    const int x = xy[2 * u], y = xy[2 * u + 1];
    const int tx = fraction[u] & (kOne - 1), ty = fraction[u] >> kBits;
    if (x < 0 || y < 0 || x > last_x || y > last_y || u + 1 == width) {
      pixelAt<3>(image, x, y, tx, ty, out);
      continue;
    }
#ifdef __SSE2__
    const std::uint32_t colour =
        colourAt(data + static_cast<std::size_t>(y) * step + 3 * x, step,
                 static_cast<std::size_t>(tx), static_cast<std::size_t>(ty), weights);
    std::memcpy(out, &colour, sizeof colour);
#endif
  }
}

void greyRow(const cv::Mat& image, const RemapTable& table, int v, int first, int end, uchar* out) {
  const auto* xy = table.fixed_xy.ptr<short>(v);
  const auto* fraction = table.fraction.ptr<ushort>(v);
  const int last_x = image.cols - 2, last_y = image.rows - 2;
  const uchar* const data = image.data;
  const std::size_t step = image.step;
  for (int u = first; u < end; ++u) {
    const int x = xy[2 * u], y = xy[2 * u + 1];
    const int tx = fraction[u] & (kOne - 1), ty = fraction[u] >> kBits;
    if (x < 0 || y < 0 || x > last_x || y > last_y) {
      pixelAt<1>(image, x, y, tx, ty, out + u);
      continue;
    }
    const uchar *p = data + static_cast<std::size_t>(y) * step + x, *q = p + step;
    const int top = kOne * p[0] + tx * (p[1] - p[0]), bottom = kOne * q[0] + tx * (q[1] - q[0]);
    out[u] = static_cast<uchar>((kOne * top + ty * (bottom - top) + kHalf) >> kShift);
  }
}

}  // namespace

void resample(const cv::Mat& image, const RemapTable& table, cv::Mat out) {
  CV_Assert(image.type() == out.type() && out.size() == table.fixed_xy.size());
  CV_Assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  const auto row = image.channels() == 3 ? colourRow : greyRow;
  // By blocks: where the view is turned against the photo, a row runs down through all of it.
  for (int first = 0; first < out.cols; first += kBlock)
    for (int v = 0; v < out.rows; ++v)
      row(image, table, v, first, std::min(first + kBlock, out.cols), out.ptr(v));
}

}  // namespace cf
