// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/aligner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "cf/geometry/similarity.h"
#include "support/simulated_flight.h"

namespace cf {
namespace {

using support::FlightSimulator;
using support::LawnMower;
using support::quantile;
using support::rotationErrorDeg;
using support::Simulation;
using support::SimulationOptions;

SimulationOptions sparse() {
  SimulationOptions options;
  options.point_spacing_m = 3.5;
  return options;
}

/// Three UAVs over one area, each with its own direction, height, receiver and odometry segments.
std::vector<LawnMower> threeUavs() {
  LawnMower a, b, c;
  a.lines = b.lines = c.lines = 2;
  a.per_line = b.per_line = c.per_line = 6;
  a.cuts = {8};
  b.heading_deg = 90;
  b.start_m = {65, -5};
  b.height_m = 80;
  b.gnss_bias_m = {2, -2, 8};
  b.cuts = {5, 6};
  c.heading_deg = 20;
  c.start_m = {20, 0};
  c.gnss_bias_m = {-3, 1, -8};
  return {a, b, c};
}

Alignment align(const Simulation& flight, std::uint16_t center) {
  Aligner aligner({}, center);
  for (const GeoKeyframe& keyframe : flight.keyframes) aligner.push(keyframe);
  return aligner.solve(flight.segments, flight.quality, flight.cameras);
}

TEST(Aligner, ThreeUavsWithBiasesBecomeOneMap) {
  SimulationOptions options = sparse();
  options.wrong_features = 0.2;
  options.true_camera.k1 = -0.02;
  options.given_camera.fx = options.given_camera.fy = 3030;
  options.given_camera.focal_sigma = 100;
  options.given_camera.k1_sigma = options.given_camera.k2_sigma = 0.05;
  const auto plans = threeUavs();
  const Simulation flight = FlightSimulator(options, 1).fly(plans);
  const Alignment result = align(flight, 0);

  ASSERT_EQ(result.table.poses.size(), 36u);
  EXPECT_EQ(result.components, 1);
  EXPECT_FALSE(result.relative);
  EXPECT_GT(result.reprojection_rms_px, 0.35);
  EXPECT_LT(result.reprojection_rms_px, 0.8);
  std::vector<Eigen::Vector3d> truth, placed;
  for (const auto& [id, entry] : result.table.poses) {
    EXPECT_EQ(entry.component, 0);
    truth.push_back(flight.T_world_cam.at(id).translation());
    placed.push_back(entry.T_world_cam.translation());
  }
  const auto S = alignPoints(truth, placed, AlignmentModel::kSim3);
  ASSERT_TRUE(S.ok());
  double squared = 0, worst_rotation = 0, worst_depth = 0;
  std::map<std::uint16_t, Eigen::Vector3d> mean;
  for (std::size_t i = 0; i < truth.size(); ++i)
    squared += (*S * placed[i] - truth[i]).squaredNorm() / static_cast<double>(truth.size());
  const Eigen::Isometry3d& T_first = result.table.poses.at({0, 0}).T_world_cam;
  for (const auto& [id, entry] : result.table.poses) {
    const Eigen::Isometry3d relative = T_first.inverse() * entry.T_world_cam;
    const Eigen::Isometry3d expected =
        flight.T_world_cam.at({0, 0}).inverse() * flight.T_world_cam.at(id);
    worst_rotation = std::max(worst_rotation, rotationErrorDeg(relative, expected));
    mean.try_emplace(id.uav, Eigen::Vector3d::Zero()).first->second +=
        (*S * entry.T_world_cam.translation() - flight.T_world_cam.at(id).translation()) / 12;
    const double height = flight.T_world_cam.at(id).translation().z();
    worst_depth = std::max(worst_depth, std::abs(entry.median_depth_m - height));
    EXPECT_LT(entry.near_depth_m, entry.median_depth_m);
    EXPECT_GT(entry.far_depth_m, entry.median_depth_m);
  }
  const std::string figures = "ATE " + std::to_string(std::sqrt(squared)) + " m, rotation " +
                              std::to_string(worst_rotation) + " deg, scale " +
                              std::to_string(S->scale) + ", depth " + std::to_string(worst_depth) +
                              " m, focal " + std::to_string(result.table.cameras[0].fx) + ", k1 " +
                              std::to_string(result.table.cameras[0].k1);
  RecordProperty("figures", figures);
  EXPECT_LT(std::sqrt(squared), 0.15) << figures;
  EXPECT_LT(worst_rotation, 0.35) << figures;
  EXPECT_NEAR(S->scale, 1, 0.01) << figures;
  EXPECT_LT(worst_depth, 8) << figures;
  // The UAVs agree to less than two of the 8 cm that a pixel searched is wide on the ground.
  for (const auto& [uav, offset] : mean) EXPECT_LT(offset.norm(), 0.14) << uav;
  for (const std::uint16_t uav : {1, 2}) {
    const Eigen::Vector3d bias = result.gnss_bias_m.at(uav) - result.gnss_bias_m.at(0);
    EXPECT_LT((bias - plans[uav].gnss_bias_m).norm(), 0.8) << bias.transpose();
  }
  for (const CameraModel& camera : result.table.cameras) {
    EXPECT_NEAR(camera.fx, 3000, 12);
    EXPECT_NEAR(camera.k1, -0.02, 0.004);
    EXPECT_EQ(camera.version, 1u);
  }

  std::set<std::pair<int, int>> uavs;
  std::vector<double> direction, before, after;
  for (const RelativePose& r : result.relative_poses) {
    EXPECT_LT(r.a.uav, r.b.uav);
    uavs.emplace(r.a.uav, r.b.uav);
    before.push_back(r.residual_before);
    after.push_back(r.residual_after);
  }
  EXPECT_EQ(uavs.size(), 3u);
  ASSERT_GT(before.size(), 20u);
  EXPECT_GT(quantile(before, 0.5), 5);
  EXPECT_LT(quantile(after, 0.5), 0.3 * quantile(before, 0.5));
}

TEST(Aligner, SolvesAgainWithMorePhotosAsIfAllHadComeAtOnce) {
  const Simulation flight = FlightSimulator(sparse(), 2).fly([] {
    auto plans = threeUavs();
    plans.resize(2);
    for (LawnMower& plan : plans) plan.per_line = 5;
    return plans;
  }());
  Aligner aligner({}, 0);
  for (std::size_t i = 0; i < 9; ++i) aligner.push(flight.keyframes[i]);
  auto first = flight.segments;
  first.resize(2);
  for (GeoSegment& s : first)
    s.poses.erase(std::remove_if(s.poses.begin(), s.poses.end(),
                                 [](const auto& p) { return p.frame.index >= 9; }),
                  s.poses.end());
  const Alignment early = aligner.solve(first, flight.quality, flight.cameras);
  EXPECT_EQ(early.table.version, 1u);
  EXPECT_EQ(early.table.poses.size(), 9u);
  for (std::size_t i = 9; i < flight.keyframes.size(); ++i) aligner.push(flight.keyframes[i]);
  const Alignment late = aligner.solve(flight.segments, flight.quality, flight.cameras);
  EXPECT_EQ(late.table.version, 2u);
  ASSERT_EQ(late.table.poses.size(), 20u);
  const Alignment at_once = align(flight, 0);
  for (const auto& [id, entry] : at_once.table.poses)
    EXPECT_LT((entry.T_world_cam.translation() - late.table.poses.at(id).T_world_cam.translation())
                  .norm(),
              0.05);
}

/// Keyframes of all UAVs by turns, as they come in flight.
std::vector<GeoKeyframe> byTurns(const Simulation& flight) {
  std::vector<GeoKeyframe> order = flight.keyframes;
  std::stable_sort(order.begin(), order.end(), [](const GeoKeyframe& a, const GeoKeyframe& b) {
    return a.keyframe->id.index < b.keyframe->id.index;
  });
  return order;
}

/// What the UAVs know when the photos `known` have come.
std::vector<GeoSegment> segmentsOf(const Simulation& flight, const std::set<FrameId>& known) {
  std::vector<GeoSegment> segments;
  for (GeoSegment segment : flight.segments) {
    auto& poses = segment.poses;
    poses.erase(std::remove_if(poses.begin(), poses.end(),
                               [&](const auto& p) { return known.count(p.frame) == 0; }),
                poses.end());
    if (!poses.empty()) segments.push_back(segment);
  }
  return segments;
}

/// RMS error of the camera centres after one similarity.
double shapeError(const Simulation& flight, const PoseTable& table) {
  std::vector<Eigen::Vector3d> truth, placed;
  for (const auto& [id, entry] : table.poses) {
    truth.push_back(flight.T_world_cam.at(id).translation());
    placed.push_back(entry.T_world_cam.translation());
  }
  const auto S = alignPoints(truth, placed, AlignmentModel::kSim3);
  double squared = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    squared += (*S * placed[i] - truth[i]).squaredNorm();
  return std::sqrt(squared / static_cast<double>(truth.size()));
}

TEST(Aligner, TheMapGrowsByWindowsAndDrafts) {
  auto plans = threeUavs();
  for (LawnMower& plan : plans) {
    plan.per_line = 12;
    plan.cuts = {};
  }
  const Simulation flight = FlightSimulator(sparse(), 6).fly(plans);
  AlignOptions options;
  options.growth = 2;
  Aligner aligner(options, 0);
  constexpr std::size_t kEvery = 6;
  std::set<FrameId> known;
  PoseTable before;
  std::size_t solved = 0;
  bool under_way = false;
  double worst_error = 0;
  for (const GeoKeyframe& keyframe : byTurns(flight)) {
    aligner.push(keyframe);
    known.insert(keyframe.keyframe->id);
    if (known.size() % kEvery != 0) continue;
    const PoseTable table =
        aligner.update(segmentsOf(flight, known), flight.quality, flight.cameras);
    EXPECT_EQ(table.version, before.version + 1);
    EXPECT_EQ(table.poses.size(), known.size());
    // The first draft is waited for, the others take effect at the update after.
    const bool started = known.size() >= 2 * solved;
    const bool draft = started ? solved == 0 : under_way;
    under_way = started && solved > 0;
    if (started) solved = known.size();
    std::size_t moved = 0;
    for (const auto& [id, entry] : before.poses)
      moved += (entry.T_world_cam.matrix() != table.poses.at(id).T_world_cam.matrix()) ? 1 : 0;
    // A window is of bounded size, whatever the size of the map.
    if (!draft) {
      EXPECT_GT(moved, 0u);
      EXPECT_LE(moved, 2 * kEvery);
    }
    worst_error = std::max(worst_error, shapeError(flight, table));
    const auto S_world_local = aligner.similarity(keyframe.keyframe->id, 0);
    ASSERT_TRUE(S_world_local);
    EXPECT_LT((S_world_local->carry(keyframe.keyframe->T_local_cam).translation() -
               table.poses.at(keyframe.keyframe->id).T_world_cam.translation())
                  .norm(),
              1e-9);
    before = table;
  }
  RecordProperty("worst_error_m", std::to_string(worst_error));
  EXPECT_LT(worst_error, 0.3);
  const Alignment last = aligner.solve(flight.segments, flight.quality, flight.cameras);
  const Alignment at_once = align(flight, 0);
  for (const auto& [id, entry] : at_once.table.poses)
    EXPECT_LT((entry.T_world_cam.translation() - last.table.poses.at(id).T_world_cam.translation())
                  .norm(),
              0.05);
}

TEST(Aligner, ASegmentThatNothingCarriesOnWaitsForTheNextDraft) {
  auto plans = threeUavs();
  plans.resize(2);
  plans[0].cuts = {7};
  plans[1].cuts = {};
  const Simulation flight = FlightSimulator(sparse(), 7).fly(plans);
  AlignOptions options;
  options.growth = 2;
  Aligner aligner(options, 0);
  std::set<FrameId> known;
  const std::vector<GeoKeyframe> order = byTurns(flight);
  PoseTable table;
  for (const GeoKeyframe& keyframe : order) {
    aligner.push(keyframe);
    known.insert(keyframe.keyframe->id);
    if (known.size() % 6 == 0)
      table = aligner.update(segmentsOf(flight, known), flight.quality, flight.cameras);
    // Drafts of 6, 12 and 24 photos; the new segment begins with photo 7 of the first UAV.
    if (known.size() == 18) {
      EXPECT_EQ(table.poses.count({0, 6}), 1u);
      EXPECT_EQ(table.poses.count({0, 7}), 0u);
      EXPECT_EQ(table.poses.count({1, 8}), 1u);
      EXPECT_FALSE(aligner.similarity({0, 8}, 1));
    }
  }
  EXPECT_EQ(table.poses.count({0, 7}), 0u);  // the draft is under way
  table = aligner.update(segmentsOf(flight, known), flight.quality, flight.cameras);
  EXPECT_EQ(table.poses.size(), 24u);
  EXPECT_TRUE(aligner.similarity({0, 8}, 1));
}

TEST(Aligner, AUavThatComesLaterJoinsAtOnce) {
  auto plans = threeUavs();
  for (LawnMower& plan : plans) plan.cuts = {};
  const Simulation flight = FlightSimulator(sparse(), 8).fly(plans);
  AlignOptions options;
  options.growth = 100;
  Aligner aligner(options, 0);
  std::set<FrameId> known;
  PoseTable table;
  for (const GeoKeyframe& keyframe : flight.keyframes) {  // one UAV after the other
    aligner.push(keyframe);
    known.insert(keyframe.keyframe->id);
    const std::vector<GeoSegment> segments = segmentsOf(flight, known);
    EXPECT_EQ(aligner.canJoin(segments), keyframe.keyframe->id.index == 0);
    if (!aligner.canJoin(segments)) continue;
    table = aligner.update(segments, flight.quality, flight.cameras);
    EXPECT_EQ(table.poses.size(), known.size());
  }
  EXPECT_EQ(table.poses.count({2, 0}), 1u);
}

TEST(Aligner, IsDeterministic) {
  auto plans = threeUavs();
  plans.resize(2);
  const Simulation flight = FlightSimulator(sparse(), 3).fly(plans);
  const Alignment p = align(flight, 0), q = align(flight, 0);
  ASSERT_EQ(p.table.poses.size(), 24u);
  for (const auto& [id, entry] : p.table.poses)
    ASSERT_EQ(entry.T_world_cam.matrix(), q.table.poses.at(id).T_world_cam.matrix());
  ASSERT_EQ(p.relative_poses.size(), q.relative_poses.size());
  ASSERT_EQ(p.points.size(), q.points.size());
}

TEST(Aligner, UavsApartAreComponentsAndTheCentreIsTheFirst) {
  LawnMower a, b;
  a.lines = b.lines = 2;
  a.per_line = b.per_line = 5;
  b.start_m = {900, 0};
  const Simulation flight = FlightSimulator(sparse(), 4).fly({a, b});
  const Alignment result = align(flight, 1);
  ASSERT_EQ(result.table.poses.size(), 20u);
  EXPECT_EQ(result.components, 2);
  for (const auto& [id, entry] : result.table.poses) {
    EXPECT_EQ(entry.component, id.uav == 1 ? 0 : 1);
    EXPECT_LT((entry.T_world_cam.translation() - flight.T_world_cam.at(id).translation()).norm(),
              2);
  }
  EXPECT_TRUE(result.relative_poses.empty());
}

TEST(Aligner, WithoutAnyGeoreferenceTheShapeIsRight) {
  auto plans = threeUavs();
  plans.resize(2);
  for (LawnMower& plan : plans) plan.georeferenced = false;
  const Simulation flight = FlightSimulator(sparse(), 5).fly(plans);
  const Alignment result = align(flight, 0);
  EXPECT_TRUE(result.relative);
  EXPECT_EQ(result.components, 1);
  ASSERT_EQ(result.table.poses.size(), 24u);
  std::vector<Eigen::Vector3d> truth, placed;
  for (const auto& [id, entry] : result.table.poses) {
    truth.push_back(flight.T_world_cam.at(id).translation());
    placed.push_back(entry.T_world_cam.translation());
  }
  const auto S = alignPoints(truth, placed, AlignmentModel::kSim3);
  ASSERT_TRUE(S.ok());
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT((*S * placed[i] - truth[i]).norm(), 0.2);
}

}  // namespace
}  // namespace cf
