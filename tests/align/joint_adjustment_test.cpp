// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/joint_adjustment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "cf/geometry/similarity.h"
#include "support/simulated_flight.h"

namespace cf {
namespace {

using support::FlightSimulator;
using support::LawnMower;
using support::rotationErrorDeg;
using support::Simulation;
using support::SimulationOptions;

MatchGraph graphOf(const Simulation& simulation) {
  MatchGraph graph{MatchGraphOptions{}};
  for (const GeoKeyframe& k : simulation.keyframes) graph.add(k.keyframe);
  std::vector<MatchGraph::Pair> pairs;
  for (const auto& [a, T_a] : simulation.T_world_cam)
    for (const auto& [b, T_b] : simulation.T_world_cam)
      if (a < b && (T_a.translation() - T_b.translation()).norm() < 45) pairs.emplace_back(a, b);
  graph.match(pairs);
  return graph;
}

/// The truth, each photo disturbed by about `position_m` and `rotation_deg`.
JointProblem problemOf(const Simulation& simulation, double position_m, double rotation_deg,
                       bool with_fixes = true) {
  std::mt19937 random(11);
  std::normal_distribution<double> gauss;
  const auto normal3 = [&](double sigma) {
    const double x = sigma * gauss(random), y = sigma * gauss(random), z = sigma * gauss(random);
    return Eigen::Vector3d(x, y, z);
  };
  JointProblem problem;
  problem.cameras = simulation.cameras;
  problem.median_depth_m = 70;
  for (const GeoKeyframe& k : simulation.keyframes) {
    JointPhoto photo;
    photo.id = k.keyframe->id;
    photo.T_world_cam = simulation.T_world_cam.at(photo.id);
    photo.T_world_cam.translation() += normal3(position_m);
    const Eigen::Vector3d w = normal3(rotation_deg * support::kDegree);
    photo.T_world_cam.linear() =
        Eigen::AngleAxisd(w.norm(), w.normalized()) * photo.T_world_cam.linear();
    if (with_fixes) photo.fix = k.fix;
    problem.photos.push_back(photo);
  }
  return problem;
}

struct Errors {
  double position_m = 0, rotation_deg = 0;  ///< worst, after one similarity for all
  double scale = 0;                         ///< of it, minus 1
  std::string text() const {
    return std::to_string(position_m) + " m, " + std::to_string(rotation_deg) + " deg, scale " +
           std::to_string(scale);
  }
};

Errors errorsOf(const Simulation& truth, const JointSolution& solution) {
  std::vector<Eigen::Vector3d> a, b;
  for (const auto& [id, T] : solution.T_world_cam) {
    a.push_back(truth.T_world_cam.at(id).translation());
    b.push_back(T.translation());
  }
  const auto S = alignPoints(a, b, AlignmentModel::kSim3);
  Errors errors;
  errors.scale = S->scale - 1;
  for (const auto& [id, T] : solution.T_world_cam) {
    const Eigen::Isometry3d& T_true = truth.T_world_cam.at(id);
    const Eigen::Isometry3d placed = S->carry(T);
    errors.position_m =
        std::max(errors.position_m, (placed.translation() - T_true.translation()).norm());
    errors.rotation_deg = std::max(errors.rotation_deg, rotationErrorDeg(placed, T_true));
  }
  return errors;
}

/// Two UAVs whose strips cross: what tells focal length from height, with the relief.
std::vector<LawnMower> crossing() {
  LawnMower a, b;
  a.lines = b.lines = 3;
  a.per_line = b.per_line = 6;
  b.heading_deg = 90;
  b.start_m = {65, -5};
  b.height_m = 85;
  return {a, b};
}

TEST(AdjustJointly, PosesToCentimetres) {
  const Simulation flight = FlightSimulator({}, 1).fly(crossing());
  const MatchGraph graph = graphOf(flight);
  const JointSolution solution =
      adjustJointly(graph, buildTracks(graph), problemOf(flight, 1, 1), {});
  ASSERT_EQ(solution.T_world_cam.size(), 36u);
  const Errors errors = errorsOf(flight, solution);
  RecordProperty("errors", errors.text());
  EXPECT_LT(errors.position_m, 0.22) << errors.text();
  EXPECT_LT(errors.rotation_deg, 0.16) << errors.text();
  EXPECT_NEAR(errors.scale, 0, 0.005);
  // Half a pixel of noise per coordinate; two-sight points fit closer than that.
  EXPECT_GT(solution.reprojection_rms_px, 0.35);
  EXPECT_LT(solution.reprojection_rms_px, 0.75);

  ASSERT_GT(solution.points.size(), 1500u);
  std::vector<double> heights;
  for (const SparsePoint& p : solution.points) {
    EXPECT_GE(p.observations.size(), 2u);
    heights.push_back(std::abs(
        p.position_m.z() - SimulationOptions().terrain.height(p.position_m.x(), p.position_m.y())));
    EXPECT_EQ(p.bgr[1], 120);
  }
  RecordProperty("heights", std::to_string(support::quantile(heights, 0.5)) + " / " +
                                std::to_string(support::quantile(heights, 0.95)));
  EXPECT_LT(support::quantile(heights, 0.5), 0.7);
  EXPECT_LT(support::quantile(heights, 0.95), 1.7);
}

TEST(AdjustJointly, RecoversAWrongCamera) {
  SimulationOptions options;
  options.given_camera.fx = options.given_camera.fy = 1.02 * options.true_camera.fx;
  options.true_camera.k1 = -0.05;
  options.true_camera.k2 = 0.01;
  options.true_camera.p1 = 5e-4;
  options.true_camera.cx += 7;
  options.true_camera.cy -= 5;
  options.given_camera.focal_sigma = 0.05 * options.given_camera.fx;
  options.given_camera.k1_sigma = 0.1;
  options.given_camera.k2_sigma = 0.1;
  const Simulation flight = FlightSimulator(options, 2).fly(crossing());
  const MatchGraph graph = graphOf(flight);
  const auto tracks = buildTracks(graph);
  const JointProblem problem = problemOf(flight, 0.5, 0.5);
  const JointSolution solution = adjustJointly(graph, tracks, problem, {});
  const Errors errors = errorsOf(flight, solution);
  RecordProperty("errors", errors.text());
  RecordProperty("camera", std::to_string(solution.cameras[0].fx) + " " +
                               std::to_string(solution.cameras[0].k1) + " " +
                               std::to_string(solution.cameras[0].k2) + " " +
                               std::to_string(solution.cameras[0].p1) + " " +
                               std::to_string(solution.cameras[0].cx) + " " +
                               std::to_string(solution.cameras[0].cy));
  for (const CameraModel& camera : solution.cameras) {
    EXPECT_NEAR(camera.fx / options.true_camera.fx, 1, 0.008);
    EXPECT_EQ(camera.fx, camera.fy);
    EXPECT_NEAR(camera.k1, -0.05, 0.005);
    EXPECT_NEAR(camera.k2, 0.01, 0.01);
    EXPECT_NEAR(camera.p1, 5e-4, 2e-4);
    EXPECT_NEAR(camera.cx, options.true_camera.cx, 2.5);
    EXPECT_NEAR(camera.cy, options.true_camera.cy, 2.5);
    // Distortion and focal length trade a little: what counts is where the rays go.
    for (const double x : {-0.6, 0.0, 0.6})
      for (const double y : {-0.45, 0.0, 0.45})
        EXPECT_LT((camera.distort({x, y}) - options.true_camera.distort({x, y})).norm(), 14);
  }
  EXPECT_LT(errors.position_m, 0.25) << errors.text();
  EXPECT_LT(errors.rotation_deg, 0.2) << errors.text();

  JointOptions held;
  held.refine_cameras = false;
  const JointSolution with_held = adjustJointly(graph, tracks, problem, held);
  EXPECT_EQ(with_held.cameras[0].fx, options.given_camera.fx);
  EXPECT_EQ(with_held.cameras[0].k1, 0);
  EXPECT_GT(errorsOf(flight, with_held).position_m, 2 * errors.position_m);
}

/// UAVs that were given the same camera: one lens each, near one another, or one for both.
TEST(AdjustJointly, CamerasAreSharedWhereAsked) {
  SimulationOptions options;
  options.given_camera.fx = options.given_camera.fy = 1.01 * options.true_camera.fx;
  options.given_camera.focal_sigma = 100;
  options.given_camera.k1_sigma = options.given_camera.k2_sigma = 0.1;
  const Simulation flight = FlightSimulator(options, 9).fly(crossing());
  const MatchGraph graph = graphOf(flight);
  const auto tracks = buildTracks(graph);
  const auto cameras_of = [&](const std::string& camera) {
    JointOptions joint;
    joint.camera = camera;
    return adjustJointly(graph, tracks, problemOf(flight, 0.5, 0.5), joint).cameras;
  };
  const auto own = cameras_of("per_uav"), shared = cameras_of("shared");
  EXPECT_NE(own[0].fx, own[1].fx);
  EXPECT_EQ(shared[0].fx, shared[1].fx);
  EXPECT_EQ(shared[0].k1, shared[1].k1);
  for (const CameraModel& camera : {own[0], own[1], shared[0], shared[1]}) {
    EXPECT_NEAR(camera.fx, options.true_camera.fx, 5 * camera.focal_sigma);
    EXPECT_LT(camera.focal_sigma, 30) << "observed by the crossing strips";
    EXPECT_GT(camera.focal_sigma, 0);
    EXPECT_LT(camera.k1_sigma, 0.02);
  }
  EXPECT_LT(shared[0].focal_sigma, own[0].focal_sigma);
}

/// Normalised squared errors of poses, over flights: six of them each.
TEST(AdjustJointly, CovariancesTellTheErrors) {
  JointOptions options;  // these receivers have no bias
  options.bias_sigma_horizontal_m = options.bias_sigma_vertical_m = 0.001;
  double sum = 0, sum_in_map = 0;
  int count = 0;
  for (unsigned seed = 21; seed < 27; ++seed) {
    const Simulation flight = FlightSimulator({}, seed).fly(crossing());
    const MatchGraph graph = graphOf(flight);
    const JointSolution solution =
        adjustJointly(graph, buildTracks(graph), problemOf(flight, 0.3, 0.3), options);
    std::vector<Eigen::Vector3d> truths, estimates;
    for (const auto& [id, T] : solution.T_world_cam) {
      truths.push_back(flight.T_world_cam.at(id).translation());
      estimates.push_back(T.translation());
    }
    const auto S = alignPoints(truths, estimates, AlignmentModel::kSim3);
    ASSERT_TRUE(S);
    for (const auto& [id, T] : solution.T_world_cam) {
      const Eigen::Isometry3d& truth = flight.T_world_cam.at(id);
      const auto nees = [&](const Eigen::Isometry3d& pose,
                            const Eigen::Matrix<double, 6, 6>& covariance) {
        const Eigen::AngleAxisd turn(pose.linear() * truth.linear().transpose());
        Eigen::Matrix<double, 6, 1> error;
        error << pose.translation() - truth.translation(), turn.angle() * turn.axis();
        return error.dot(covariance.ldlt().solve(error));
      };
      const PoseCovariance& covariance = solution.covariance.at(id);
      sum += nees(T, covariance.in_world);
      sum_in_map += nees(S->carry(T), covariance.in_map);
      ++count;
    }
  }
  RecordProperty("nees", std::to_string(sum / count));
  RecordProperty("nees_in_map", std::to_string(sum_in_map / count));
  EXPECT_GT(sum / count, 3.5);
  EXPECT_LT(sum / count, 9);
  EXPECT_GT(sum_in_map / count, 3.5);
  EXPECT_LT(sum_in_map / count, 9);
}

/// A sigma of zero holds a value, all three of them the whole calibration, whatever the photos say.
TEST(AdjustJointly, WhatIsGivenWithoutSigmaStays) {
  SimulationOptions options;
  options.true_camera.k1 = -0.03;
  options.true_camera.cx += 6;
  options.given_camera.fx = options.given_camera.fy = 1.01 * options.true_camera.fx;
  const auto camera_of = [&](double focal_sigma) {
    options.given_camera.focal_sigma = focal_sigma;
    const Simulation flight = FlightSimulator(options, 7).fly(crossing());
    const MatchGraph graph = graphOf(flight);
    return adjustJointly(graph, buildTracks(graph), problemOf(flight, 0.5, 0.5), {}).cameras[1];
  };
  const CameraModel held = camera_of(0), focal_free = camera_of(100);
  for (const CameraModel& camera : {held, focal_free}) {
    EXPECT_EQ(camera.k1, 0);
    EXPECT_EQ(camera.k2, 0);
  }
  EXPECT_DOUBLE_EQ(held.fx, options.given_camera.fx);
  EXPECT_DOUBLE_EQ(held.cx, options.given_camera.cx);
  EXPECT_EQ(held.p1, 0);
  EXPECT_GT(std::abs(focal_free.fx - options.given_camera.fx), 1);
  EXPECT_NE(focal_free.cx, options.given_camera.cx);
}

/// Fixes that disagree by metres: the UAVs stay together, the biases show the difference.
TEST(AdjustJointly, GnssBiasDoesNotTearUavsApart) {
  auto plans = crossing();
  plans[0].gnss_bias_m = {1.5, 0, -4};
  plans[1].gnss_bias_m = {-1.5, 1, 4};
  const Simulation flight = FlightSimulator({}, 3).fly(plans);
  const MatchGraph graph = graphOf(flight);
  const JointSolution solution =
      adjustJointly(graph, buildTracks(graph), problemOf(flight, 1, 1), {});
  const Errors errors = errorsOf(flight, solution);
  RecordProperty("errors", errors.text());
  EXPECT_LT(errors.position_m, 0.22) << errors.text();
  EXPECT_LT(errors.rotation_deg, 0.16) << errors.text();
  const Eigen::Vector3d difference = solution.bias_m.at(0) - solution.bias_m.at(1);
  const Eigen::Vector3d expected = plans[0].gnss_bias_m - plans[1].gnss_bias_m;
  EXPECT_LT((difference - expected).norm(), 0.5) << difference.transpose();
  // The map lies between the two, as their biases are as probable.
  EXPECT_LT((solution.bias_m.at(0) + solution.bias_m.at(1)).norm(), 2.5);
}

/// Fixes of one photo that are far off do not bend the map.
TEST(AdjustJointly, AWildFixIsBorne) {
  const Simulation flight = FlightSimulator({}, 4).fly(crossing());
  const MatchGraph graph = graphOf(flight);
  JointProblem problem = problemOf(flight, 0.5, 0.5);
  problem.photos[7].fix->position_m += Eigen::Vector3d(40, -60, 100);
  const JointSolution solution = adjustJointly(graph, buildTracks(graph), problem, {});
  const Errors errors = errorsOf(flight, solution);
  EXPECT_LT(errors.position_m, 0.22) << errors.text();
  EXPECT_NEAR(errors.scale, 0, 0.005);
}

/// Without fixes the map stays where the poses given put it, with their scale.
TEST(AdjustJointly, WithoutFixesTheGivenPosesHoldTheMap) {
  const Simulation flight = FlightSimulator({}, 5).fly(crossing());
  const MatchGraph graph = graphOf(flight);
  const JointSolution solution =
      adjustJointly(graph, buildTracks(graph), problemOf(flight, 1, 0.5, false), {});
  EXPECT_TRUE(solution.bias_m.empty());
  const Errors errors = errorsOf(flight, solution);
  EXPECT_LT(errors.position_m, 0.22) << errors.text();
  EXPECT_NEAR(errors.scale, 0, 0.02);
  for (const auto& [id, T] : solution.T_world_cam)
    EXPECT_LT((T.translation() - flight.T_world_cam.at(id).translation()).norm(), 2);
}

/// A photo that is held and sees no point of the map changes nothing.
TEST(AdjustJointly, AHeldPhotoWithoutPointsIsBorne) {
  LawnMower plan;
  plan.lines = 2;
  plan.per_line = 4;
  const Simulation flight = FlightSimulator({}, 8).fly({plan});
  const MatchGraph graph = graphOf(flight);
  JointProblem problem = problemOf(flight, 0.5, 0.5);
  problem.photos.back().held = true;
  problem.photos.back().fix.reset();
  std::vector<Track> tracks = buildTracks(graph);
  for (Track& track : tracks)
    track.erase(std::remove_if(track.begin(), track.end(),
                               [&](const auto& o) { return o.frame == problem.photos.back().id; }),
                track.end());
  for (const bool draft : {true, false}) {
    problem.draft = draft;
    const JointSolution with = adjustJointly(graph, tracks, problem, {});
    JointProblem without_it = problem;
    without_it.photos.pop_back();
    const JointSolution without = adjustJointly(graph, tracks, without_it, {});
    EXPECT_TRUE(with.T_world_cam.at(problem.photos.back().id)
                    .isApprox(problem.photos.back().T_world_cam, 1e-12));
    for (const auto& [id, T] : without.T_world_cam)
      EXPECT_LT((with.T_world_cam.at(id).translation() - T.translation()).norm(), 1e-6);
  }
}

TEST(AdjustJointly, IsDeterministic) {
  LawnMower plan;
  plan.lines = 2;
  plan.per_line = 4;
  const Simulation flight = FlightSimulator({}, 6).fly({plan});
  const MatchGraph graph = graphOf(flight);
  const auto tracks = buildTracks(graph);
  const JointProblem problem = problemOf(flight, 1, 1);
  const JointSolution p = adjustJointly(graph, tracks, problem, {});
  const JointSolution q = adjustJointly(graph, tracks, problem, {});
  ASSERT_EQ(p.T_world_cam.size(), q.T_world_cam.size());
  for (const auto& [id, T] : p.T_world_cam) EXPECT_EQ(T.matrix(), q.T_world_cam.at(id).matrix());
  EXPECT_EQ(p.cameras[0].fx, q.cameras[0].fx);
  ASSERT_EQ(p.points.size(), q.points.size());
  for (std::size_t i = 0; i < p.points.size(); ++i)
    ASSERT_EQ(p.points[i].position_m, q.points[i].position_m);
}

}  // namespace
}  // namespace cf
