// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "moved_map.h"

#include <map>

namespace cf {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

void moveEntry(const Sim3& S_new_old, const Matrix6& turn, PoseTable::Entry& entry) {
  entry.T_world_cam = S_new_old.carry(entry.T_world_cam);
  entry.covariance.in_world = turn * entry.covariance.in_world * turn.transpose();
  entry.covariance.in_map = turn * entry.covariance.in_map * turn.transpose();
  for (double* depth : {&entry.median_depth_m, &entry.near_depth_m, &entry.far_depth_m})
    *depth *= S_new_old.scale;
}

}  // namespace

void moveMap(const Sim3& S_new_old, Alignment& alignment) {
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = S_new_old.scale * S_new_old.rotation;
  turn.bottomRightCorner<3, 3>() = S_new_old.rotation;
  std::map<std::uint16_t, Eigen::Vector3d> moved;  // sum over the photos of a UAV
  std::map<std::uint16_t, int> photos;
  for (auto& [id, entry] : alignment.table.poses) {
    const Eigen::Vector3d before = entry.T_world_cam.translation();
    moveEntry(S_new_old, turn, entry);
    moved.try_emplace(id.uav, Eigen::Vector3d::Zero()).first->second +=
        entry.T_world_cam.translation() - before;
    ++photos[id.uav];
  }
  for (auto& [uav, bias] : alignment.gnss_bias_m)
    if (photos.count(uav) > 0) bias -= moved.at(uav) / photos.at(uav);
  for (SparsePoint& point : alignment.points) point.position_m = S_new_old * point.position_m;
  for (SeamPoint& point : alignment.seam_points) {
    point.position_m = S_new_old * point.position_m;
    point.difference_m = S_new_old.scale * (S_new_old.rotation * point.difference_m);
  }
  for (RelativePose& pose : alignment.relative_poses) {
    pose.T_a_b.translation() *= S_new_old.scale;
    pose.sigma.head<3>() *= S_new_old.scale;
    pose.residual_after *= S_new_old.scale;
  }
}

}  // namespace cf
