// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/pair_observation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "cf/base/median.h"
#include "cf/geometry/homography.h"
#include "cf/geometry/triangulation.h"
#include "cf/geometry/two_view.h"
#include "epipolar_refinement.h"
#include "plane_of_depths.h"

namespace cf {
namespace {

constexpr double kDegree = M_PI / 180;
/// Depths of one photo share errors that their spread does not show.
constexpr double kDepthFloor = 0.003;
/// Part of a standard deviation by which a camera is changed to see what follows.
constexpr double kStep = 0.1;

using Points = std::vector<Eigen::Vector2d>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct Matched {
  Points a, b;
  std::vector<double> depth_a, depth_b;  ///< metres by the segment's scale; 0 = unknown
};

double depthOf(const PairView& view, int feature) {
  const auto i = static_cast<std::size_t>(feature);
  const std::vector<float>& inverse = view.keyframe->inverse_depth;
  return i < inverse.size() && inverse[i] > 0 ? view.scale / static_cast<double>(inverse[i]) : 0;
}

Eigen::Vector2d pointOf(const PairView& view, const CameraModel& camera, int feature) {
  const auto& pixel = view.keyframe->features->pixel[static_cast<std::size_t>(feature)];
  return camera.undistort(pixel.cast<double>());
}

Matched gather(const PairView& a, const PairView& b, const std::vector<FeatureMatch>& matches) {
  Matched m;
  for (const FeatureMatch& match : matches) {
    m.a.push_back(pointOf(a, a.keyframe->camera, match.a));
    m.b.push_back(pointOf(b, b.keyframe->camera, match.b));
    m.depth_a.push_back(depthOf(a, match.a));
    m.depth_b.push_back(depthOf(b, match.b));
  }
  return m;
}

/// Pose of b in a up to the length of its translation.
struct Observed {
  PairModel model = PairModel::kHomography;
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< translation in units of its model
  std::vector<char> inlier;
  int inliers = 0;
  double sigma = 0;                          ///< of one match, normalized plane
  double across_sigma = 0, along_sigma = 0;  ///< of the translation, in the same units
  Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();  ///< axes of b
  std::vector<double> depth_a, depth_b;  ///< per match, in the same units; 0 = none
};

PlanePrior priorOf(const PairView& a, const PairView& b, const Matched& m, double sigma_rad) {
  PlanePrior prior;
  prior.normal_a = normalOfDepths(m.a, m.depth_a);
  prior.normal_sigma_rad = 0.15;
  if (!prior.normal_a && a.trusted) {
    prior.normal_a = a.T_world_cam.linear().transpose() * -Eigen::Vector3d::UnitZ();
    prior.normal_sigma_rad = std::hypot(0.15, sigma_rad);
  }
  if (a.trusted && b.trusted) {
    prior.R_a_b = predictRelativePose(a.T_world_cam, b.T_world_cam).linear();
    prior.rotation_sigma_rad = std::sqrt(2.0) * sigma_rad;
  }
  return prior;
}

/// Two decompositions that the prior cannot tell apart, and that do not agree either.
bool ambiguous(const PlanarPose& pose) {
  for (const PlaneMotion& rival : pose.alternatives) {
    const Eigen::AngleAxisd apart(
        Eigen::Matrix3d(rival.T_a_b.linear().transpose() * pose.motion.T_a_b.linear()));
    if (apart.angle() > 1 * kDegree && rival.prior_cost < pose.motion.prior_cost + 4) return true;
  }
  return false;
}

Observed byHomography(const PlanarPose& pose, const Matched& m) {
  Observed o;
  o.T_a_b = pose.motion.T_a_b;
  o.inlier = pose.inlier;
  o.inliers = pose.inliers;
  o.sigma = pose.sigma;
  const Eigen::Vector3d c = o.T_a_b.translation();
  const Eigen::Vector3d u =
      c.norm() > 0 ? c.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  const Eigen::Matrix3d covariance = pose.covariance.topLeftCorner<3, 3>();
  const double along = u.dot(covariance * u);
  o.along_sigma = std::sqrt(along);
  o.across_sigma = std::sqrt((covariance.trace() - along) / 2);
  o.rotation_covariance = pose.covariance.block<3, 3>(3, 3);
  // The plane n.p = 1 gives each point its depth, in a and in b.
  const Eigen::Vector3d n_b = o.T_a_b.linear().transpose() * pose.motion.normal_a;
  const double d_b = 1 - pose.motion.normal_a.dot(c);
  for (std::size_t i = 0; i < m.a.size(); ++i) {
    o.depth_a.push_back(1 / pose.motion.normal_a.dot(m.a[i].homogeneous()));
    o.depth_b.push_back(d_b / n_b.dot(m.b[i].homogeneous()));
  }
  return o;
}

Observed byEssential(const TwoView& view, const Matched& m) {
  Observed o;
  o.model = PairModel::kEssential;
  const EpipolarPose pose = refineEpipolar(view.T_a_b, m.a, m.b, view.inlier);
  o.T_a_b = pose.T_a_b;
  o.inlier = view.inlier;
  o.inliers = view.inliers;
  o.sigma = pose.sigma;
  o.across_sigma = std::sqrt(pose.covariance.diagonal().head<2>().mean());
  o.rotation_covariance = pose.covariance.bottomRightCorner<3, 3>();
  o.depth_a.assign(m.a.size(), 0);
  o.depth_b.assign(m.a.size(), 0);
  const Eigen::Isometry3d T_b_a = pose.T_a_b.inverse();
  for (std::size_t i = 0; i < m.a.size(); ++i) {
    if (!o.inlier[i]) continue;
    const auto point = triangulate({{Eigen::Isometry3d::Identity(), m.a[i]}, {pose.T_a_b, m.b[i]}});
    if (!point) continue;
    o.depth_a[i] = point->position.z();
    o.depth_b[i] = (T_b_a * point->position).z();
  }
  return o;
}

/// Whether the homography explains what an essential matrix would. Counting the essential matrix's
/// inliers costs far more than the homography (50 ms against 1), so only where it is in doubt.
bool isPlanar(const Result<PlanarPose>& planar, const Matched& m, const PairOptions& options) {
  if (!planar) return false;
  if (2 * planar->inliers >= static_cast<int>(m.a.size())) return true;
  const std::vector<char> consistent = consistentMatches(m.a, m.b, options.threshold);
  const auto epipolar = std::count(consistent.begin(), consistent.end(), 1);
  return planar->inliers >= options.planar_share * static_cast<double>(epipolar);
}

/// Lens, principal point and rolling shutter move neighbouring features alike, so they do not
/// average out with the number of matches but with that of their independent modes over a photo.
void inflate(Observed& o, double systematic) {
  constexpr double kModes = 10;
  const double ratio = systematic / o.sigma;
  const double factor = 1 + o.inliers / kModes * ratio * ratio;
  o.rotation_covariance *= factor;
  o.across_sigma *= std::sqrt(factor);
  o.along_sigma *= std::sqrt(factor);
}

/// Metres per unit of the observed translation: median of known over observed depths.
DepthLength lengthBy(const std::vector<double>& known, const std::vector<double>& observed,
                     const Observed& o) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (o.inlier[i] && known[i] > 0 && observed[i] > 0) ratios.push_back(known[i] / observed[i]);
  }
  if (static_cast<int>(ratios.size()) < kMinDepths) return {};
  const double unit_m = upperMedian(ratios);
  const auto count = static_cast<double>(ratios.size());
  for (double& r : ratios) r = std::abs(r - unit_m);
  // Sigma of a median from the median absolute deviation.
  const double unit_sigma_m = std::hypot(
      1.2533 * 1.4826 * upperMedian(std::move(ratios)) / std::sqrt(count), kDepthFloor * unit_m);
  const double units = o.T_a_b.translation().norm();
  return {units * unit_m, std::hypot(o.along_sigma * unit_m, units * unit_sigma_m)};
}

/// A standard deviation of each parameter that the cameras are not sure of, as changed cameras. Of
/// two photos that were given the same camera the same parameter is wrong.
std::vector<std::pair<CameraModel, CameraModel>> cameraErrors(const CameraModel& a,
                                                              const CameraModel& b) {
  constexpr double CameraModel::*kSigmas[] = {&CameraModel::focal_sigma, &CameraModel::k1_sigma,
                                              &CameraModel::k2_sigma};
  const auto off = [&](CameraModel camera, int k) {
    const double error = kStep * camera.*kSigmas[k];
    if (k == 0) camera.fy *= (camera.fx + error) / camera.fx;
    (k == 0 ? camera.fx : k == 1 ? camera.k1 : camera.k2) += error;
    return camera;
  };
  const bool same = a.fx == b.fx && a.fy == b.fy && a.k1 == b.k1 && a.k2 == b.k2;
  std::vector<std::pair<CameraModel, CameraModel>> cameras;
  for (int k = 0; k < 3; ++k) {
    if (same && a.*kSigmas[k] > 0) {
      cameras.emplace_back(off(a, k), off(b, k));
      continue;
    }
    if (a.*kSigmas[k] > 0) cameras.emplace_back(off(a, k), b);
    if (b.*kSigmas[k] > 0) cameras.emplace_back(a, off(b, k));
  }
  return cameras;
}

double square(double x) { return x * x; }

/// Weighted mean of both photos' lengths, the sigma of their scales included. A scale that is not
/// in metres counts only where there is no other.
DepthLength mergeLengths(const PairView& a, const DepthLength& by_a, const PairView& b,
                         const DepthLength& by_b) {
  const auto whole = [](const PairView& view, DepthLength length) {
    length.sigma_m = std::hypot(length.sigma_m, length.length_m * view.scale_sigma / view.scale);
    return length;
  };
  if (by_b.sigma_m <= 0 || (by_a.sigma_m > 0 && !b.trusted)) return whole(a, by_a);
  if (by_a.sigma_m <= 0 || !a.trusted) return whole(b, by_b);
  const DepthLength la = whole(a, by_a), lb = whole(b, by_b);
  const double wa = 1 / square(la.sigma_m), wb = 1 / square(lb.sigma_m);
  return {(wa * la.length_m + wb * lb.length_m) / (wa + wb), 1 / std::sqrt(wa + wb)};
}

using Again = std::function<Observed(const Matched&)>;

/// By the model that holds, with how to observe again from points that lie a little elsewhere.
Result<std::pair<Observed, Again>> observed(const PairView& a, const PairView& b, const Matched& m,
                                            const PairOptions& options) {
  const PlanePrior prior = priorOf(a, b, m, options.prior_sigma_deg * kDegree);
  const auto planar = estimatePlanarPose(m.a, m.b, prior, {options.threshold, options.min_inliers});
  if (isPlanar(planar, m, options)) {
    if (ambiguous(*planar))
      return Failure{"ambiguous",
                     "two planes explain the photos and neither depths nor attitudes tell which"};
    return std::pair<Observed, Again>(
        byHomography(*planar, m), [start = *planar, prior](const Matched& changed) {
          PlanarPose pose = start;
          pose.motion =
              refinePlaneMotion(changed.a, changed.b, pose.inlier, pose.sigma, pose.motion, prior);
          return byHomography(pose, changed);
        });
  }
  TwoViewOptions two_view;
  two_view.threshold = options.threshold;
  two_view.min_inliers = options.min_inliers;
  const auto view = estimateTwoView(m.a, m.b, two_view);
  if (!view) return view.failure();
  return std::pair<Observed, Again>(byEssential(*view, m), [start = *view](const Matched& changed) {
    return byEssential(start, changed);
  });
}

/// What the cameras' uncertainty adds to the covariance of the pose, to first order: the matches
/// seen through changed cameras give another pose.
Matrix6d cameraCovariance(const PairView& a, const PairView& b,
                          const std::vector<FeatureMatch>& matches, const Matched& m,
                          const Eigen::Isometry3d& T_a_b, const PairObservation& observation,
                          const Again& again) {
  Matrix6d covariance = Matrix6d::Zero();
  for (const auto& [camera_a, camera_b] : cameraErrors(a.keyframe->camera, b.keyframe->camera)) {
    Matched changed = m;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      changed.a[i] = pointOf(a, camera_a, matches[i].a);
      changed.b[i] = pointOf(b, camera_b, matches[i].b);
    }
    const Observed o = again(changed);
    DepthLength by_a = lengthBy(m.depth_a, o.depth_a, o), by_b = lengthBy(m.depth_b, o.depth_b, o);
    // Weighed as they were.
    by_a.sigma_m = observation.by_depth_a.sigma_m;
    by_b.sigma_m = observation.by_depth_b.sigma_m;
    const DepthLength merged = mergeLengths(a, by_a, b, by_b);
    const double length_m = merged.sigma_m > 0 ? merged.length_m : observation.gnss_length_m;
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(o.T_a_b.linear() * T_a_b.linear().transpose()));
    Eigen::Matrix<double, 6, 1> change;
    change << length_m * o.T_a_b.translation().normalized() - T_a_b.translation(),
        turn.angle() * turn.axis();
    covariance += change * change.transpose() / (kStep * kStep);
  }
  return covariance;
}

}  // namespace

void PairOptions::visit(OptionVisitor& v) {
  v.number("pair_threshold", threshold, {1e-5, 0.05},
           "inlier distance of a match between two UAVs, pixels over focal length");
  v.integer("pair_min_inliers", min_inliers, {8, 10000}, "inliers that a relative pose needs");
  v.number("pair_min_share", min_share, {0, 1}, "share of the matches that must be inliers");
  v.number("pair_planar_share", planar_share, {0, 1},
           "a homography with this part of the essential matrix's inliers is preferred to it");
  v.number("pair_max_rotation_deg", max_rotation_deg, {0.1, 180},
           "largest angle between a relative pose and the georeferenced attitudes [deg]");
  v.number("pair_prior_sigma_deg", prior_sigma_deg, {0.1, 90},
           "standard deviation of a georeferenced attitude [deg]");
  v.number(
      "pair_systematic", systematic, {0, 0.01},
      "error that neighbouring matches share (lens, rolling shutter), pixels over focal length");
}

const char* name(PairModel model) {
  return model == PairModel::kHomography ? "homography" : "essential";
}

Eigen::Isometry3d predictRelativePose(const Eigen::Isometry3d& T_world_a,
                                      const Eigen::Isometry3d& T_world_b) {
  return T_world_a.inverse() * T_world_b;
}

Result<PairObservation> observePair(const PairView& a, const PairView& b,
                                    const std::vector<FeatureMatch>& matches,
                                    const PairOptions& options) {
  const std::string total = std::to_string(matches.size()) + " matches";
  if (static_cast<int>(matches.size()) < options.min_inliers) {
    return Failure{"few_matches", total + ", " + std::to_string(options.min_inliers) + " needed"};
  }
  const Matched m = gather(a, b, matches);
  auto observation = observed(a, b, m, options);
  if (!observation) return observation.failure();
  auto& [o, again] = observation.value();
  if (o.inliers < options.min_share * static_cast<double>(matches.size())) {
    return Failure{"low_share", std::to_string(o.inliers) + " inliers of " + total};
  }

  inflate(o, options.systematic);

  PairObservation result;
  result.model = o.model;
  result.segment_a = a.keyframe->segment;
  result.segment_b = b.keyframe->segment;
  const Eigen::Isometry3d predicted = predictRelativePose(a.T_world_cam, b.T_world_cam);
  if (a.trusted && b.trusted) {
    const Eigen::AngleAxisd apart(
        Eigen::Matrix3d(predicted.linear().transpose() * o.T_a_b.linear()));
    if (apart.angle() > options.max_rotation_deg * kDegree) {
      return Failure{"against_prior", std::to_string(apart.angle() / kDegree) +
                                          " degrees from the georeferenced attitudes"};
    }
    // Equation (8): the homography's translation takes the length of the GNSS displacement.
    result.gnss_length_m = predicted.translation().norm();
  }

  result.by_depth_a = lengthBy(m.depth_a, o.depth_a, o);
  result.by_depth_b = lengthBy(m.depth_b, o.depth_b, o);
  const DepthLength merged = mergeLengths(a, result.by_depth_a, b, result.by_depth_b);
  if (merged.sigma_m <= 0 && result.gnss_length_m <= 0) {
    return Failure{"no_length", "neither photo has depths, and there is no georeference"};
  }
  const double length_m = merged.sigma_m > 0 ? merged.length_m : result.gnss_length_m;
  const double along_sigma_m = merged.sigma_m > 0 ? merged.sigma_m : 0.5 * length_m;
  const double units = o.T_a_b.translation().norm();
  if (units > 0) result.direction_a = o.T_a_b.translation() / units;
  const Eigen::Vector3d& u = result.direction_a;
  const double across_sigma_m = o.across_sigma * (units > 0 ? length_m / units : 1);
  const Eigen::Matrix3d along = u * u.transpose();

  RelativePose& pose = result.pose;
  pose.a = a.keyframe->id;
  pose.b = b.keyframe->id;
  pose.inliers = o.inliers;
  pose.T_a_b = o.T_a_b;
  pose.T_a_b.translation() = length_m * u;

  Matrix6d covariance = Matrix6d::Zero();  // of translation [m] and rotation [rad], axes of a
  covariance.topLeftCorner<3, 3>() = square(along_sigma_m) * along +
                                     square(across_sigma_m) * (Eigen::Matrix3d::Identity() - along);
  covariance.bottomRightCorner<3, 3>() =
      o.T_a_b.linear() * o.rotation_covariance * o.T_a_b.linear().transpose();
  const Matrix6d by_camera = cameraCovariance(a, b, matches, m, pose.T_a_b, result, again);
  covariance += by_camera;
  pose.sigma = covariance.diagonal().cwiseSqrt();
  const double camera_along = u.dot(by_camera.topLeftCorner<3, 3>() * u);
  result.across_sigma_m = std::sqrt(square(across_sigma_m) +
                                    (by_camera.topLeftCorner<3, 3>().trace() - camera_along) / 2);
  result.rotation_sigma_rad = std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3);
  for (DepthLength* length : {&result.by_depth_a, &result.by_depth_b})
    if (length->sigma_m > 0) length->sigma_m = std::hypot(length->sigma_m, std::sqrt(camera_along));
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (o.inlier[i]) result.inliers.push_back(matches[i]);
  }
  return result;
}

}  // namespace cf
