// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/patch_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "cf/base/instruction_sets.h"

namespace cf {
namespace {

constexpr int kRadius = 8;  ///< of a patch [px]
constexpr int kSide = 2 * kRadius + 1, kArea = kSide * kSide;
constexpr int kLanes = 16, kPadded = (kArea + kLanes - 1) / kLanes * kLanes;
constexpr int kRim = kSide + 2;  ///< side with one more pixel around, for gradients
constexpr int kMaxIterations = 12;
constexpr double kConverged = 0.003;  ///< last step [px]
constexpr double kLeastCorrelation = 0.8;
constexpr double kLargestSigma = 0.15;  ///< [px]

/// Affine warp in, gain and offset of the grey values out.
constexpr int kParameters = 8;
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Normal = Eigen::Matrix<double, kParameters, kParameters>;

/// A number for each pixel of a patch, row by row, and nothing of use beyond them.
using Pixels = std::array<float, kPadded>;
using Lanes = float __attribute__((vector_size(sizeof(float) * kLanes)));

CF_INLINE Lanes load(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

/// Always in the same order.
CF_INLINE float sumOf(const Lanes& lanes) {
  float sums[kLanes];
  std::memcpy(sums, &lanes, sizeof sums);
  for (int half = kLanes / 2; half > 0; half /= 2)
    for (int i = 0; i < half; ++i) sums[i] += sums[i + half];
  return sums[0];
}

/// Weight of each pixel: what is far from the middle matters less, it may lie at another depth.
/// Zero beyond the patch.
const Pixels& window() {
  static const Pixels weights = [] {
    Pixels w{};
    double sum = 0;
    for (int y = -kRadius; y <= kRadius; ++y)
      for (int x = -kRadius; x <= kRadius; ++x)
        sum += std::exp(-(x * x + y * y) / (0.5 * kRadius * kRadius));
    for (int y = -kRadius, i = 0; y <= kRadius; ++y)
      for (int x = -kRadius; x <= kRadius; ++x, ++i)
        w[static_cast<std::size_t>(i)] =
            static_cast<float>(std::exp(-(x * x + y * y) / (0.5 * kRadius * kRadius)) / sum);
    return w;
  }();
  return weights;
}

/// Weighted mean and variance.
CF_CLONES void meanAndVariance(const float* weights, const float* values, float* out) {
  Lanes sum{}, squares{};
  for (int i = 0; i < kPadded; i += kLanes) sum += load(weights + i) * load(values + i);
  const float mean = sumOf(sum);
  for (int i = 0; i < kPadded; i += kLanes) {
    const Lanes apart = load(values + i) - mean;
    squares += load(weights + i) * apart * apart;
  }
  out[0] = mean;
  out[1] = sumOf(squares);
}

/// Sums of the products of `count` patches, one after the other, with another.
CF_CLONES void sumsOfProducts(const float* patches, int count, const float* other, float* out) {
  for (int k = 0; k < count; ++k, patches += kPadded) {
    Lanes sum{};
    for (int i = 0; i < kPadded; i += kLanes) sum += load(patches + i) * load(other + i);
    out[k] = sumOf(sum);
  }
}

/// (seen - mean) * gain + level - wanted, and the weighted sum of its squares.
CF_CLONES float differ(const float* weights, const float* seen, const float* wanted, float mean,
                       float gain, float level, float* difference) {
  Lanes squares{};
  for (int i = 0; i < kPadded; i += kLanes) {
    const Lanes d = (load(seen + i) - mean) * gain + level - load(wanted + i);
    squares += load(weights + i) * d * d;
    std::memcpy(difference + i, &d, sizeof d);
  }
  return sumOf(squares);
}

/// Grey values of `side` x `side` pixels around `middle`, warped by A; false beyond the border.
bool sample(const cv::Mat& grey, const Eigen::Vector2d& middle, const Eigen::Matrix2d& A, int side,
            float* out) {
  const double r = side / 2;
  const auto dx = static_cast<float>(A(0, 0)), dy = static_cast<float>(A(1, 0));
  // The corners in the floats of the loop below: rounding must not lead it beyond the last pixel.
  for (const int row : {0, side - 1}) {
    const Eigen::Vector2d begin = middle + A * Eigen::Vector2d(-r, row - r);
    for (const int column : {0, side - 1}) {
      const float x = static_cast<float>(begin.x()) + dx * static_cast<float>(column);
      const float y = static_cast<float>(begin.y()) + dy * static_cast<float>(column);
      if (!(x >= 0 && y >= 0 && x < static_cast<float>(grey.cols - 1) &&
            y < static_cast<float>(grey.rows - 1)))
        return false;
    }
  }
  const auto step = static_cast<std::ptrdiff_t>(grey.step);
  for (int row = 0; row < side; ++row) {
    const Eigen::Vector2d begin = middle + A * Eigen::Vector2d(-r, row - r);
    const auto x0 = static_cast<float>(begin.x()), y0 = static_cast<float>(begin.y());
    for (int column = 0; column < side; ++column) {
      const float x = x0 + dx * static_cast<float>(column);
      const float y = y0 + dy * static_cast<float>(column);
      const int ix = static_cast<int>(x), iy = static_cast<int>(y);
      const float u = x - static_cast<float>(ix), v = y - static_cast<float>(iy);
      const std::uint8_t* p = grey.data + iy * step + ix;
      const float top = static_cast<float>(p[0]) + u * static_cast<float>(p[1] - p[0]);
      const float bottom =
          static_cast<float>(p[step]) + u * static_cast<float>(p[step + 1] - p[step]);
      *out++ = top + v * (bottom - top);
    }
  }
  return true;
}

struct Moments {
  double mean = 0, deviation = 0;
};

Moments momentsOf(const Pixels& values) {
  float moments[2];
  meanAndVariance(window().data(), values.data(), moments);
  return {static_cast<double>(moments[0]), std::sqrt(static_cast<double>(moments[1]))};
}

/// The reference patch, its derivatives by the parameters, and their normal equations.
class Template {
 public:
  bool take(const cv::Mat& reference, const Eigen::Vector2d& at) {
    std::array<float, kRim * kRim> rim;
    if (!sample(reference, at, Eigen::Matrix2d::Identity(), kRim, rim.data())) return false;
    const auto grey = [&](int x, int y) { return rim[static_cast<std::size_t>(y * kRim + x)]; };
    std::size_t i = 0;
    for (int y = 1; y <= kSide; ++y)
      for (int x = 1; x <= kSide; ++x, ++i) {
        values[i] = grey(x, y);
        const float gx = (grey(x + 1, y) - grey(x - 1, y)) / 2;
        const float gy = (grey(x, y + 1) - grey(x, y - 1)) / 2;
        const auto dx = static_cast<float>(x - 1 - kRadius),
                   dy = static_cast<float>(y - 1 - kRadius);
        derivatives_[0][i] = gx;
        derivatives_[1][i] = gy;
        derivatives_[2][i] = gx * dx;
        derivatives_[3][i] = gx * dy;
        derivatives_[4][i] = gy * dx;
        derivatives_[5][i] = gy * dy;
        derivatives_[7][i] = 1;
      }
    moments = momentsOf(values);
    if (moments.deviation < 2) return false;  // grey values: nothing but noise
    for (i = 0; i < kArea; ++i) derivatives_[6][i] = values[i] - static_cast<float>(moments.mean);
    const auto& w = window();
    for (std::size_t a = 0; a < kParameters; ++a)
      for (i = 0; i < kPadded; ++i) weighted_[a][i] = w[i] * derivatives_[a][i];
    Normal normal;
    for (std::size_t a = 0; a < kParameters; ++a) {
      std::array<float, kParameters> sums;
      const int count = static_cast<int>(a) + 1;
      sumsOfProducts(weighted_[0].data(), count, derivatives_[a].data(), sums.data());
      for (int b = 0; b < count; ++b)
        normal(static_cast<int>(a), b) = normal(b, static_cast<int>(a)) =
            static_cast<double>(sums[static_cast<std::size_t>(b)]);
    }
    factors.compute(normal);
    return factors.info() == Eigen::Success;
  }

  /// Step of the parameters that explains the grey values best.
  Parameters step(const Pixels& difference) const {
    std::array<float, kParameters> right;
    sumsOfProducts(weighted_[0].data(), kParameters, difference.data(), right.data());
    return factors.solve(
        Eigen::Map<Eigen::Matrix<float, kParameters, 1>>(right.data()).cast<double>());
  }

  Pixels values{};
  Moments moments;
  Eigen::LLT<Normal> factors;

 private:
  std::array<Pixels, kParameters> derivatives_{}, weighted_;
};

}  // namespace

Eigen::Vector2d scaledPixel(const Eigen::Vector2d& pixel, double factor) {
  return (pixel + Eigen::Vector2d(0.5, 0.5)) * factor - Eigen::Vector2d(0.5, 0.5);
}

Eigen::Matrix2d patchWarp(const Eigen::Isometry3d& T_target_source,
                          const Eigen::Vector3d& p_source) {
  const Eigen::Vector3d p = T_target_source * p_source;
  const Eigen::Matrix<double, 3, 2> plane = T_target_source.linear().leftCols<2>();
  return p_source.z() / p.z() * (plane.topRows<2>() - p.head<2>() / p.z() * plane.row(2));
}

cv::Mat greyForAlignment(const cv::Mat& photo, double megapixels) {
  cv::Mat grey = photo, smooth;
  if (photo.channels() > 1) cv::cvtColor(photo, grey, cv::COLOR_BGR2GRAY);
  const double factor = std::sqrt(megapixels * 1e6 / static_cast<double>(grey.total()));
  if (factor < 1) cv::resize(grey, grey, cv::Size(), factor, factor, cv::INTER_AREA);
  cv::GaussianBlur(grey, smooth, cv::Size(5, 5), 0.8);
  return smooth;
}

std::optional<AlignedPatch> alignPatch(const cv::Mat& reference, const Eigen::Vector2d& at,
                                       const cv::Mat& target, const Eigen::Vector2d& start,
                                       const Eigen::Matrix2d& A_target_reference,
                                       double max_shift) {
  Template patch;
  if (!patch.take(reference, at)) return std::nullopt;
  Eigen::Vector2d middle = start;
  Eigen::Matrix2d A = A_target_reference;
  Pixels seen{}, difference;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (!sample(target, middle, A, kSide, seen.data())) return std::nullopt;
    const Moments m = momentsOf(seen);
    if (m.deviation < 1) return std::nullopt;
    const auto gain = static_cast<float>(patch.moments.deviation / m.deviation);
    const float squares =
        differ(window().data(), seen.data(), patch.values.data(), static_cast<float>(m.mean), gain,
               static_cast<float>(patch.moments.mean), difference.data());
    const Parameters d = patch.step(difference);
    Eigen::Matrix2d D;
    D << 1 + d[2], d[3], d[4], 1 + d[5];
    const Eigen::Matrix2d inverse = D.inverse();
    A = A * inverse;
    const Eigen::Vector2d move = A * d.head<2>();
    middle -= move;
    if (!((middle - start).norm() < max_shift) || !(std::abs(A.determinant()) > 0.1) ||
        A.determinant() > 10)
      return std::nullopt;
    if (move.norm() > kConverged) continue;
    // Both are brought to one deviation: the correlation follows from the squares left.
    const double variance = patch.moments.deviation * patch.moments.deviation;
    if (1 - static_cast<double>(squares) / (2 * variance) < kLeastCorrelation) return std::nullopt;
    Parameters ex = Parameters::Unit(0), ey = Parameters::Unit(1);
    const double shift2 = std::max(patch.factors.solve(ex)[0], patch.factors.solve(ey)[1]);
    // Weights sum to 1: as many observations as their squares tell (kRadius^2 pi).
    const double observations = M_PI * kRadius * kRadius;
    const double sigma = std::sqrt(shift2 * static_cast<double>(squares) / observations);
    if (sigma > kLargestSigma) return std::nullopt;
    return AlignedPatch{middle, sigma};
  }
  return std::nullopt;
}

}  // namespace cf
