// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/patch_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

constexpr int kRadius = 8;  ///< of a patch [px]
constexpr int kSide = 2 * kRadius + 1, kArea = kSide * kSide;
constexpr int kRim = kSide + 2;  ///< side with one more pixel around, for gradients
constexpr int kMaxIterations = 12;
constexpr double kConverged = 0.003;  ///< last step [px]
constexpr double kLeastCorrelation = 0.8;
constexpr double kLargestSigma = 0.15;  ///< [px]

/// Affine warp in, gain and offset of the grey values out.
constexpr int kParameters = 8;
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Normal = Eigen::Matrix<double, kParameters, kParameters>;

/// Weight of each pixel: what is far from the middle matters less, it may lie at another depth.
const std::array<float, kArea>& window() {
  static const std::array<float, kArea> weights = [] {
    std::array<float, kArea> w;
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

/// Grey values of `side` x `side` pixels around `middle`, warped by A; false beyond the border.
bool sample(const cv::Mat& grey, const Eigen::Vector2d& middle, const Eigen::Matrix2d& A, int side,
            float* out) {
  const double r = side / 2;
  for (const double sx : {-r, r})
    for (const double sy : {-r, r}) {
      const Eigen::Vector2d corner = middle + A * Eigen::Vector2d(sx, sy);
      if (!(corner.x() >= 0 && corner.y() >= 0 && corner.x() < grey.cols - 1 &&
            corner.y() < grey.rows - 1))
        return false;
    }
  const auto dx = static_cast<float>(A(0, 0)), dy = static_cast<float>(A(1, 0));
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

Moments momentsOf(const std::array<float, kArea>& values) {
  const auto& w = window();
  float mean = 0, square = 0;
  for (std::size_t i = 0; i < kArea; ++i) mean += w[i] * values[i];
  for (std::size_t i = 0; i < kArea; ++i) square += w[i] * (values[i] - mean) * (values[i] - mean);
  return {static_cast<double>(mean), std::sqrt(static_cast<double>(square))};
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
        derivatives[0][i] = gx;
        derivatives[1][i] = gy;
        derivatives[2][i] = gx * dx;
        derivatives[3][i] = gx * dy;
        derivatives[4][i] = gy * dx;
        derivatives[5][i] = gy * dy;
        derivatives[7][i] = 1;
      }
    moments = momentsOf(values);
    if (moments.deviation < 2) return false;  // grey values: nothing but noise
    for (i = 0; i < kArea; ++i) derivatives[6][i] = values[i] - static_cast<float>(moments.mean);
    const auto& w = window();
    for (std::size_t a = 0; a < kParameters; ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        float sum = 0;
        for (i = 0; i < kArea; ++i) sum += w[i] * derivatives[a][i] * derivatives[b][i];
        normal(static_cast<int>(a), static_cast<int>(b)) =
            normal(static_cast<int>(b), static_cast<int>(a)) = static_cast<double>(sum);
      }
    factors.compute(normal);
    return factors.info() == Eigen::Success;
  }

  /// Step of the parameters that explains the grey values best, and the weighted sum of squares.
  Parameters step(const std::array<float, kArea>& difference) const {
    const auto& w = window();
    Parameters right;
    for (std::size_t a = 0; a < kParameters; ++a) {
      float sum = 0;
      for (std::size_t i = 0; i < kArea; ++i) sum += w[i] * derivatives[a][i] * difference[i];
      right[static_cast<int>(a)] = static_cast<double>(sum);
    }
    return factors.solve(right);
  }

  std::array<float, kArea> values;
  Moments moments;
  Eigen::LLT<Normal> factors;

 private:
  std::array<std::array<float, kArea>, kParameters> derivatives;
  Normal normal;
};

}  // namespace

cv::Mat greyForAlignment(const cv::Mat& bgr, double megapixels) {
  cv::Mat grey, reduced, smooth;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
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
  std::array<float, kArea> seen, difference;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (!sample(target, middle, A, kSide, seen.data())) return std::nullopt;
    const Moments m = momentsOf(seen);
    if (m.deviation < 1) return std::nullopt;
    const auto gain = static_cast<float>(patch.moments.deviation / m.deviation);
    const auto mean = static_cast<float>(m.mean), level = static_cast<float>(patch.moments.mean);
    float squares = 0;
    const auto& w = window();
    for (std::size_t i = 0; i < kArea; ++i) {
      difference[i] = (seen[i] - mean) * gain + level - patch.values[i];
      squares += w[i] * difference[i] * difference[i];
    }
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
