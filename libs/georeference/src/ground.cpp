// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "cf/base/median.h"
#include "segment.h"

namespace cf {
namespace {

constexpr std::size_t kMinPoints = 12;
constexpr std::size_t kMaxPoints = 300;
constexpr int kSamples = 60;
/// Heights of neighbouring points go together (roofs, trees): so many count as independent.
constexpr double kIndependentPoints = 10;

std::vector<Eigen::Vector3d> pointsOf(const Keyframe& keyframe) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < keyframe.inverse_depth.size(); ++i)
    if (keyframe.inverse_depth[i] > 0) known.push_back(i);
  const std::size_t stride = std::max<std::size_t>(1, known.size() / kMaxPoints);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t k = 0; k < known.size(); k += stride) {
    const Eigen::Vector2d ray =
        keyframe.camera.undistort(keyframe.features->pixel[known[k]].cast<double>());
    const double depth = 1.0 / static_cast<double>(keyframe.inverse_depth[known[k]]);
    points.push_back(depth * ray.homogeneous());
  }
  return points;
}

}  // namespace

void measureGround(Node& node, const GeoreferenceOptions& options) {
  const std::vector<Eigen::Vector3d> points = pointsOf(*node.keyframe);
  if (points.size() < kMinPoints) return;
  std::vector<double> values;
  for (const auto& p : points) values.push_back(p.z());
  node.median_depth = upperMedian(values);

  // Least median of distances over random triples, then a least-squares plane of what is near.
  std::mt19937 random(node.keyframe->id.index);
  double best = std::numeric_limits<double>::infinity();
  Eigen::Hyperplane<double, 3> plane(Eigen::Vector3d::UnitZ(), 0.0);
  for (int s = 0; s < kSamples; ++s) {
    const Eigen::Vector3d &a = points[random() % points.size()],
                          &b = points[random() % points.size()],
                          &c = points[random() % points.size()];
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 1e-9 * node.median_depth * node.median_depth) continue;
    const Eigen::Hyperplane<double, 3> candidate(normal.normalized(), a);
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = candidate.absDistance(points[i]);
    const double median = upperMedian(values);
    if (median < best) {
      best = median;
      plane = candidate;
    }
  }
  if (!std::isfinite(best)) return;
  const double near = std::max(3 * 1.4826 * best, 1e-6 * node.median_depth);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  double count = 0;
  for (const auto& p : points)
    if (plane.absDistance(p) <= near) {
      mean += p;
      moment += p * p.transpose();
      ++count;
    }
  mean /= count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moment / count -
                                                            mean * mean.transpose());
  Eigen::Vector3d normal = axes.eigenvectors().col(0);
  if (normal.dot(mean) > 0) normal = -normal;
  const double thickness = std::sqrt(std::max(0.0, axes.eigenvalues()(0)));
  const double width = std::sqrt(std::max(1e-12, axes.eigenvalues()(1)));
  node.ground_normal_cam = normal;
  node.ground_sigma_rad = std::hypot(options.ground_sigma_deg * kRadPerDeg,
                                     thickness / width / std::sqrt(kIndependentPoints));
}

}  // namespace cf
