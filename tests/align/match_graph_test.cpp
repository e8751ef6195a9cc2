// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/match_graph.h"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "support/simulated_flight.h"

namespace cf {
namespace {

using support::FlightSimulator;
using support::LawnMower;
using support::Simulation;
using support::SimulationOptions;

MatchGraph graphOf(const Simulation& simulation) {
  MatchGraph graph{MatchGraphOptions{}};
  for (const GeoKeyframe& k : simulation.keyframes) graph.add(k.keyframe);
  return graph;
}

LawnMower shortLine() {
  LawnMower plan;
  plan.lines = 1;
  plan.per_line = 5;
  plan.step_m = 20;
  return plan;
}

FrameId photo(std::uint32_t index) { return {0, index}; }

TEST(MatchGraph, ConnectsOverlappingPhotosByTrueMatches) {
  for (const double relief : {0.0, 10.0}) {
    SimulationOptions options;
    options.terrain.relief_m = relief;
    options.wrong_features = 0.25;
    const Simulation flight = FlightSimulator(options, 1).fly({shortLine()});
    MatchGraph graph = graphOf(flight);
    graph.match({{photo(0), photo(1)}, {photo(0), photo(2)}, {photo(1), photo(3)}});
    ASSERT_EQ(graph.pairs().size(), 3u);
    for (const auto& [pair, matches] : graph.pairs()) {
      const auto& a = flight.ground_point.at(pair.first);
      const auto& b = flight.ground_point.at(pair.second);
      // Points that both photos show as what they are.
      const std::set<int> in_a(a.begin(), a.end());
      std::size_t common = 0, right = 0;
      for (const int point : b) common += point >= 0 && in_a.count(point) > 0;
      for (const FeatureMatch& m : matches)
        right += a[static_cast<std::size_t>(m.a)] >= 0 &&
                 a[static_cast<std::size_t>(m.a)] == b[static_cast<std::size_t>(m.b)];
      EXPECT_GT(static_cast<double>(right), 0.99 * static_cast<double>(matches.size()));
      EXPECT_GT(static_cast<double>(right), 0.7 * static_cast<double>(common));
    }
  }
}

TEST(MatchGraph, DoesNotConnectWhatSharesNoGround) {
  const Simulation flight = FlightSimulator({}, 1).fly({[] {
    LawnMower plan = shortLine();
    plan.step_m = 120;
    return plan;
  }()});
  MatchGraph graph = graphOf(flight);
  graph.match({{photo(0), photo(1)}, {photo(0), photo(4)}, {photo(2), photo(3)}});
  EXPECT_TRUE(graph.pairs().empty());
  EXPECT_TRUE(buildTracks(graph).empty());
}

TEST(MatchGraph, TheThresholdIsInPixelsOfTheFeatureSize) {
  const Simulation flight = FlightSimulator({}, 1).fly({shortLine()});
  const MatchGraph graph = graphOf(flight);
  EXPECT_NEAR(graph.threshold(photo(0)), 3 * 3.5 / 3000, 1e-12);
  EXPECT_EQ(graph.photos().size(), 5u);
  EXPECT_EQ(graph.photo(photo(3)).name, "photo_3.jpg");
}

TEST(MatchGraph, AskingAgainOrInAnotherOrderChangesNothing) {
  const Simulation flight = FlightSimulator({}, 2).fly({shortLine()});
  const std::vector<MatchGraph::Pair> pairs{
      {photo(0), photo(1)}, {photo(1), photo(2)}, {photo(0), photo(2)}};
  MatchGraph once = graphOf(flight), twice = graphOf(flight);
  once.match(pairs);
  twice.match({pairs[2]});
  twice.match({pairs[1], pairs[0], pairs[2]});
  twice.match(pairs);
  ASSERT_EQ(once.pairs().size(), twice.pairs().size());
  for (const auto& [pair, matches] : once.pairs()) {
    const auto& others = twice.pairs().at(pair);
    ASSERT_EQ(matches.size(), others.size());
    for (std::size_t i = 0; i < matches.size(); ++i)
      EXPECT_TRUE(matches[i].a == others[i].a && matches[i].b == others[i].b);
  }
  const auto p = buildTracks(once), q = buildTracks(twice);
  ASSERT_EQ(p.size(), q.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    ASSERT_EQ(p[i].size(), q[i].size());
    for (std::size_t k = 0; k < p[i].size(); ++k)
      EXPECT_TRUE(p[i][k].frame == q[i][k].frame && p[i][k].feature == q[i][k].feature);
  }
}

TEST(BuildTracks, AreTheGroundPoints) {
  const Simulation flight = FlightSimulator({}, 3).fly({shortLine()});
  MatchGraph graph = graphOf(flight);
  std::vector<MatchGraph::Pair> pairs;
  for (std::uint32_t i = 0; i < 5; ++i)
    for (std::uint32_t j = i + 1; j < 5; ++j) pairs.emplace_back(photo(i), photo(j));
  graph.match(pairs);
  const auto tracks = buildTracks(graph);
  std::set<std::tuple<std::uint32_t, int>> used;
  std::size_t pure = 0, long_ones = 0;
  for (const Track& track : tracks) {
    ASSERT_GE(track.size(), 2u);
    std::set<std::uint32_t> photos;
    std::set<int> points;
    for (const auto& o : track) {
      EXPECT_TRUE(photos.insert(o.frame.index).second) << "two features of one photo";
      EXPECT_TRUE(used.emplace(o.frame.index, o.feature).second) << "a feature in two tracks";
      points.insert(flight.ground_point.at(o.frame)[static_cast<std::size_t>(o.feature)]);
    }
    pure += points.size() == 1 && *points.begin() >= 0;
    long_ones += track.size() >= 3;
  }
  EXPECT_GT(tracks.size(), 800u);
  EXPECT_GT(long_ones, tracks.size() / 4);
  EXPECT_GT(static_cast<double>(pure), 0.985 * static_cast<double>(tracks.size()));
}

TEST(BuildTracks, OfSomePhotosAreThoseOfAGraphWithoutTheOthers) {
  const Simulation flight = FlightSimulator({}, 4).fly({shortLine()});
  const std::set<FrameId> some{photo(0), photo(1), photo(3)};
  MatchGraph all = graphOf(flight), few{MatchGraphOptions{}};
  for (const GeoKeyframe& k : flight.keyframes)
    if (some.count(k.keyframe->id) > 0) few.add(k.keyframe);
  all.match(
      {{photo(0), photo(1)}, {photo(0), photo(2)}, {photo(1), photo(2)}, {photo(1), photo(3)}});
  few.match({{photo(0), photo(1)}, {photo(1), photo(3)}});
  const auto p = buildTracks(all, some), q = buildTracks(few);
  ASSERT_GT(p.size(), 300u);
  ASSERT_EQ(p.size(), q.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    ASSERT_EQ(p[i].size(), q[i].size());
    for (std::size_t k = 0; k < p[i].size(); ++k)
      EXPECT_TRUE(p[i][k].frame == q[i][k].frame && p[i][k].feature == q[i][k].feature);
  }
}

/// Three photos from one place. Feature 0 of the first and feature 1 of the first look both like
/// feature 0 of the second and third, each to one of them: the first photo is cut from the track,
/// the second and third keep it.
TEST(BuildTracks, APhotoSeenTwiceIsCutFromTheTrack) {
  const auto blend = [](double share) {
    auto d = support::descriptorOf(1000);
    const auto other = support::descriptorOf(2000);
    for (std::size_t k = 0; k < d.size(); ++k) d[k] += share * (other[k] - d[k]);
    return d;
  };
  const auto photoOf = [&](std::uint32_t index, const std::vector<double>& blends) {
    auto keyframe = std::make_shared<Keyframe>();
    keyframe->id = photo(index);
    keyframe->camera = SimulationOptions().true_camera;
    auto features = std::make_shared<FeatureSet>();
    const auto add = [&](double u, double v, const auto& descriptor) {
      features->pixel.emplace_back(static_cast<float>(u), static_cast<float>(v));
      for (const double value : descriptor)
        features->descriptor.push_back(static_cast<std::uint8_t>(std::lround(value)));
    };
    for (std::size_t i = 0; i < blends.size(); ++i)
      add(2000 + static_cast<double>(i), 1500, blend(blends[i]));
    for (int i = 0; i < 60; ++i)  // the scene around, the same in all three
      add(100 + 613 * i % 3800, 100 + 977 * i % 2800, support::descriptorOf(i));
    keyframe->features = features;
    return keyframe;
  };
  MatchGraph graph{MatchGraphOptions{}};
  graph.add(photoOf(0, {0, 1}));
  graph.add(photoOf(1, {0.3}));
  graph.add(photoOf(2, {0.9}));
  graph.match({{photo(0), photo(1)}, {photo(0), photo(2)}, {photo(1), photo(2)}});
  ASSERT_EQ(graph.pairs().size(), 3u);
  const auto has = [&](std::uint32_t i, std::uint32_t j, int a, int b) {
    const auto& matches = graph.pairs().at({photo(i), photo(j)});
    return std::any_of(matches.begin(), matches.end(),
                       [&](const FeatureMatch& m) { return m.a == a && m.b == b; });
  };
  ASSERT_TRUE(has(0, 1, 0, 0));
  ASSERT_TRUE(has(0, 2, 1, 0));
  ASSERT_TRUE(has(1, 2, 0, 0));
  const auto tracks = buildTracks(graph);
  EXPECT_EQ(tracks.size(), 61u);
  int found = 0;
  for (const Track& track : tracks) {
    const bool contested = std::any_of(track.begin(), track.end(), [](const auto& o) {
      return o.frame.index > 0 ? o.feature == 0 : o.feature < 2;
    });
    if (!contested) {
      EXPECT_EQ(track.size(), 3u);
      continue;
    }
    ++found;
    ASSERT_EQ(track.size(), 2u);
    EXPECT_EQ(track[0].frame, photo(1));
    EXPECT_EQ(track[1].frame, photo(2));
  }
  EXPECT_EQ(found, 1);
}

}  // namespace
}  // namespace cf
