// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scale_space.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace cf::sift {
namespace {

constexpr double kSigma = 1.6;  ///< blur of level 0 (Lowe 2004, section 3.3)

constexpr int kLanes = 16;
constexpr int kVectors = Plane::kBlock / kLanes;
using Lanes = float __attribute__((vector_size(4 * kLanes)));

/// out = weight[0] * row[0] + sum of weight[i] * (row[-i] + row[i]), over whole blocks.
CF_CLONES void symmetricSum(const float* const* row, const float* weight, int radius, int blocks,
                            float* out) {
  for (int block = 0; block < blocks; ++block) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(block) * Plane::kBlock;
    Lanes sum[kVectors];
    for (int v = 0; v < kVectors; ++v) {
      Lanes centre;
      std::memcpy(&centre, row[0] + at + v * kLanes, sizeof centre);
      sum[v] = weight[0] * centre;
    }
    for (int i = 1; i <= radius; ++i) {
      const float* before = row[-i] + at;
      const float* after = row[i] + at;
      for (int v = 0; v < kVectors; ++v) {
        Lanes a, b;
        std::memcpy(&a, before + v * kLanes, sizeof a);
        std::memcpy(&b, after + v * kLanes, sizeof b);
        sum[v] += weight[i] * (a + b);
      }
    }
    std::memcpy(out + at, sum, sizeof sum);
  }
}

int mirrored(int i, int size) {
  if (size == 1) return 0;
  while (i < 0 || i >= size) i = i < 0 ? -i : 2 * (size - 1) - i;
  return i;
}

/// One side of a Gaussian, centre first, to three sigmas.
std::vector<float> gaussian(double sigma) {
  const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  std::vector<double> half;
  double sum = 0;
  for (int i = 0; i <= radius; ++i) {
    half.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    sum += (i == 0 ? 1 : 2) * half.back();
  }
  std::vector<float> out;
  for (const double w : half) out.push_back(static_cast<float>(w / sum));
  return out;
}

Plane halved(const Plane& in) {
  Plane out((in.width() + 1) / 2, (in.height() + 1) / 2);
  for (int y = 0; y < out.height(); ++y) {
    const float* from = in.row(2 * y);
    float* to = out.row(y);
    for (int x = 0; x < out.width(); ++x) to[x] = from[2 * x];
  }
  return out;
}

Octave octaveFrom(Plane level0) {
  Octave octave;
  octave[0] = std::move(level0);
  for (std::size_t i = 1; i < kLevels; ++i) {
    const double from = sigmaOfLevel(static_cast<double>(i - 1));
    const double to = sigmaOfLevel(static_cast<double>(i));
    octave[i] = blurred(octave[i - 1], std::sqrt(to * to - from * from));
  }
  return octave;
}

}  // namespace

double sigmaOfLevel(double level) { return kSigma * std::exp2(level / kScales); }

Plane blurred(const Plane& in, double sigma) {
  const std::vector<float> weight = gaussian(sigma);
  const int radius = static_cast<int>(weight.size()) - 1;
  const int blocks = in.stride() / Plane::kBlock;
  Plane out(in.width(), in.height());
  // Each row is summed over its neighbours above and below, then over its own pixels.
  std::vector<float> padded(static_cast<std::size_t>(in.stride() + 2 * radius));
  float* middle = padded.data() + radius;
  std::vector<const float*> rows(static_cast<std::size_t>(2 * radius + 1));
  std::vector<const float*> shifted;
  for (int i = -radius; i <= radius; ++i) shifted.push_back(middle + i);
  for (int y = 0; y < in.height(); ++y) {
    for (int i = -radius; i <= radius; ++i)
      rows[static_cast<std::size_t>(i + radius)] = in.row(mirrored(y + i, in.height()));
    symmetricSum(rows.data() + radius, weight.data(), radius, blocks, middle);
    for (int i = 1; i <= radius; ++i) {
      middle[-i] = middle[mirrored(-i, in.width())];
      middle[in.width() - 1 + i] = middle[mirrored(in.width() - 1 + i, in.width())];
    }
    symmetricSum(shifted.data() + radius, weight.data(), radius, blocks, out.row(y));
  }
  return out;
}

Octave firstOctave(const Plane& image, double image_sigma) {
  const double missing = kSigma * kSigma - image_sigma * image_sigma;
  return octaveFrom(missing > 0.01 ? blurred(image, std::sqrt(missing)) : image);
}

Octave nextOctave(const Octave& octave) { return octaveFrom(halved(octave[kScales])); }

}  // namespace cf::sift
