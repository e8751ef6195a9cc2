// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface_registration.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "cf/evaluate/registration.h"
#include "statistics.h"

namespace cf {
namespace {

using Row = Eigen::Matrix<double, 7, 1>;
using Square = Eigen::Matrix<double, 7, 7>;

constexpr double kSample_m = 0.5;
constexpr std::size_t kMaxSamples = 400'000;
constexpr std::size_t kMinSamples = 800;  ///< 200 m^2
constexpr double kLeastOverlap = 0.1, kLeastStable = 0.4;
/// Beyond what receivers get wrong: other ground has been forced together.
constexpr double kMostScale = 0.1, kMostTurn_deg = 10, kMostSpread_cells = 3;
constexpr double kTukey = 4.685;
constexpr double kLeastSpread_m = 0.005;
constexpr double kBlock_m = 10;
constexpr int kRounds = 30;
const double kPriorSigma[7] = {1, 1, 100, M_PI / 180, M_PI / 180, M_PI / 180, 0.01};

/// Middles of the cells that have a height, about `origin`.
std::vector<Eigen::Vector3d> pointsOf(const RunSurface& s, const Eigen::Vector3d& origin) {
  std::vector<Eigen::Vector3d> points;
  const cv::Mat& z = s.heights.heights;
  for (int y = 0; y < z.rows; ++y)
    for (int x = 0; x < z.cols; ++x)
      if (!std::isnan(z.at<float>(y, x)))
        points.push_back(Eigen::Vector3d(s.west() + (x + 0.5) * s.cell(),
                                         s.north() - (y + 0.5) * s.cell(),
                                         static_cast<double>(z.at<float>(y, x))) -
                         origin);
  return points;
}

std::vector<Eigen::Vector3f> floats(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3f> out;
  out.reserve(points.size());
  for (const auto& p : points) out.push_back(p.cast<float>());
  return out;
}

/// Where a point of B meets the surface of A.
struct Sample {
  Eigen::Vector3d p;  ///< in A, about the origin
  Eigen::Vector2d slope;
  double residual = 0;  ///< height of A above B [m]
};

std::vector<Sample> samplesOf(const std::vector<Eigen::Vector3d>& points,
                              const SurfaceRegistration& r, const RunSurface& a) {
  std::vector<Sample> samples;
  const double h = a.cell();
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = r.toA(point);
    const auto at = [&](double dx, double dy) {
      return a.heights.smoothHeight(p.head<2>() + Eigen::Vector2d(dx, dy));
    };
    const auto z = at(0, 0), east = at(h, 0), west = at(-h, 0), north = at(0, h), south = at(0, -h);
    if (!z || !east || !west || !north || !south) continue;
    samples.push_back({p, {(*east - *west) / (2 * h), (*north - *south) / (2 * h)}, *z - p.z()});
  }
  return samples;
}

/// Derivative of the residual by shift, rotation and scale of B about `pivot`.
Row jacobian(const Eigen::Vector3d& p, const Eigen::Vector2d& slope, const Eigen::Vector3d& pivot) {
  const Eigen::Vector3d g(slope.x(), slope.y(), -1), arm = p - pivot;
  Row row;
  row << g, arm.cross(g), g.dot(arm);
  return row;
}

double spreadOf(const std::vector<Sample>& samples) {
  std::vector<double> residuals;
  residuals.reserve(samples.size());
  for (const Sample& s : samples) residuals.push_back(s.residual);
  return std::max(kLeastSpread_m, nmad(std::move(residuals)));
}

void move(SurfaceRegistration& r, const Row& step) {
  const Eigen::Vector3d turn = step.segment<3>(3);
  r.shift_m += step.head<3>();
  if (turn.norm() > 0)
    r.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).matrix() * r.rotation;
  r.scale *= std::exp(step[6]);
}

/// Least squares about the middle; fills what it is told of in `r`.
void refine(const std::vector<Eigen::Vector3d>& points, const RunSurface& a,
            SurfaceRegistration& r) {
  const Row prior = Eigen::Map<const Row>(kPriorSigma).array().square().inverse();
  Row moved = Row::Zero();
  for (int round = 0;; ++round) {
    const std::vector<Sample> samples = samplesOf(points, r, a);
    const double sigma = spreadOf(samples), limit = kTukey * sigma;
    const Eigen::Vector3d pivot = r.middle_m + r.shift_m;
    Square H = prior.asDiagonal();
    Row g = -prior.cwiseProduct(moved);
    std::map<std::pair<long, long>, Row> blocks;
    double stable = 0;
    for (const Sample& s : samples) {
      if (std::abs(s.residual) < 3 * sigma) ++stable;
      const double ratio = s.residual / limit;
      if (std::abs(ratio) >= 1) continue;
      const double weight = std::pow(1 - ratio * ratio, 2) / (sigma * sigma);
      const Row J = jacobian(s.p, s.slope, pivot);
      H += weight * J * J.transpose();
      g -= weight * s.residual * J;
      const auto block = std::make_pair(std::lround(std::floor(s.p.x() / kBlock_m)),
                                        std::lround(std::floor(s.p.y() / kBlock_m)));
      blocks.try_emplace(block, Row::Zero()).first->second += weight * s.residual * J;
    }
    const Square inverse = H.inverse();
    const Row step = inverse * g;
    if (round == kRounds || (step.head<3>().norm() < 1e-4 && step.tail<4>().norm() < 1e-7)) {
      Square spread = prior.asDiagonal();
      for (const auto& [place, sum] : blocks) spread += sum * sum.transpose();
      r.covariance = inverse * spread * inverse;
      r.samples = samples.size();
      r.stable_share = samples.empty() ? 0 : stable / static_cast<double>(samples.size());
      r.nmad_m = sigma;
      return;
    }
    move(r, step);
    moved += step;
  }
}

}  // namespace

double SurfaceRegistration::heightVariance(const Eigen::Vector3d& p_a,
                                           const Eigen::Vector2d& slope) const {
  const Row J = jacobian(p_a, slope, middle_m + shift_m);
  return J.dot(covariance * J);
}

Result<SurfaceRegistration> registerSurfaces(const RunSurface& fine_a, const RunSurface& fine_b) {
  RunSurface a = averaged(fine_a, kSample_m);
  const RunSurface b = averaged(fine_b, kSample_m);
  // About the middle of A: floats do for the coarse step.
  Eigen::Vector3d origin(a.west() + a.cell() * a.heights.heights.cols / 2,
                         a.north() - a.cell() * a.heights.heights.rows / 2, 0);
  auto points_a = pointsOf(a, origin), points_b = pointsOf(b, origin);
  if (points_a.size() < kMinSamples || points_b.size() < kMinSamples)
    return Failure{"small", fmt::format("the surfaces have {} and {} cells of {:.2g} m, {} needed",
                                        points_a.size(), points_b.size(), a.cell(), kMinSamples)};
  const auto coarse = registerClouds(floats(points_b), floats(points_a));
  if (!coarse) return coarse.failure();

  a.heights.west_m -= origin.x();
  a.heights.north_m -= origin.y();
  const auto smaller = static_cast<double>(std::min(points_a.size(), points_b.size()));
  const std::size_t n = (points_b.size() - 1) / kMaxSamples + 1;
  for (std::size_t i = 0; i * n < points_b.size(); ++i) points_b[i] = points_b[i * n];
  points_b.resize((points_b.size() - 1) / n + 1);
  SurfaceRegistration r;
  r.sample_m = a.cell();
  for (const auto& p : points_b) r.middle_m += p / static_cast<double>(points_b.size());
  r.rotation = coarse->T_ref_est.linear();
  r.shift_m = coarse->T_ref_est * r.middle_m - r.middle_m;
  // The middle of the ground that both have: there the shift says most.
  Eigen::Vector3d common = Eigen::Vector3d::Zero();
  double count = 0;
  for (const Eigen::Vector3d& p : points_b) {
    const Eigen::Vector3d q = r.toA(p);
    if (!a.heights.heightRange(q.head<2>(), 0)) continue;
    common += p;
    ++count;
  }
  const double cells = count * static_cast<double>(n), share = cells / smaller;
  if (share < kLeastOverlap || cells < static_cast<double>(kMinSamples))
    return Failure{"overlap",
                   fmt::format("they have {:.0f} m2 in common, {:.1f} % of the smaller; {:.0f} % "
                               "and {} cells of {:.2g} m are needed",
                               cells * b.cell() * b.cell(), 100 * share, 100 * kLeastOverlap,
                               kMinSamples, b.cell())};
  const Eigen::Vector3d middle = common / count;
  r.shift_m = r.toA(middle) - middle;
  r.middle_m = middle;
  refine(points_b, a, r);
  if (r.samples < kMinSamples || r.stable_share < kLeastStable)
    return Failure{"unstable", fmt::format("only {:.0f} % of {} places agree: is it one place?",
                                           100 * r.stable_share, r.samples)};
  const double turn_deg = Eigen::AngleAxisd(r.rotation).angle() * 180 / M_PI;
  if (std::abs(std::log(r.scale)) > kMostScale || turn_deg > kMostTurn_deg)
    return Failure{"unlike", fmt::format("they fit only turned by {:.1f} degrees and scaled by "
                                         "{:.3f}: is it one place?",
                                         turn_deg, r.scale)};
  const double cell_m = std::max(fine_a.cell(), fine_b.cell());
  if (r.nmad_m > kMostSpread_cells * cell_m)
    return Failure{"unlike",
                   fmt::format("heights of their common ground differ by {:.2f} m (NMAD), "
                               "{:.2f} m are allowed: is it one place?",
                               r.nmad_m, kMostSpread_cells * cell_m)};
  r.middle_m += origin;
  return r;
}

}  // namespace cf
