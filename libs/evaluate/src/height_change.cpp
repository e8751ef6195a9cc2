// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "height_change.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "cf/base/error.h"
#include "statistics.h"

namespace cf {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kMostCells = 1e8;
constexpr std::size_t kMinCells = 1000;
constexpr std::size_t kBins = 10;
constexpr std::size_t kMinBlocks = 12;
constexpr double kMaxBlock_m = 16;
constexpr double kLeastFactor = 0.1;  ///< where surfaces are exact

struct Cell {
  int x = 0, y = 0;
};

std::optional<Cell> cellAt(const RunSurface& s, double east, double north) {
  const double x = std::floor((east - s.west()) / s.cell()),
               y = std::floor((s.north() - north) / s.cell());
  if (!(x >= 0 && y >= 0 && x < s.heights.heights.cols && y < s.heights.heights.rows))
    return std::nullopt;
  return Cell{static_cast<int>(x), static_cast<int>(y)};
}

float at(const cv::Mat& m, Cell c) { return m.at<float>(c.y, c.x); }

/// Between the cells where the surface is smooth, else of the cell.
double heightAt(const RunSurface& s, const Eigen::Vector2d& place, Cell cell) {
  const auto smooth = s.heights.smoothHeight(place);
  return smooth ? *smooth : static_cast<double>(at(s.heights.heights, cell));
}

/// Slope of a surface at a cell, 0 where a neighbour has no height.
Eigen::Vector2d slopeAt(const cv::Mat& z, Cell c, double cell_m) {
  if (c.x < 1 || c.y < 1 || c.x + 1 >= z.cols || c.y + 1 >= z.rows) return {0, 0};
  const Eigen::Vector2d slope =
      Eigen::Vector2d(static_cast<double>(z.at<float>(c.y, c.x + 1) - z.at<float>(c.y, c.x - 1)),
                      static_cast<double>(z.at<float>(c.y - 1, c.x) - z.at<float>(c.y + 1, c.x))) /
      (2 * cell_m);
  return slope.allFinite() ? slope : Eigen::Vector2d(0, 0);
}

/// What is known of a cell beside its difference.
struct Knowledge {
  cv::Mat variance;      ///< both runs' 1 / confidence [m^2]
  cv::Mat registration;  ///< variance [m^2]
  cv::Mat step2;         ///< both runs' squared [m^2]
  cv::Mat edge;          ///< CV_8U
};

void sample(const RunSurface& a, const RunSurface& b, const SurfaceRegistration& r,
            HeightChange& change, Knowledge& known) {
  const cv::Size size = change.height.size();
  known.variance = cv::Mat(size, CV_32FC1, cv::Scalar(kNone));
  known.registration = cv::Mat::zeros(size, CV_32FC1);
  known.step2 = cv::Mat::zeros(size, CV_32FC1);
  known.edge = cv::Mat::zeros(size, CV_8UC1);
  tbb::parallel_for(0, size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      Eigen::Vector3d p(change.west_m + (x + 0.5) * change.cell_m,
                        change.north_m - (y + 0.5) * change.cell_m, r.middle_m.z() + r.shift_m.z());
      const auto cell_a = cellAt(a, p.x(), p.y());
      if (cell_a && !std::isnan(at(a.heights.heights, *cell_a)))
        p.z() = heightAt(a, p.head<2>(), *cell_a);
      const double z_a = p.z();
      // B's place below hangs on the height, through the tilt: once more with B's own.
      std::optional<Cell> cell_b;
      for (int round = 0; round < 2; ++round) {
        Eigen::Vector3d q = r.toB(p);
        cell_b = cellAt(b, q.x(), q.y());
        if (!cell_b || std::isnan(at(b.heights.heights, *cell_b))) {
          cell_b.reset();
          break;
        }
        q.z() = heightAt(b, q.head<2>(), *cell_b);
        p.z() = r.toA(q).z();
      }
      if (!cell_b) continue;
      change.height.at<float>(y, x) = static_cast<float>(p.z());
      if (!cell_a) continue;
      const float variance = at(a.variance, *cell_a) + at(b.variance, *cell_b);
      if (std::isnan(variance)) continue;
      const float step_a = at(a.step, *cell_a), step_b = at(b.step, *cell_b);
      change.difference.at<float>(y, x) = static_cast<float>(p.z() - z_a);
      known.variance.at<float>(y, x) = variance;
      known.step2.at<float>(y, x) = step_a * step_a + step_b * step_b;
      const bool edge = a.edge.at<uchar>(cell_a->y, cell_a->x) != 0 ||
                        b.edge.at<uchar>(cell_b->y, cell_b->x) != 0;
      known.edge.at<uchar>(y, x) = edge ? 1 : 0;
      const Eigen::Vector2d slope =
          edge ? Eigen::Vector2d(0, 0) : slopeAt(a.heights.heights, *cell_a, a.cell());
      known.registration.at<float>(y, x) = static_cast<float>(r.heightVariance(p, slope));
    }
  });
}

/// The smooth cells whose difference is within three NMAD.
std::vector<Cell> stableCells(const cv::Mat& difference, const cv::Mat& edge,
                              HeightChange::Stable& stable) {
  std::vector<Cell> smooth;
  std::vector<double> values;
  for (int y = 0; y < difference.rows; ++y)
    for (int x = 0; x < difference.cols; ++x) {
      const float d = difference.at<float>(y, x);
      if (std::isnan(d) || edge.at<uchar>(y, x) != 0) continue;
      smooth.push_back({x, y});
      values.push_back(static_cast<double>(d));
    }
  if (values.size() < kMinCells)
    throw RunError(fmt::format("the runs have {} cells of smooth ground in common, {} needed",
                               values.size(), kMinCells));
  stable.bias_m = median(values);
  stable.nmad_m = nmad(values);
  std::vector<Cell> kept;
  for (const Cell c : smooth)
    if (std::abs(static_cast<double>(at(difference, c)) - stable.bias_m) < 3 * stable.nmad_m)
      kept.push_back(c);
  stable.cells = kept.size();
  stable.share = static_cast<double>(kept.size()) / static_cast<double>(smooth.size());
  return kept;
}

/// Squared differences as constant^2 + per_confidence^2 variance, by tenths of the variance.
HeightChange::Noise fitNoise(const cv::Mat& difference, const Knowledge& known,
                             std::vector<Cell> cells) {
  std::sort(cells.begin(), cells.end(), [&](Cell a, Cell b) {
    return std::make_tuple(at(known.variance, a), a.y, a.x) <
           std::make_tuple(at(known.variance, b), b.y, b.x);
  });
  double n = 0, u = 0, uu = 0, v = 0, uv = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const std::size_t begin = bin * cells.size() / kBins, end = (bin + 1) * cells.size() / kBins;
    std::vector<double> d, variance, other;
    for (std::size_t i = begin; i < end; ++i) {
      d.push_back(static_cast<double>(at(difference, cells[i])));
      variance.push_back(static_cast<double>(at(known.variance, cells[i])));
      other.push_back(
          static_cast<double>(at(known.registration, cells[i]) + at(known.step2, cells[i])));
    }
    const double seen = nmad(std::move(d));
    const double x = median(std::move(variance)),
                 y = std::max(0.0, seen * seen - median(std::move(other)));
    ++n, u += x, uu += x * x, v += y, uv += x * y;
  }
  const double spread = n * uu - u * u;
  double slope = spread > 0 ? (n * uv - u * v) / spread : 0;
  slope = std::clamp(slope, 0.0, uv / std::max(uu, 1e-30));
  HeightChange::Noise noise;
  noise.per_confidence = std::sqrt(slope);
  noise.constant_m = std::sqrt(std::max(0.0, (v - slope * u) / n));
  return noise;
}

/// Spread of the means over squares of stable ground, from one metre up.
std::vector<HeightChange::BlockSpread> blockSpreads(const HeightChange& change,
                                                    const std::vector<Cell>& cells) {
  std::vector<HeightChange::BlockSpread> spreads;
  for (double side = 1; side <= kMaxBlock_m; side *= 2) {
    const int n = std::max(1, static_cast<int>(std::lround(side / change.cell_m)));
    cv::Mat sums = cv::Mat::zeros(change.height.rows / n + 1, change.height.cols / n + 1, CV_64FC2);
    for (const Cell c : cells)
      sums.at<cv::Vec2d>(c.y / n, c.x / n) +=
          cv::Vec2d(static_cast<double>(at(change.difference, c)), 1);
    std::vector<double> means;
    for (auto s = sums.begin<cv::Vec2d>(); s != sums.end<cv::Vec2d>(); ++s)
      if ((*s)[1] >= 0.5 * n * n) means.push_back((*s)[0] / (*s)[1]);
    if (means.size() < kMinBlocks) break;
    const std::size_t blocks = means.size();
    spreads.push_back({n * change.cell_m, nmad(std::move(means)), blocks});
  }
  return spreads;
}

}  // namespace

double HeightChange::meanSigma(double area_m2) const {
  double spread_m = stable.nmad_m;
  for (const BlockSpread& spread : block_spreads)
    if (spread.side_m * spread.side_m <= area_m2) spread_m = spread.nmad_m;
  return spread_m;
}

HeightChange heightChange(const RunSurface& a, const RunSurface& b, const SurfaceRegistration& r,
                          double cell_m) {
  HeightChange change;
  change.cell_m = cell_m;
  // The box of both: B's corners at its middle height.
  Eigen::AlignedBox2d box_a, box_b;
  const auto extend = [](Eigen::AlignedBox2d& box, const RunSurface& s, const auto& moved) {
    for (const int i : {0, s.heights.heights.cols})
      for (const int j : {0, s.heights.heights.rows})
        box.extend(Eigen::Vector2d(moved(s.west() + i * s.cell(), s.north() - j * s.cell())));
  };
  extend(box_a, a, [](double e, double n) { return Eigen::Vector2d(e, n); });
  extend(box_b, b, [&](double e, double n) {
    return Eigen::Vector2d(r.toA({e, n, r.middle_m.z()}).head<2>());
  });
  const Eigen::AlignedBox2d box = box_a.intersection(box_b);
  // Lines of A's grid where the cells are A's.
  change.west_m = a.west() + std::floor((box.min().x() - a.west()) / cell_m) * cell_m;
  change.north_m = a.north() - std::floor((a.north() - box.max().y()) / cell_m) * cell_m;
  const double columns = std::ceil((box.max().x() - change.west_m) / cell_m),
               rows = std::ceil((change.north_m - box.min().y()) / cell_m);
  if (!(columns >= 1 && rows >= 1)) throw RunError("the runs have no ground in common");
  if (columns * rows > kMostCells)
    throw RunError(
        fmt::format("the common ground has {:.3g} cells of {:.3g} m: give a larger --cell",
                    columns * rows, cell_m));
  const cv::Size size(static_cast<int>(columns), static_cast<int>(rows));
  for (cv::Mat* m : {&change.height, &change.difference, &change.sigma, &change.smooth_sigma})
    *m = cv::Mat(size, CV_32FC1, cv::Scalar(kNone));

  Knowledge known;
  sample(a, b, r, change, known);
  const std::vector<Cell> stable = stableCells(change.difference, known.edge, change.stable);
  change.noise = fitNoise(change.difference, known, stable);
  const double constant = change.noise.constant_m * change.noise.constant_m,
               slope = change.noise.per_confidence * change.noise.per_confidence;
  tbb::parallel_for(0, size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      const Cell c{x, y};
      const double smooth = constant + slope * static_cast<double>(at(known.variance, c)) +
                            static_cast<double>(at(known.registration, c));
      change.smooth_sigma.at<float>(y, x) = static_cast<float>(std::sqrt(smooth));
      change.sigma.at<float>(y, x) =
          static_cast<float>(std::sqrt(smooth + static_cast<double>(at(known.step2, c))));
    }
  });
  // The whole is brought to what stable ground shows: 95 % of it within 1.96 sigma.
  std::vector<double> normalised;
  for (const Cell c : stable)
    normalised.push_back(static_cast<double>(at(change.difference, c) / at(change.sigma, c)));
  std::vector<double> magnitudes;
  for (const double z : normalised) magnitudes.push_back(std::abs(z));
  change.noise.factor = std::max(kLeastFactor, quantile(std::move(magnitudes), 0.95) / 1.96);
  change.sigma *= change.noise.factor;
  change.smooth_sigma *= change.noise.factor;
  const auto beyond = [&](double limit) {
    return static_cast<double>(
               std::count_if(normalised.begin(), normalised.end(),
                             [&](double z) { return std::abs(z) > limit * change.noise.factor; })) /
           static_cast<double>(normalised.size());
  };
  change.stable.beyond_2_sigma = beyond(2);
  change.stable.beyond_3_sigma = beyond(3);
  change.block_spreads = blockSpreads(change, stable);
  return change;
}

}  // namespace cf
