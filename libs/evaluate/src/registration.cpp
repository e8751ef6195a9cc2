// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/registration.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "height_search.h"
#include "kd_tree.h"
#include "local_plane.h"
#include "statistics.h"
#include "voxel_means.h"

namespace cf {
namespace {

constexpr std::size_t kMaxRead = 3'000'000;   ///< points of each cloud that take part
constexpr std::size_t kMaxTargets = 300'000;  ///< voxels of the reference
constexpr std::size_t kMaxSources = 60'000;   ///< voxels of the estimate
constexpr std::size_t kMinPairs = 50;
constexpr std::size_t kNeighbours = 12;
constexpr double kFinestVoxel_m = 0.5;
/// The estimate counts this far beyond the reference; heights may have another datum altogether.
constexpr float kMargin_m = 30, kHeightMargin_m = 10'000;
constexpr double kTukey = 4.685;
constexpr double kDamping = 1e-4;  ///< of the information that a pair may have

/// The reference at one resolution.
struct Target {
  KdTree<3> tree;
  std::vector<LocalPlane> planes;  ///< by tree index

  explicit Target(std::vector<Eigen::Vector3f> points) : tree(std::move(points)) {
    planes.resize(tree.points().size());
    tbb::parallel_for(std::size_t{0}, planes.size(), [&](std::size_t i) {
      planes[i] = localPlane(tree, tree.points()[i], kNeighbours);
    });
  }
};

struct Pair {
  bool valid = false;
  Eigen::Vector3d point, normal;  ///< of the moved estimate; of the reference
  double residual = 0;            ///< [m]
  double weight = 0;              ///< flat surroundings count more
};

std::vector<Pair> pairsOf(const std::vector<Eigen::Vector3f>& source, const Target& target,
                          const Eigen::Isometry3d& T, double reach_m) {
  std::vector<Pair> pairs(source.size());
  const auto reach2 = static_cast<float>(reach_m * reach_m);
  tbb::parallel_for(std::size_t{0}, source.size(), [&](std::size_t i) {
    thread_local std::vector<std::pair<float, std::uint32_t>> found;
    const Eigen::Vector3d p = T * source[i].cast<double>();
    target.tree.nearest(p.cast<float>(), 1, reach2, found);
    if (found.empty()) return;
    const LocalPlane& plane = target.planes[found.front().second];
    const Eigen::Vector3d q = target.tree.points()[found.front().second].cast<double>();
    if (!plane.determined) return;
    pairs[i] = {true, p, plane.normal, plane.normal.dot(p - q),
                std::pow(1 - 3 * plane.roughness, 2)};
  });
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [](const Pair& p) { return !p.valid; }),
              pairs.end());
  return pairs;
}

struct Fit {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double inlier_share = 0;  ///< of the sources
  double rms_m = 0;
};

/// ICP at one resolution.
Result<Fit> icp(const std::vector<Eigen::Vector3f>& source, const Target& target,
                const Eigen::Isometry3d& start, double reach_m) {
  Fit fit;
  fit.T = start;
  for (int round = 0; round < 40; ++round) {
    const std::vector<Pair> pairs = pairsOf(source, target, fit.T, reach_m);
    if (pairs.size() < kMinPairs)
      return Failure{"no_overlap", "the clouds have " + std::to_string(pairs.size()) +
                                       " pairs of neighbours, " + std::to_string(kMinPairs) +
                                       " needed"};
    std::vector<double> magnitude;
    Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
    for (const Pair& pair : pairs) {
      magnitude.push_back(std::abs(pair.residual));
      pivot += pair.point / static_cast<double>(pairs.size());
    }
    const double limit = kTukey * std::max(0.01, 1.4826 * median(magnitude));
    using Vector6d = Eigen::Matrix<double, 6, 1>;
    Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
    Vector6d b = Vector6d::Zero();
    double squares = 0, inliers = 0;
    for (const Pair& pair : pairs) {
      const double ratio = pair.residual / limit;
      if (std::abs(ratio) >= 1) continue;
      const double weight = pair.weight * std::pow(1 - ratio * ratio, 2);
      Vector6d J;
      J << pair.normal, (pair.point - pivot).cross(pair.normal);
      H += weight * J * J.transpose();
      b -= weight * pair.residual * J;
      squares += pair.residual * pair.residual;
      ++inliers;
    }
    fit.inlier_share = inliers / static_cast<double>(source.size());
    fit.rms_m = std::sqrt(squares / std::max(1.0, inliers));
    // What the surfaces leave free (sliding over flat ground) stays where it is.
    const double spread = H.diagonal().tail<3>().sum() / H.diagonal().head<3>().sum();
    H.diagonal().head<3>().array() += kDamping * inliers;
    H.diagonal().tail<3>().array() += kDamping * inliers * spread;
    const Vector6d step = H.ldlt().solve(b);
    const Eigen::Vector3d turn = step.tail<3>();
    Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
    move.translate(pivot + Eigen::Vector3d(step.head<3>()));
    if (turn.norm() > 0) move.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    move.translate(-pivot);
    fit.T = move * fit.T;
    if (step.head<3>().norm() < 1e-4 && turn.norm() < 1e-6) break;
  }
  return fit;
}

Eigen::AlignedBox3f boxOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : points) box.extend(p);
  return box;
}

}  // namespace

Result<Registration> registerClouds(const std::vector<Eigen::Vector3f>& estimate,
                                    const std::vector<Eigen::Vector3f>& reference) {
  const std::vector<Eigen::Vector3f> est = everyNth(estimate, kMaxRead);
  const std::vector<Eigen::Vector3f> ref = everyNth(reference, kMaxRead);
  const Eigen::AlignedBox3f ref_box = boxOf(ref);
  const Eigen::Vector3f margin(kMargin_m, kMargin_m, kHeightMargin_m);
  const Eigen::AlignedBox3f est_box(ref_box.min() - margin, ref_box.max() + margin);

  double voxel = kFinestVoxel_m;
  std::vector<Eigen::Vector3f> fine_ref = voxelMeans(ref, ref_box, voxel);
  while (fine_ref.size() > kMaxTargets) {
    voxel *= 1.5;
    fine_ref = voxelMeans(ref, ref_box, voxel);
  }
  const std::vector<Eigen::Vector3f> fine_est = voxelMeans(est, est_box, voxel);
  const auto starts = searchByHeight(fine_est, fine_ref, 2 * voxel, 3);
  if (starts.empty())
    return Failure{"no_overlap", "the clouds do not overlap on the ground: check their origins"};

  Result<Fit> best = Failure{};
  for (const double factor : {4.0, 2.0, 1.0}) {
    const double size = factor * voxel;
    const Target target(factor == 1 ? fine_ref : voxelMeans(ref, ref_box, size));
    const auto source = everyNth(voxelMeans(est, est_box, size), kMaxSources);
    if (factor < 4) {
      best = icp(source, target, best->T, 2 * size);
    } else {
      for (const Eigen::Isometry3d& start : starts) {
        const auto fit = icp(source, target, start, 2 * size);
        // The fit that brings most points near the reference: shares within one common distance.
        const auto score = [&](const Fit& f) {
          double sum = 0;
          for (const Pair& p : pairsOf(source, target, f.T, 2 * size))
            sum += std::max(0.0, 1 - std::abs(p.residual));
          return sum;
        };
        if (!best || (fit && score(*fit) > score(*best))) best = fit;
      }
    }
    if (!best) return best.failure();
  }

  Registration result;
  result.T_ref_est = best->T;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& p : fine_est) middle += p.cast<double>() / static_cast<double>(fine_est.size());
  result.shift_m = best->T * middle - middle;
  result.rotation_deg = Eigen::AngleAxisd(best->T.linear()).angle() * 180 / 3.14159265358979323846;
  result.inlier_share = best->inlier_share;
  result.inlier_rms_m = best->rms_m;
  return result;
}

}  // namespace cf
