// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "local_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

/// Pose of a camera as Ceres sees it: T_local_cam.
struct PoseBlock {
  double q[4];  ///< w x y z
  double t[3];
};

PoseBlock blockOf(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  return {{q.w(), q.x(), q.y(), q.z()},
          {T.translation().x(), T.translation().y(), T.translation().z()}};
}

Eigen::Isometry3d poseOf(const PoseBlock& block) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(block.q[0], block.q[1], block.q[2], block.q[3])
                   .normalized()
                   .toRotationMatrix();
  T.translation() = Eigen::Vector3d(block.t[0], block.t[1], block.t[2]);
  return T;
}

/// Residual (3): projection (2) of an anchored inverse depth into another photo minus where it was
/// seen, on the normalized plane, in units of the threshold. Homogeneous: with lambda -> 0 the
/// point goes to infinity smoothly.
struct InverseDepthError {
  Eigen::Vector2d anchor, seen;
  double scale;

  template <class T>
  bool operator()(const T* qi, const T* ti, const T* qj, const T* tj, const T* lambda,
                  T* residual) const {
    const T ray[3] = {T(anchor.x()), T(anchor.y()), T(1)};
    T p[3], d[3], c[3];
    ceres::QuaternionRotatePoint(qi, ray, p);
    for (int k = 0; k < 3; ++k) d[k] = p[k] + (ti[k] - tj[k]) * lambda[0];
    const T inverse[4] = {qj[0], -qj[1], -qj[2], -qj[3]};
    ceres::QuaternionRotatePoint(inverse, d, c);
    if (c[2] < T(1e-6)) return false;
    residual[0] = T(scale) * (c[0] / c[2] - T(seen.x()));
    residual[1] = T(scale) * (c[1] / c[2] - T(seen.y()));
    return true;
  }
};

void removeOutliers(LocalMap& map, const std::vector<int>& landmark_ids, double threshold) {
  for (const int id : landmark_ids) {
    Landmark& landmark = map.landmarks[static_cast<std::size_t>(id)];
    const Eigen::Vector3d p = map.position(landmark);
    auto& all = landmark.observations;
    const auto bad = [&](const LandmarkObservation& o) {
      TrackedPhoto& photo = map.photo(o.photo);
      const auto feature = static_cast<std::size_t>(o.feature);
      if (landmark.inverse_depth > 0 &&
          reprojectionError({photo.T_local_cam, photo.normalized[feature]}, p) < threshold)
        return false;
      photo.landmark[feature] = -1;
      return true;
    };
    // The anchor's own error is zero by construction: without support it goes as well.
    all.erase(std::remove_if(all.begin() + 1, all.end(), bad), all.end());
    if (all.size() >= 2 && landmark.inverse_depth > 0) continue;
    for (const auto& o : all) map.photo(o.photo).landmark[static_cast<std::size_t>(o.feature)] = -1;
    all.resize(1);
    landmark.inverse_depth = 0;
  }
}

}  // namespace

void adjustLocally(LocalMap& map, const std::vector<PhotoIndex>& window, double threshold) {
  std::map<PhotoIndex, PoseBlock> poses;
  std::set<int> seen;
  for (const PhotoIndex i : window)
    for (const int id : map.photo(i).landmark)
      if (id >= 0) seen.insert(id);
  const std::vector<int> landmark_ids(seen.begin(), seen.end());
  std::vector<double> lambdas(landmark_ids.size());

  const auto block = [&](PhotoIndex i) -> PoseBlock& {
    return poses.try_emplace(i, blockOf(map.photo(i).T_local_cam)).first->second;
  };
  ceres::Problem problem;
  ceres::LossFunction* loss = new ceres::HuberLoss(0.5);
  for (std::size_t k = 0; k < landmark_ids.size(); ++k) {
    const Landmark& landmark = map.landmarks[static_cast<std::size_t>(landmark_ids[k])];
    lambdas[k] = landmark.inverse_depth;
    const LandmarkObservation& anchor = landmark.observations.front();
    PoseBlock& host = block(anchor.photo);
    const auto& ray = map.photo(anchor.photo).normalized[static_cast<std::size_t>(anchor.feature)];
    for (std::size_t o = 1; o < landmark.observations.size(); ++o) {
      const LandmarkObservation& observation = landmark.observations[o];
      PoseBlock& target = block(observation.photo);
      const auto& at =
          map.photo(observation.photo).normalized[static_cast<std::size_t>(observation.feature)];
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<InverseDepthError, 2, 4, 3, 4, 3, 1>(
                                   new InverseDepthError{ray, at, 1 / threshold}),
                               loss, host.q, host.t, target.q, target.t, &lambdas[k]);
    }
  }
  if (problem.NumResidualBlocks() == 0) {
    delete loss;
    return;
  }
  const auto free = [&](PhotoIndex i) {
    return !map.photo(i).final && std::find(window.begin(), window.end(), i) != window.end();
  };
  const auto held =
      std::count_if(poses.begin(), poses.end(), [&](const auto& p) { return !free(p.first); });
  // A young segment has no two held poses yet: its first photo stays at the origin of the local
  // frame and the first baseline keeps its length.
  bool hold_first = held == 0, hold_length = held <= 1;
  for (auto& [i, pose] : poses) {
    if (!free(i) || hold_first) {
      problem.SetParameterBlockConstant(pose.q);
      problem.SetParameterBlockConstant(pose.t);
      hold_first = false;
      continue;
    }
    problem.SetManifold(pose.q, new ceres::QuaternionManifold());
    if (hold_length && Eigen::Map<Eigen::Vector3d>(pose.t).norm() > 1e-6)
      problem.SetManifold(pose.t, new ceres::SphereManifold<3>());
    hold_length = false;
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (double& lambda : lambdas)
    if (problem.HasParameterBlock(&lambda)) ordering->AddElementToGroup(&lambda, 0);
  // Within a group Ceres orders by address, which differs from run to run: a group for each.
  int group = 1;
  for (auto& [i, pose] : poses) {
    ordering->AddElementToGroup(pose.q, group++);
    ordering->AddElementToGroup(pose.t, group++);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.max_num_iterations = 12;
  options.function_tolerance = 1e-5;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;

  for (const auto& [i, pose] : poses)
    if (free(i)) map.photo(i).T_local_cam = poseOf(pose);
  for (std::size_t k = 0; k < landmark_ids.size(); ++k)
    map.landmarks[static_cast<std::size_t>(landmark_ids[k])].inverse_depth = lambdas[k];
  removeOutliers(map, landmark_ids, threshold);
}

}  // namespace cf
