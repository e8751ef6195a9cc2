// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/segment_joining.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "cf/geometry/similarity.h"
#include "support/simulated_flight.h"

namespace cf {
namespace {

using support::angleDeg;
using support::FlightSimulator;
using support::LawnMower;
using support::rotationErrorDeg;
using support::Simulation;
using support::SimulationOptions;

/// All pairs of photos whose centres are nearer to each other than this.
MatchGraph graphOf(const Simulation& simulation, double reach_m = 45) {
  MatchGraph graph{MatchGraphOptions{}};
  for (const GeoKeyframe& k : simulation.keyframes) graph.add(k.keyframe);
  std::vector<MatchGraph::Pair> pairs;
  for (const auto& [a, T_a] : simulation.T_world_cam)
    for (const auto& [b, T_b] : simulation.T_world_cam)
      if (a < b && (T_a.translation() - T_b.translation()).norm() < reach_m)
        pairs.emplace_back(a, b);
  graph.match(pairs);
  return graph;
}

/// Georeferenced exactly, so that what is left is the error of joining.
SimulationOptions exactGeoreference() {
  SimulationOptions options;
  options.georeference_sigma_m = 0;
  return options;
}

LawnMower strips(std::vector<int> cuts) {
  LawnMower plan;
  plan.lines = 3;
  plan.per_line = 6;
  plan.cuts = std::move(cuts);
  return plan;
}

void setLocal(Simulation& simulation, SegmentId id) {
  for (GeoSegment& segment : simulation.segments) {
    if (!(segment.id == id)) continue;
    segment.georeferenced = false;
    segment.scale = 1;
    for (auto& pose : segment.poses) pose.T_world_cam = simulation.photo(pose.frame).T_local_cam;
  }
}

/// The things within `radius_m` of a place stand again, just alike, `offset` away: UAV `uav` sees
/// them there.
void addLookAlikes(Simulation& simulation, std::uint16_t uav, const Eigen::Vector2d& place,
                   double radius_m, const Eigen::Vector3d& offset) {
  for (GeoKeyframe& geo : simulation.keyframes) {
    if (geo.keyframe->id.uav != uav) continue;
    auto keyframe = std::make_shared<Keyframe>(*geo.keyframe);
    auto features = std::make_shared<FeatureSet>(*keyframe->features);
    const double scale = simulation.metres_per_unit.at({uav, keyframe->segment});
    const Eigen::Isometry3d T_cam_world = simulation.T_world_cam.at(keyframe->id).inverse();
    for (std::size_t i = 0; i < simulation.points.size(); ++i) {
      const Eigen::Vector3d& original = simulation.points[i];
      if ((original.head<2>() - place).norm() > radius_m) continue;
      const Eigen::Vector3d p = T_cam_world * Eigen::Vector3d(original + offset);
      const Eigen::Vector2d pixel = keyframe->camera.project(p);
      if (!keyframe->camera.contains(pixel)) continue;
      features->pixel.push_back(pixel.cast<float>());
      features->scale_px.push_back(static_cast<float>(5 * features->pixel_size));
      features->colour.insert(features->colour.end(), {10, 120, 60});
      for (const double value : support::descriptorOf(static_cast<int>(i)))
        features->descriptor.push_back(
            static_cast<std::uint8_t>(std::min(255.0, std::round(value))));
      keyframe->inverse_depth.push_back(static_cast<float>(scale / p.z()));
    }
    keyframe->features = features;
    geo.keyframe = keyframe;
  }
}

/// Photo pairs of different UAVs that match.
std::size_t pairsAcross(const MatchGraph& graph) {
  return static_cast<std::size_t>(std::count_if(
      graph.pairs().begin(), graph.pairs().end(),
      [](const auto& entry) { return entry.first.first.uav != entry.first.second.uav; }));
}

struct Errors {
  double position_m = 0, rotation_deg = 0, scale = 0;
};

Errors worstOf(const Simulation& truth, const Placement& placement) {
  Errors worst;
  for (const auto& [id, placed] : placement.photos) {
    const Eigen::Isometry3d& T = truth.T_world_cam.at(id);
    worst.position_m =
        std::max(worst.position_m, (placed.T_world_cam.translation() - T.translation()).norm());
    worst.rotation_deg = std::max(worst.rotation_deg, rotationErrorDeg(placed.T_world_cam, T));
    const Keyframe& photo = truth.photo(id);
    const double scale = truth.metres_per_unit.at({id.uav, photo.segment});
    const bool alone = std::none_of(photo.inverse_depth.begin(), photo.inverse_depth.end(),
                                    [](float d) { return d > 0; });
    if (!alone) worst.scale = std::max(worst.scale, std::abs(placed.scale / scale - 1));
  }
  return worst;
}

TEST(JoinSegments, SegmentsInFramesOfTheirOwnAreJoined) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    Simulation flight = FlightSimulator(exactGeoreference(), seed).fly({strips({5, 11})});
    setLocal(flight, {0, 0});
    setLocal(flight, {0, 2});
    const MatchGraph graph = graphOf(flight);
    const Placement placement = joinSegments(graph, flight.segments, 0);
    ASSERT_EQ(placement.photos.size(), 18u);
    EXPECT_EQ(placement.components, 1);
    EXPECT_FALSE(placement.relative);
    const Errors worst = worstOf(flight, placement);
    EXPECT_LT(worst.position_m, 0.5) << seed;
    EXPECT_LT(worst.rotation_deg, 0.3) << seed;
    EXPECT_LT(worst.scale, 0.005) << seed;
  }
}

TEST(JoinSegments, JoinsUavsAndAveragesTheirGeoreference) {
  LawnMower a = strips({}), b = strips({});
  b.height_m = 78;
  a.gnss_bias_m = {1, 0, 3};
  b.gnss_bias_m = {-1, 0, -3};
  const Simulation flight = FlightSimulator(exactGeoreference(), 1).fly({a, b});
  const Placement placement = joinSegments(graphOf(flight), flight.segments, 0);
  ASSERT_EQ(placement.photos.size(), 36u);
  EXPECT_EQ(placement.components, 1);
  const Errors worst = worstOf(flight, placement);
  EXPECT_LT(worst.position_m, 0.8);  // the biases cancel; apart they are 3.2 m each
  EXPECT_LT(worst.rotation_deg, 0.5);
}

TEST(JoinSegments, ALonerIsResected) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    const Simulation flight = FlightSimulator(exactGeoreference(), seed).fly({strips({8, 9})});
    const Placement placement = joinSegments(graphOf(flight), flight.segments, 0);
    ASSERT_EQ(placement.photos.size(), 18u);
    const PlacedPhoto& loner = placement.photos.at({0, 8});
    const Eigen::Isometry3d& truth = flight.T_world_cam.at({0, 8});
    EXPECT_EQ(loner.component, 0);
    EXPECT_LT((loner.T_world_cam.translation() - truth.translation()).norm(), 0.4) << seed;
    EXPECT_LT(rotationErrorDeg(loner.T_world_cam, truth), 0.2) << seed;
  }
}

TEST(JoinSegments, ALonerThatMatchesNothingIsLeftOut) {
  LawnMower away = strips({});
  away.lines = away.per_line = 1;
  away.start_m = {2000, 0};
  const Simulation flight = FlightSimulator(exactGeoreference(), 1).fly({strips({}), away});
  const Placement placement = joinSegments(graphOf(flight), flight.segments, 0);
  EXPECT_EQ(placement.photos.size(), 18u);
  EXPECT_EQ(placement.photos.count({1, 0}), 0u);
}

TEST(JoinSegments, AnUnjoinedGeoreferencedPieceIsAComponentOfItsOwn) {
  LawnMower big = strips({}), small = strips({});
  small.lines = 1;
  small.start_m = {600, 0};
  const Simulation flight = FlightSimulator(exactGeoreference(), 1).fly({big, small});
  const MatchGraph graph = graphOf(flight);
  for (const std::uint16_t center : {0, 1}) {
    const Placement placement = joinSegments(graph, flight.segments, center);
    ASSERT_EQ(placement.photos.size(), 24u);
    EXPECT_EQ(placement.components, 2);
    for (const auto& [id, placed] : placement.photos)
      EXPECT_EQ(placed.component, id.uav == center ? 0 : 1);
    EXPECT_LT(worstOf(flight, placement).position_m, 0.05);
    EXPECT_LT(worstOf(flight, placement).rotation_deg, 0.05);
  }
}

TEST(JoinSegments, AnUnjoinedPieceWithoutGeoreferenceIsLeftOut) {
  LawnMower unknown = strips({});
  unknown.lines = 1;
  unknown.start_m = {600, 0};
  unknown.georeferenced = false;
  const Simulation flight = FlightSimulator(exactGeoreference(), 1).fly({strips({}), unknown});
  const Placement placement = joinSegments(graphOf(flight), flight.segments, 0);
  EXPECT_EQ(placement.photos.size(), 18u);
  EXPECT_EQ(placement.components, 1);
  EXPECT_FALSE(placement.relative);
}

// The same roof stands in two places: its features match over many photos, with one geometry, but
// it fills only a patch of what the photos would share.
TEST(JoinSegments, LookAlikesJoinNothing) {
  for (const bool georeferenced : {false, true}) {
    LawnMower away = strips({});
    away.start_m = {400, 0};
    away.georeferenced = georeferenced;
    Simulation flight = FlightSimulator(exactGeoreference(), 1).fly({strips({}), away});
    addLookAlikes(flight, 1, {40, 30}, 9, {390, 5, 0});
    const MatchGraph graph = graphOf(flight, 1000);
    EXPECT_GT(pairsAcross(graph), 20u);
    const Placement placement = joinSegments(graph, flight.segments, 0);
    EXPECT_EQ(placement.components, georeferenced ? 2 : 1);
    EXPECT_EQ(placement.photos.size(), georeferenced ? 36u : 18u);
    EXPECT_LT(worstOf(flight, placement).position_m, 0.05);
  }
}

TEST(JoinSegments, LookAlikesDoNotHideATrueJoint) {
  LawnMower beside = strips({});
  beside.start_m = {60, 20};
  beside.georeferenced = false;
  Simulation flight = FlightSimulator(exactGeoreference(), 1).fly({strips({}), beside});
  addLookAlikes(flight, 1, {5, 10}, 9, {100, 40, 0});
  const Placement placement = joinSegments(graphOf(flight, 1000), flight.segments, 0);
  EXPECT_EQ(placement.components, 1);
  ASSERT_EQ(placement.photos.size(), 36u);
  EXPECT_LT(worstOf(flight, placement).position_m, 0.8);
  EXPECT_LT(worstOf(flight, placement).rotation_deg, 0.5);
}

TEST(JoinSegments, WithoutAnyGeoreferenceTheMapIsRelativeAndLevel) {
  LawnMower a = strips({7}), b = strips({});
  a.georeferenced = b.georeferenced = false;
  b.start_m = {10, 15};
  const Simulation flight = FlightSimulator(exactGeoreference(), 3).fly({a, b});
  const Placement placement = joinSegments(graphOf(flight), flight.segments, 0);
  EXPECT_TRUE(placement.relative);
  EXPECT_EQ(placement.components, 1);
  ASSERT_EQ(placement.photos.size(), 36u);
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> truth, placed;
  double height = 0;
  for (const auto& [id, photo] : placement.photos) {
    axis += photo.T_world_cam.linear().col(2);
    truth.push_back(flight.T_world_cam.at(id).translation());
    placed.push_back(photo.T_world_cam.translation());
    height += photo.T_world_cam.translation().z() / 36;
  }
  EXPECT_LT(angleDeg(axis, -Eigen::Vector3d::UnitZ()), 3);
  EXPECT_NEAR(height, 0, 3);
  const auto S = alignPoints(truth, placed, AlignmentModel::kSim3);
  ASSERT_TRUE(S.ok());
  EXPECT_NEAR(S->scale, 70. / 50, 0.1);  // the median depth is 50 units
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_LT((*S * placed[i] - truth[i]).norm(), 0.5);
}

}  // namespace
}  // namespace cf
