// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "describe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace cf::sift {
namespace {

constexpr float kTwoPi = 6.28318530718f;

/// kAcross x kAcross samples around a keypoint, and one more on each side for their gradients.
template <int kAcross>
struct Patch {
  static constexpr int kSide = kAcross + 2;
  static constexpr int kGradients = kAcross * kAcross;
  float grey[kSide * kSide];
  float magnitude[kGradients];
  float angle[kGradients];  ///< [turns], 0 to 1
};

/// Column and row of every sample of a square patch, from its centre.
template <int kSide>
struct Lattice {
  float u[kSide * kSide], v[kSide * kSide];

  Lattice() {
    for (int i = 0; i < kSide * kSide; ++i) {
      u[i] = static_cast<float>(i % kSide) - 0.5f * (kSide - 1);
      v[i] = static_cast<float>(i / kSide) - 0.5f * (kSide - 1);
    }
  }
};

struct Axes {
  float x, y;            ///< of the centre [px]
  float step_x, step_y;  ///< one sample along the patch's own x [px]
};

constexpr int kMostSamples = 1024;

/// Bilinear samples at u, v; the border is repeated.
CF_CLONES void sample(const Plane& plane, const Axes& axes, const float* u, const float* v,
                      int count, float* out) {
  const float right = static_cast<float>(plane.width()) - 1.001f;
  const float bottom = static_cast<float>(plane.height()) - 1.001f;
  const int stride = plane.stride();
  const float* data = plane.data();
  int offset[kMostSamples];
  float fraction_x[kMostSamples], fraction_y[kMostSamples];
  for (int i = 0; i < count; ++i) {
    float x = axes.x + u[i] * axes.step_x - v[i] * axes.step_y;
    float y = axes.y + u[i] * axes.step_y + v[i] * axes.step_x;
    x = x < 0 ? 0 : x;
    x = x > right ? right : x;
    y = y < 0 ? 0 : y;
    y = y > bottom ? bottom : y;
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    fraction_x[i] = x - static_cast<float>(ix);
    fraction_y[i] = y - static_cast<float>(iy);
    offset[i] = iy * stride + ix;
  }
  // Two neighbours at a time, which is faster than gathering the four.
  float above[2 * kMostSamples], below[2 * kMostSamples];
  for (int i = 0; i < count; ++i) {
    std::memcpy(above + 2 * i, data + offset[i], 2 * sizeof(float));
    std::memcpy(below + 2 * i, data + offset[i] + stride, 2 * sizeof(float));
  }
  for (int i = 0; i < count; ++i) {
    const float a = above[2 * i] + fraction_x[i] * (above[2 * i + 1] - above[2 * i]);
    const float b = below[2 * i] + fraction_x[i] * (below[2 * i + 1] - below[2 * i]);
    out[i] = a + fraction_y[i] * (b - a);
  }
}

/// Direction of a vector, 0 to 1 turn: the arc tangent, interpolated at six Chebyshev nodes over
/// the first octant (within 5e-7 turns).
CF_INLINE float turnsOf(float dx, float dy) {
  const float ax = dx < 0 ? -dx : dx, ay = dy < 0 ? -dy : dy;
  const float small = ax < ay ? ax : ay, large = ax < ay ? ay : ax;
  const float t = small / (large + 1e-20f), t2 = t * t;
  float a =
      t * (0.15915412f +
           t2 * (-0.05299177f +
                 t2 * (0.03109038f + t2 * (-0.01916999f + t2 * (0.00900658f - t2 * 0.00208977f)))));
  a = ax < ay ? 0.25f - a : a;
  a = dx < 0 ? 0.5f - a : a;
  a = dy < 0 ? 1.0f - a : a;
  return a < 1.0f ? a : 0.0f;
}

/// Central differences of the samples within the margin.
CF_CLONES void gradients(const float* grey, int across, float* magnitude, float* angle) {
  const int side = across + 2;
  for (int r = 0; r < across; ++r) {
    const float* above = grey + r * side + 1;
    const float* here = above + side;
    const float* below = here + side;
    for (int c = 0; c < across; ++c) {
      const float dx = here[c + 1] - here[c - 1], dy = below[c] - above[c];
      magnitude[r * across + c] = std::sqrt(dx * dx + dy * dy);
      angle[r * across + c] = turnsOf(dx, dy);
    }
  }
}

template <int kAcross>
void fill(const Plane& level, const Axes& axes, Patch<kAcross>& patch) {
  constexpr int kSide = Patch<kAcross>::kSide;
  static_assert(kSide * kSide <= kMostSamples);
  static const Lattice<kSide> lattice;
  sample(level, axes, lattice.u, lattice.v, kSide * kSide, patch.grey);
  gradients(patch.grey, kAcross, patch.magnitude, patch.angle);
}

constexpr int kOrientationAcross = 19;
constexpr float kOrientationStep = 0.5f;  ///< [sigma]: the window reaches 4.5 sigma
constexpr int kDirections = 36;

constexpr int kCells = 4, kBins = 8;
constexpr int kPerCell = 4;                       ///< samples across a cell
constexpr int kAcross = (kCells + 1) * kPerCell;  ///< half a cell more on each side
constexpr float kCellSigmas = 3.0f;               ///< width of a cell [sigma]
constexpr float kDescriptorStep = kCellSigmas / kPerCell;

std::array<float, kOrientationAcross * kOrientationAcross> orientationWeights() {
  std::array<float, kOrientationAcross * kOrientationAcross> out{};
  constexpr int kHalf = kOrientationAcross / 2;
  for (int r = -kHalf; r <= kHalf; ++r)
    for (int c = -kHalf; c <= kHalf; ++c) {
      const double d2 = (r * r + c * c) * kOrientationStep * kOrientationStep;
      out[static_cast<std::size_t>((r + kHalf) * kOrientationAcross + c + kHalf)] =
          static_cast<float>(std::exp(-d2 / (2 * 1.5 * 1.5)));
    }
  return out;
}

/// Weight of a row (or column) of samples in a row (or column) of cells: linear between the
/// centres of cells, under a Gaussian of half the descriptor's width.
std::array<std::array<float, kAcross>, kCells> cellWeights() {
  std::array<std::array<float, kAcross>, kCells> out{};
  for (std::size_t cell = 0; cell < kCells; ++cell)
    for (std::size_t i = 0; i < kAcross; ++i) {
      const double at = (static_cast<double>(i) - 0.5 * (kAcross - 1)) / kPerCell;  // [cells]
      const double centre = static_cast<double>(cell) - 0.5 * (kCells - 1);
      const double sigma = 0.5 * kCells;
      out[cell][i] = static_cast<float>(std::max(0.0, 1 - std::abs(at - centre)) *
                                        std::exp(-at * at / (2 * sigma * sigma)));
    }
  return out;
}

/// Each magnitude is shared between the two nearest of kBins directions.
CF_CLONES void spreadOverBins(const float* magnitude, const float* angle, int count, float* out) {
  for (int i = 0; i < count; ++i) {
    const float o = angle[i] * kBins;
    for (int b = 0; b < kBins; ++b) {
      float d = o - static_cast<float>(b);
      d = d < 0 ? -d : d;
      d = d > 4.0f ? 8.0f - d : d;
      out[i * kBins + b] = d < 1.0f ? magnitude[i] * (1.0f - d) : 0.0f;
    }
  }
}

/// to += weight * from
CF_INLINE void addScaled(const float* from, float weight, int count, float* to) {
  for (int i = 0; i < count; ++i) to[i] += weight * from[i];
}

/// Sums the samples' bins over the cells: first over rows, then over columns.
CF_CLONES void poolOverCells(const float* bins, const std::array<float, kAcross>* weight,
                             float* histogram) {
  constexpr int kRow = kAcross * kBins;
  for (int cy = 0; cy < kCells; ++cy) {
    float sum[kRow] = {};
    for (int r = cy * kPerCell; r < (cy + 2) * kPerCell; ++r)
      addScaled(bins + r * kRow, weight[cy][static_cast<std::size_t>(r)], kRow, sum);
    for (int cx = 0; cx < kCells; ++cx) {
      float* cell = histogram + (cy * kCells + cx) * kBins;
      for (int b = 0; b < kBins; ++b) cell[b] = 0;
      for (int c = cx * kPerCell; c < (cx + 2) * kPerCell; ++c)
        addScaled(sum + c * kBins, weight[cx][static_cast<std::size_t>(c)], kBins, cell);
    }
  }
}

}  // namespace

std::vector<float> orientations(const Plane& level, const Keypoint& keypoint) {
  static const auto weight = orientationWeights();
  const auto step = static_cast<float>(sigmaOfLevel(keypoint.level)) * kOrientationStep;
  Patch<kOrientationAcross> patch;
  fill(level, {keypoint.x, keypoint.y, step, 0}, patch);
  std::array<float, kDirections> raw{};
  for (std::size_t i = 0; i < weight.size(); ++i) {
    const auto bin = static_cast<std::size_t>(patch.angle[i] * kDirections + 0.5f) % kDirections;
    raw[bin] += weight[i] * patch.magnitude[i];
  }
  const auto around = [](const std::array<float, kDirections>& h, std::size_t i, int d) {
    return h[(i + static_cast<std::size_t>(kDirections + d)) % kDirections];
  };
  std::array<float, kDirections> smooth{};
  for (std::size_t i = 0; i < kDirections; ++i)
    smooth[i] = (around(raw, i, -2) + around(raw, i, 2)) / 16 +
                (around(raw, i, -1) + around(raw, i, 1)) / 4 + raw[i] * 3 / 8;
  const float strong = 0.8f * *std::max_element(smooth.begin(), smooth.end());
  std::vector<float> out;
  for (std::size_t i = 0; i < kDirections; ++i) {
    const float left = around(smooth, i, -1), here = smooth[i], right = around(smooth, i, 1);
    if (here <= left || here <= right || here < strong) continue;
    const float peak = static_cast<float>(i) + (left - right) / (2 * (left - 2 * here + right));
    out.push_back(peak * kTwoPi / kDirections);
  }
  return out;
}

void describe(const Plane& level, const Keypoint& keypoint, float orientation, std::uint8_t* out) {
  static const auto weight = cellWeights();
  const auto step = static_cast<float>(sigmaOfLevel(keypoint.level)) * kDescriptorStep;
  Patch<kAcross> patch;
  fill(level, {keypoint.x, keypoint.y, step * std::cos(orientation), step * std::sin(orientation)},
       patch);
  float bins[kAcross * kAcross * kBins];
  spreadOverBins(patch.magnitude, patch.angle, kAcross * kAcross, bins);
  std::array<float, kCells * kCells * kBins> histogram;
  poolOverCells(bins, weight.data(), histogram.data());

  // Large gradients (glare, shadows' edges) count no more than 0.2 of the whole.
  float squares = 0;
  for (const float h : histogram) squares += h * h;
  const float most = 0.2f * std::sqrt(squares);
  float sum = 0;
  for (float& h : histogram) sum += h = std::min(h, most);
  sum = std::max(sum, 1e-12f);
  for (std::size_t i = 0; i < histogram.size(); ++i)
    out[i] =
        static_cast<std::uint8_t>(std::min(255.0f, 512.0f * std::sqrt(histogram[i] / sum) + 0.5f));
}

}  // namespace cf::sift
