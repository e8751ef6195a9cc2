// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "self_calibration.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>

#include "cf/geometry/triangulation.h"
#include "local_adjustment.h"

namespace cf {
namespace {

constexpr double kNoise = 0.2;  ///< of a feature, in inlier thresholds
/// Cost with the distortion over cost without. An unknown lens halves it (k1 = -0.06: 0.45 to
/// 0.55); where a camera has corrected its photos itself, chance and what is left of the lens make
/// 0.82 to 0.99 of it, and distortions that differ from UAV to UAV.
constexpr double kFarBetter = 0.7;

using Pose = std::array<double, 6>;  ///< rotation vector and translation of T_cam_local
using Point = std::array<double, 3>;

/// A feature against its point, on the normalized plane before distortion is undone.
struct RadialError {
  Eigen::Vector2d distorted;
  const CameraModel& camera;
  double inverse_sigma;

  template <class T>
  bool operator()(const T* pose, const T* point, const T* radial, T* residual) const {
    T p[3];
    ceres::AngleAxisRotatePoint(pose, point, p);
    for (int i = 0; i < 3; ++i) p[i] += pose[3 + i];
    if (p[2] < T(1e-6)) return false;
    const T x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y;
    const T d = T(1) + r2 * (radial[0] + r2 * (radial[1] + r2 * camera.k3));
    const T xd = x * d + 2 * camera.p1 * x * y + camera.p2 * (r2 + 2.0 * x * x);
    const T yd = y * d + camera.p1 * (r2 + 2.0 * y * y) + 2 * camera.p2 * x * y;
    residual[0] = inverse_sigma * (xd - distorted.x());
    residual[1] = inverse_sigma * (yd - distorted.y());
    return true;
  }
};

/// Holds what nothing observes: the size of the segment.
struct PositionPrior {
  Eigen::Vector3d mean;
  double inverse_sigma;
  template <class T>
  bool operator()(const T* pose, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = inverse_sigma * (pose[3 + i] - mean[i]);
    return true;
  }
};

struct RadialPrior {
  double k1, k2, inverse_sigma1, inverse_sigma2;
  template <class T>
  bool operator()(const T* radial, T* residual) const {
    residual[0] = inverse_sigma1 * (radial[0] - k1);
    residual[1] = inverse_sigma2 * (radial[1] - k2);
    return true;
  }
};

/// Poses, landmarks and radial distortion of one segment.
struct Scene {
  std::vector<int> landmarks;
  std::vector<Pose> poses;    ///< by photo
  std::vector<Point> points;  ///< by landmark
  std::array<double, 2> radial{};
  double cost = 0;
};

Scene sceneOf(const LocalMap& map, const std::vector<PhotoIndex>& photos) {
  Scene scene;
  std::set<int> seen;
  for (const PhotoIndex i : photos) {
    const TrackedPhoto& photo = map.photo(i);
    for (const int id : photo.landmark)
      if (id >= 0) seen.insert(id);
    const Eigen::Isometry3d T_cam_local = photo.T_local_cam.inverse();
    const Eigen::AngleAxisd turn(T_cam_local.linear());
    const Eigen::Vector3d w = turn.angle() * turn.axis(), t = T_cam_local.translation();
    scene.poses.push_back({w.x(), w.y(), w.z(), t.x(), t.y(), t.z()});
  }
  scene.landmarks.assign(seen.begin(), seen.end());
  for (const int id : scene.landmarks) {
    const Eigen::Vector3d p = map.position(map.landmarks[static_cast<std::size_t>(id)]);
    scene.points.push_back({p.x(), p.y(), p.z()});
  }
  const CameraModel& camera = map.photo(photos.front()).frame.camera;
  scene.radial = {camera.k1, camera.k2};
  return scene;
}

/// `camera` as given; whether its radial distortion is `free`.
void adjust(const LocalMap& map, const std::vector<PhotoIndex>& photos, const CameraModel& camera,
            bool free, double sigma, Scene& scene) {
  ceres::Problem problem;
  auto* loss = new ceres::CauchyLoss(3);
  for (std::size_t k = 0; k < scene.landmarks.size(); ++k)
    for (const LandmarkObservation& o :
         map.landmarks[static_cast<std::size_t>(scene.landmarks[k])].observations) {
      const auto at = std::lower_bound(photos.begin(), photos.end(), o.photo);
      const Eigen::Vector2f& pixel =
          map.photo(o.photo).features->pixel[static_cast<std::size_t>(o.feature)];
      const Eigen::Vector2d distorted((static_cast<double>(pixel.x()) - camera.cx) / camera.fx,
                                      (static_cast<double>(pixel.y()) - camera.cy) / camera.fy);
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RadialError, 2, 6, 3, 2>(
                                   new RadialError{distorted, camera, 1 / sigma}),
                               loss,
                               scene.poses[static_cast<std::size_t>(at - photos.begin())].data(),
                               scene.points[k].data(), scene.radial.data());
    }
  const auto positionOf = [](const Pose& pose) {
    return Eigen::Vector3d(pose[3], pose[4], pose[5]);
  };
  const double extent = (positionOf(scene.poses.back()) - positionOf(scene.poses.front())).norm();
  for (Pose& pose : scene.poses)
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PositionPrior, 3, 6>(
                                 new PositionPrior{positionOf(pose), 1 / std::max(extent, 1e-6)}),
                             nullptr, pose.data());
  problem.SetParameterBlockConstant(scene.poses.front().data());
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<RadialPrior, 2, 2>(new RadialPrior{
          camera.k1, camera.k2, 1 / camera.k1_sigma, 1 / std::max(1e-6, camera.k2_sigma)}),
      nullptr, scene.radial.data());
  if (!free) problem.SetParameterBlockConstant(scene.radial.data());

  // In groups of which each lies in one array: the order does not depend on addresses.
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Point& point : scene.points) ordering->AddElementToGroup(point.data(), 0);
  for (Pose& pose : scene.poses) ordering->AddElementToGroup(pose.data(), 1);
  ordering->AddElementToGroup(scene.radial.data(), 2);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = 20;
  solver.function_tolerance = 1e-4;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  scene.cost = summary.final_cost;
}

/// Lens, poses and landmarks as the scene has them.
void apply(const Scene& scene, const CameraModel& camera, const std::vector<PhotoIndex>& photos,
           LocalMap& map) {
  for (const PhotoIndex i : photos) {
    map.photo(i).frame.camera = camera;
    map.photo(i).normalized = normalizedPoints(*map.photo(i).features, camera);
  }
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Pose& pose = scene.poses[i];
    const Eigen::Vector3d w(pose[0], pose[1], pose[2]);
    Eigen::Isometry3d T_cam_local = Eigen::Isometry3d::Identity();
    if (w.norm() > 0)
      T_cam_local.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
    T_cam_local.translation() = Eigen::Vector3d(pose[3], pose[4], pose[5]);
    map.photo(photos[i]).T_local_cam = T_cam_local.inverse();
  }
  for (std::size_t k = 0; k < scene.landmarks.size(); ++k) {
    Landmark& landmark = map.landmarks[static_cast<std::size_t>(scene.landmarks[k])];
    const Eigen::Vector3d p(scene.points[k].data());
    const double depth =
        (map.photo(landmark.observations.front().photo).T_local_cam.inverse() * p).z();
    landmark.inverse_depth = 1 / depth;
  }
}

/// How far features at the corners may be off by the sigma of k1, on the normalized plane.
double radialDoubt(const CameraModel& camera) {
  const double radius = Eigen::Vector2d(camera.width, camera.height).norm() / (2 * camera.fx);
  return camera.k1_sigma * radius * radius * radius;
}

}  // namespace

bool calibrateRadial(LocalMap& map, const std::vector<PhotoIndex>& photos, double threshold) {
  const CameraModel given = map.photo(photos.front()).frame.camera;
  const double sigma = kNoise * threshold;
  Scene without = sceneOf(map, photos);
  if (without.landmarks.empty()) return false;
  Scene with = without;
  adjust(map, photos, given, false, sigma, without);
  adjust(map, photos, given, true, sigma, with);
  if (with.cost > kFarBetter * without.cost) return false;
  const auto use = [&](const Scene& scene) {
    CameraModel camera = given;
    camera.k1 = scene.radial[0];
    camera.k2 = scene.radial[1];
    apply(scene, camera, photos, map);
    adjustLocally(map, photos, threshold);
  };
  use(with);
  // Once more with the sights that fit: what the lens as given bent away is gone.
  Scene again = sceneOf(map, photos);
  adjust(map, photos, given, true, sigma, again);
  use(again);
  return true;
}

void LensSearch::begin(const CameraModel& given, double threshold) {
  settled_ = photos_ == 0 || radialDoubt(given) < threshold;
}

CameraModel LensSearch::use(const CameraModel& given) const {
  return found_ && given == given_ ? *found_ : given;
}

void LensSearch::look(LocalMap& map, bool last, double threshold) {
  const auto all = static_cast<PhotoIndex>(map.photos.size());
  if (settled_ || all == 0 || (all < photos_ && !last)) return;
  std::vector<PhotoIndex> posed;
  bool alike = true;
  for (PhotoIndex i = 0; i < all; ++i) {
    const TrackedPhoto& photo = map.photo(i);
    if (photo.segment < 0) continue;
    posed.push_back(i);
    const TrackedPhoto& first = map.photo(posed.front());
    alike = alike && photo.segment == first.segment && photo.frame.camera == first.frame.camera;
  }
  const bool ready = alike && static_cast<int>(posed.size()) >= std::max(3, photos_ / 2);
  settled_ = ready || last || all >= 2 * photos_;
  if (!ready) return;
  given_ = map.photo(posed.front()).frame.camera;
  if (!calibrateRadial(map, posed, threshold)) return;
  found_ = map.photo(posed.front()).frame.camera;
  for (TrackedPhoto& photo : map.photos) {
    if (photo.segment >= 0 || !(photo.frame.camera == given_)) continue;
    photo.frame.camera = *found_;
    photo.normalized = normalizedPoints(*photo.features, *found_);
  }
}

}  // namespace cf
