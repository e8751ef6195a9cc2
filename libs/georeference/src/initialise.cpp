// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <random>

#include "cf/base/median.h"
#include "cf/geometry/similarity.h"
#include "cf/georeference/frames.h"
#include "segment.h"

namespace cf {
namespace {

using Complex = std::complex<double>;

constexpr unsigned kSeed = 1;
constexpr int kSamples = 300;
constexpr int kRefinements = 10;
constexpr double kLeastTaggedHeight_m = 1;  ///< below, a tag is that of take-off
/// Tags are often smaller than the truth (RTK with photo times of a second): a start is not refused
/// for what an ordinary receiver is off by.
const Eigen::Vector3d kOrdinarySigma(1.5, 1.5, 3);

Eigen::Vector3d startSigma(const GnssPosition& fix) { return fix.sigma_m.cwiseMax(kOrdinarySigma); }

Complex horizontal(const Eigen::Vector3d& p) { return {p.x(), p.y()}; }

Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

/// Rotation to a level frame: the gimbal's (heading included) where tagged, else from the camera
/// axes (down) and the ground normals (up), weighed by their variances.
Eigen::Matrix3d levelRotation(const Segment& segment, const GeoreferenceOptions& options) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d axes = Eigen::Vector3d::Zero(), normals = Eigen::Vector3d::Zero();
  double ground_sigma = options.ground_sigma_deg * kRadPerDeg;
  bool heading_known = false;
  for (const Node& node : segment.nodes) {
    const Eigen::Matrix3d R_local_cam = node.keyframe->T_local_cam.linear();
    if (node.keyframe->attitude) {
      sum += rotationWorldCam(*node.keyframe->attitude) * R_local_cam.transpose();
      heading_known = true;
    }
    axes -= R_local_cam.col(2);
    if (node.ground_normal_cam) {
      normals += R_local_cam * *node.ground_normal_cam;
      ground_sigma = std::max(ground_sigma, node.ground_sigma_rad);
    }
  }
  if (heading_known) return nearestRotation(sum);
  const double nadir_sigma = options.nadir_sigma_deg * kRadPerDeg;
  Eigen::Vector3d up = axes.normalized() / (nadir_sigma * nadir_sigma);
  if (normals.norm() > 0) up += normals.normalized() / (ground_sigma * ground_sigma);
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

/// z_a = turn * z_b + shift.
struct PlaneSimilarity {
  Complex turn = 1, shift = 0;
};

/// Least median of residuals over pairs, then reweighted least squares. Any share of outliers below
/// one half, any unknown noise. None without two distinct points.
std::optional<PlaneSimilarity> fitPlaneSimilarity(const std::vector<Complex>& a,
                                                  const std::vector<Complex>& b) {
  const std::size_t n = a.size();
  std::mt19937 random(kSeed);
  PlaneSimilarity best;
  double best_cost = std::numeric_limits<double>::infinity();
  std::vector<double> distance(n);
  const auto measure = [&](const PlaneSimilarity& s) {
    for (std::size_t i = 0; i < n; ++i) distance[i] = std::abs(a[i] - s.turn * b[i] - s.shift);
    return upperMedian(distance);
  };
  for (int k = 0; k < kSamples; ++k) {
    const std::size_t i = random() % n, j = random() % n;
    if (std::abs(b[i] - b[j]) < 1e-9 || std::abs(a[i] - a[j]) < 1e-9) continue;
    PlaneSimilarity candidate;
    candidate.turn = (a[i] - a[j]) / (b[i] - b[j]);
    candidate.shift = (a[i] + a[j] - candidate.turn * (b[i] + b[j])) / 2.0;
    const double cost = measure(candidate);
    if (cost < best_cost) {
      best_cost = cost;
      best = candidate;
    }
  }
  if (!std::isfinite(best_cost)) return std::nullopt;
  for (int k = 0; k < kRefinements; ++k) {
    const double width = std::max(2 * 1.4826 * measure(best), 1e-6);
    Complex mean_a = 0, mean_b = 0, cross = 0;
    double sum = 0, square = 0;
    std::vector<double> weight(n);
    for (std::size_t i = 0; i < n; ++i) {
      weight[i] = 1 / (1 + distance[i] * distance[i] / (width * width));
      sum += weight[i];
      mean_a += weight[i] * a[i];
      mean_b += weight[i] * b[i];
    }
    mean_a /= sum;
    mean_b /= sum;
    for (std::size_t i = 0; i < n; ++i) {
      cross += weight[i] * (a[i] - mean_a) * std::conj(b[i] - mean_b);
      square += weight[i] * std::norm(b[i] - mean_b);
    }
    if (square <= 0 || std::abs(cross) <= 0) break;
    best.turn = cross / square;
    best.shift = mean_a - best.turn * mean_b;
  }
  return best;
}

/// Levelled, then heading, scale and position from the horizontal alone: garbage in the altitude
/// cannot tilt it, and a straight line is enough. The scale stands in for equation (4), a ratio of
/// single displacements that one bad fix spoils.
Sim3 levelledAlignment(const Segment& segment, const std::vector<Eigen::Vector3d>& fixes,
                       const std::vector<Eigen::Vector3d>& centres,
                       const GeoreferenceOptions& options) {
  Sim3 S;
  S.rotation = levelRotation(segment, options);
  std::vector<Complex> a, b;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    a.push_back(horizontal(fixes[i]));
    b.push_back(horizontal(S.rotation * centres[i]));
  }
  if (const auto plane = fitPlaneSimilarity(a, b)) {
    S.scale = std::abs(plane->turn);
    S.rotation = Eigen::AngleAxisd(std::arg(plane->turn), Eigen::Vector3d::UnitZ()) * S.rotation;
  } else {
    const std::vector<double> hints = scaleHints(segment);
    S.scale = hints.empty() ? 1 : upperMedian(hints);
  }
  std::vector<double> shift[3];
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const Eigen::Vector3d d = fixes[i] - S.scale * (S.rotation * centres[i]);
    for (int k = 0; k < 3; ++k) shift[k].push_back(d[k]);
  }
  for (int k = 0; k < 3; ++k) S.translation[k] = upperMedian(shift[k]);
  return S;
}

/// True when half of the fixes or more lie within twice their usual noise, in all three axes.
bool fitsUsualNoise(const Sim3& S, const Segment& segment) {
  std::vector<double> horizontal_error, vertical_error;
  for (const Node& node : segment.nodes)
    if (node.fix) {
      const Eigen::Vector3d e =
          (S * Eigen::Vector3d(node.keyframe->T_local_cam.translation()) - node.fix->position_m)
              .cwiseQuotient(startSigma(*node.fix));
      horizontal_error.push_back(e.head<2>().norm());
      vertical_error.push_back(std::abs(e.z()));
    }
  // Medians of the Rayleigh and half-normal distributions of sigma 1.
  return upperMedian(horizontal_error) < 2 * 1.177 && upperMedian(vertical_error) < 2 * 0.674;
}

/// Robust misfit of a candidate: to the fixes at their usual noise, and of its attitude.
double misfit(const Sim3& S, const Segment& segment, const GeoreferenceOptions& options) {
  double cost = 0, tilt = 0, count = 0;
  for (const Node& node : segment.nodes) {
    const Eigen::Isometry3d T = S.carry(node.keyframe->T_local_cam);
    if (node.fix) {
      const Eigen::Vector3d e =
          (T.translation() - node.fix->position_m).cwiseQuotient(startSigma(*node.fix));
      cost += std::log1p(e.head<2>().squaredNorm() / 4) + std::log1p(e.z() * e.z() / 4);
    }
    const bool tagged = node.keyframe->attitude.has_value();
    const Eigen::Vector3d expected =
        tagged ? Eigen::Vector3d(rotationWorldCam(*node.keyframe->attitude).col(2))
               : Eigen::Vector3d(-Eigen::Vector3d::UnitZ());
    const double sigma =
        (tagged ? options.gimbal_tilt_sigma_deg : options.nadir_sigma_deg) * kRadPerDeg;
    tilt += (T.linear().col(2) - expected).squaredNorm() / (2 * sigma * sigma);
    ++count;
  }
  return cost + tilt / count;
}

/// Noise per axis from the residuals of the rigid fit, by their median.
NoiseSums rigidNoise(Segment& segment) {
  std::vector<double> error[3];
  for (const Node& node : segment.nodes)
    if (node.fix)
      for (int k = 0; k < 3; ++k)
        error[k].push_back(std::abs(node.T_world_cam.translation()[k] - node.fix->position_m[k]) /
                           node.fix->sigma_m[k]);
  constexpr double kFittedPerAxis = 7.0 / 3;
  const double n = static_cast<double>(error[0].size());
  if (n <= kFittedPerAxis + 1) return {};  // too few to tell: the tagged sigma holds
  Noise robust;
  for (int k = 0; k < 3; ++k)
    robust.factor[k] = 1.4826 * upperMedian(error[k]) * std::sqrt(n / (n - kFittedPerAxis));
  gateFixes(segment, robust);
  measureNoise(segment, {});
  NoiseSums sums = segment.noise;  // for the correlation of neighbours
  sums.count.setConstant(n);
  sums.square = n * robust.factor.cwiseAbs2();
  return sums;
}

}  // namespace

int Segment::fixes() const {
  return static_cast<int>(
      std::count_if(nodes.begin(), nodes.end(), [](const Node& n) { return n.fix.has_value(); }));
}

std::vector<double> scaleHints(const Segment& segment) {
  std::vector<double> hints;
  for (const Node& node : segment.nodes) {
    const double height_m = node.keyframe->height_above_ground_m.value_or(0);
    if (node.median_depth > 0 && height_m > kLeastTaggedHeight_m)
      hints.push_back(height_m / node.median_depth);
  }
  return hints;
}

Eigen::Isometry3d incrementTo(const Segment& segment, std::size_t j) {
  return segment.nodes[j - 1].keyframe->T_local_cam.inverse() *
         segment.nodes[j].keyframe->T_local_cam;
}

void predictLast(Segment& segment) {
  const std::size_t last = segment.nodes.size() - 1;
  if (last == 0) return;
  Eigen::Isometry3d T_i_j = incrementTo(segment, last);
  T_i_j.translation() *= segment.scale;
  segment.nodes[last].T_world_cam = segment.nodes[last - 1].T_world_cam * T_i_j;
}

bool initialise(Segment& segment, const GeoreferenceOptions& options) {
  std::vector<Eigen::Vector3d> fixes, centres;
  double threshold = 0;
  for (const Node& node : segment.nodes)
    if (node.fix) {
      fixes.push_back(node.fix->position_m);
      centres.push_back(node.keyframe->T_local_cam.translation());
      threshold = std::max(threshold, 3 * startSigma(*node.fix).norm());
    }
  if (fixes.empty()) return false;

  Sim3 S = levelledAlignment(segment, fixes, centres, options);
  // Where all three axes are as good as usual and the path is no line, they give the attitude.
  const int needed = std::max(4, static_cast<int>(fixes.size() * 7 / 10));
  const auto spatial =
      alignPointsRobust(fixes, centres, AlignmentModel::kSim3, threshold, needed, kSeed);
  if (spatial && fitsUsualNoise(spatial->S_a_b, segment) &&
      misfit(spatial->S_a_b, segment, options) < misfit(S, segment, options))
    S = spatial->S_a_b;

  segment.scale = S.scale;
  for (Node& node : segment.nodes) {
    node.T_world_cam = S.carry(node.keyframe->T_local_cam);
    node.covariance.setZero();
  }
  segment.noise = rigidNoise(segment);
  return true;
}

}  // namespace cf
