// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/graphs/CNetworkOfPoses.h>

#include <sstream>

#include "method.h"

namespace cf {
namespace {

using mrpt::graphs::CNetworkOfPoses3DInf;
using mrpt::poses::CPose3D;
using mrpt::poses::CPose3DPDFGaussianInf;

constexpr mrpt::graphs::TNodeID kWorld = 0;
constexpr double kLooseSigma = 1e3;  ///< [m, rad] where an edge says nothing

CPose3D toMrpt(const Eigen::Isometry3d& T) {
  // MRPT's order of angles is yaw, pitch, roll: about z, then the new y, then the new x.
  const Eigen::Matrix3d R = T.linear();
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const double roll = std::atan2(R(2, 1), R(2, 2));
  return CPose3D(T.translation().x(), T.translation().y(), T.translation().z(), yaw, pitch, roll);
}

/// Angle sigmas about x, y, z.
CPose3DPDFGaussianInf edge(const Eigen::Isometry3d& T, const Eigen::Vector3d& translation_sigma,
                           const Eigen::Vector3d& angle_sigma) {
  CPose3DPDFGaussianInf out(toMrpt(T));
  out.cov_inv.setZero();
  for (int k = 0; k < 3; ++k) {
    out.cov_inv(k, k) = 1 / (translation_sigma[k] * translation_sigma[k]);
    out.cov_inv(5 - k, 5 - k) = 1 / (angle_sigma[k] * angle_sigma[k]);  // yaw, pitch, roll
  }
  return out;
}

}  // namespace

std::string poseGraphText(const std::vector<Segment>& segments,
                          const std::vector<GeoSegment>& published,
                          const GeoreferenceMethod& method) {
  const Noise noise = method.weights(segments);
  CNetworkOfPoses3DInf graph;
  graph.root = kWorld;
  graph.nodes[kWorld] = CPose3D();
  const Eigen::Vector3d loose = Eigen::Vector3d::Constant(kLooseSigma);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const Segment& segment = segments[s];
    const bool georeferenced = published[s].georeferenced;
    const double scale = georeferenced ? segment.scale : 1;
    for (std::size_t i = 0; i < segment.nodes.size(); ++i) {
      const Node& node = segment.nodes[i];
      const auto id = static_cast<mrpt::graphs::TNodeID>(node.keyframe->id.index) + 1;
      const Eigen::Isometry3d& T = published[s].poses[i].T_world_cam;
      graph.nodes[id] = toMrpt(T);
      if (i > 0) {
        Increment increment = method.increment(segment, i);
        increment.T_i_j.translation() *= scale;
        const auto before =
            static_cast<mrpt::graphs::TNodeID>(segment.nodes[i - 1].keyframe->id.index) + 1;
        graph.insertEdge(
            before, id,
            edge(increment.T_i_j, Eigen::Vector3d::Constant(scale * increment.translation_sigma),
                 Eigen::Vector3d::Constant(increment.rotation_sigma_rad)));
      }
      if (!georeferenced) {
        // Its frame is free: held at its first photo.
        if (i == 0) graph.insertEdge(kWorld, id, edge(T, loose / kLooseSigma, loose / kLooseSigma));
        continue;
      }
      Eigen::Vector3d position_sigma = loose, angle_sigma = loose;
      Eigen::Isometry3d seen = T;
      if (node.fix && !node.horizontal_outlier) {
        seen.translation().head<2>() = node.fix->position_m.head<2>();
        position_sigma.head<2>() = node.fix->sigma_m.cwiseProduct(noise.weighed()).head<2>();
      }
      if (node.fix && !node.vertical_outlier) {
        seen.translation().z() = node.fix->position_m.z();
        position_sigma.z() = node.fix->sigma_m.z() * noise.weighed().z();
      }
      if (i == 0)  // the attitude as the whole segment decided it
        angle_sigma = node.covariance.diagonal().tail<3>().cwiseSqrt();
      graph.insertEdge(kWorld, id, edge(seen, position_sigma, angle_sigma));
    }
  }
  std::ostringstream text;
  graph.writeAsText(text);
  return text.str();
}

}  // namespace cf
