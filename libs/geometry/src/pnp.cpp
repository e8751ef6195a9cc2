// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/pnp.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <string>

#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

Eigen::Isometry3d poseOf(const cv::Mat& rvec, const cv::Mat& tvec) {
  cv::Mat R;
  cv::Rodrigues(rvec, R);
  Eigen::Isometry3d T_cam_world = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) T_cam_world.linear()(r, c) = R.at<double>(r, c);
    T_cam_world.translation()(r) = tvec.at<double>(r);
  }
  return T_cam_world.inverse();
}

}  // namespace

Result<ResectedPose> resect(const std::vector<Eigen::Vector3d>& p_world,
                            const std::vector<Eigen::Vector2d>& normalized,
                            const PnpOptions& options) {
  const auto too_few = [&](int inliers) {
    return Failure{"too_few_inliers", std::to_string(inliers) + " inliers of " +
                                          std::to_string(p_world.size()) + " points, " +
                                          std::to_string(options.min_inliers) + " needed"};
  };
  if (static_cast<int>(p_world.size()) < std::max(4, options.min_inliers)) return too_few(0);
  // Centred points keep the solver's numbers small wherever the world's origin is.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& p : p_world) centre += p / static_cast<double>(p_world.size());
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> images;
  for (std::size_t i = 0; i < p_world.size(); ++i) {
    const Eigen::Vector3d p = p_world[i] - centre;
    objects.emplace_back(p.x(), p.y(), p.z());
    images.emplace_back(normalized[i].x(), normalized[i].y());
  }
  const cv::Mat K = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat rvec, tvec;
  std::vector<int> ransac_inliers;
  if (!cv::solvePnPRansac(objects, images, K, cv::noArray(), rvec, tvec, false, 1000,
                          static_cast<float>(options.threshold), 0.9999, ransac_inliers,
                          cv::SOLVEPNP_AP3P))
    return too_few(0);

  ResectedPose out;
  out.inlier.assign(p_world.size(), 0);
  for (const int i : ransac_inliers) out.inlier[static_cast<std::size_t>(i)] = 1;
  out.inliers = static_cast<int>(ransac_inliers.size());
  for (int round = 0; round < 3; ++round) {
    if (out.inliers < options.min_inliers) return too_few(out.inliers);
    std::vector<cv::Point3d> kept_objects;
    std::vector<cv::Point2d> kept_images;
    for (std::size_t i = 0; i < objects.size(); ++i)
      if (out.inlier[i]) {
        kept_objects.push_back(objects[i]);
        kept_images.push_back(images[i]);
      }
    // The pose that comes with RANSAC's inliers is EPnP's, which fails on level ground: from the
    // inliers anew, by a solver that is at home on planes as well.
    if (round == 0)
      cv::solvePnP(kept_objects, kept_images, K, cv::noArray(), rvec, tvec, false,
                   cv::SOLVEPNP_SQPNP);
    else
      cv::solvePnPRefineLM(kept_objects, kept_images, K, cv::noArray(), rvec, tvec);
    out.T_world_cam = poseOf(rvec, tvec);
    out.T_world_cam.pretranslate(centre);
    out.inliers = 0;
    for (std::size_t i = 0; i < p_world.size(); ++i) {
      out.inlier[i] =
          reprojectionError({out.T_world_cam, normalized[i]}, p_world[i]) < options.threshold;
      out.inliers += out.inlier[i];
    }
  }
  if (out.inliers < options.min_inliers) return too_few(out.inliers);
  return out;
}

}  // namespace cf
