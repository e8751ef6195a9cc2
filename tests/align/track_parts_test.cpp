// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "track_parts.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

namespace cf {
namespace {

/// Photos with a feature each, that is in the chain given; -1: in none.
MatchGraph photosWith(const std::vector<std::pair<FrameId, int>>& chain_of) {
  MatchGraph graph{MatchGraphOptions{}};
  for (const auto& [id, chain] : chain_of) {
    auto features = std::make_shared<FeatureSet>();
    features->pixel.emplace_back(100.F, 100.F);
    features->scale_px.push_back(5);
    features->descriptor.resize(FeatureSet::kDescriptorSize);
    features->colour.resize(3);
    auto photo = std::make_shared<Keyframe>();
    photo->id = id;
    photo->camera.width = photo->camera.height = 200;
    photo->camera.fx = photo->camera.fy = 200;
    photo->features = features;
    photo->chain = {chain};
    graph.add(photo);
  }
  return graph;
}

std::vector<FrameId> framesOf(const Track& track) {
  std::vector<FrameId> frames;
  for (const SparseObservation& o : track) frames.push_back(o.frame);
  return frames;
}

TEST(TakeApart, ChainsAndWhatHoldsThemTogether) {
  const FrameId a0{0, 0}, a1{0, 1}, a2{0, 2}, a7{0, 7}, b0{1, 0}, b1{1, 1};
  // Two UAVs number their chains each for itself: 4 of one is not 4 of the other.
  const MatchGraph graph = photosWith({{a0, 4}, {a1, 4}, {a2, 4}, {a7, -1}, {b0, 4}, {b1, 4}});
  const Track track = {{a0, 0}, {a1, 0}, {a2, 0}, {a7, 0}, {b0, 0}, {b1, 0}};
  const TrackParts parts = takeApart(graph, {track});
  ASSERT_EQ(parts.chains.size(), 2u);
  EXPECT_EQ(framesOf(parts.chains[0]), (std::vector<FrameId>{a0, a1, a2}));
  EXPECT_EQ(framesOf(parts.chains[1]), (std::vector<FrameId>{b0, b1}));
  ASSERT_EQ(parts.links.size(), 1u);
  EXPECT_EQ(framesOf(parts.links[0]), (std::vector<FrameId>{a7, a0, a2, b0, b1}));
  ASSERT_EQ(parts.detections.size(), 1u);
  EXPECT_EQ(framesOf(parts.detections[0]), (std::vector<FrameId>{a7, a0, b0}));
  EXPECT_EQ(sharedDetection(graph, parts.links[0], {a2, 0}), 2);
  EXPECT_EQ(sharedDetection(graph, parts.links[0], {a7, 0}), 1);
}

TEST(TakeApart, OneChainAloneNeedsNoLink) {
  const FrameId a0{0, 0}, a1{0, 1};
  const MatchGraph graph = photosWith({{a0, 9}, {a1, 9}});
  const TrackParts parts = takeApart(graph, {{{a0, 0}, {a1, 0}}});
  EXPECT_EQ(parts.chains.size(), 1u);
  EXPECT_TRUE(parts.links.empty());
  EXPECT_TRUE(parts.detections.empty());
}

TEST(TakeApart, WithoutChainsEveryTrackIsALink) {
  const FrameId a0{0, 0}, b0{1, 0};
  const MatchGraph graph = photosWith({{a0, -1}, {b0, -1}});
  const TrackParts parts = takeApart(graph, {{{a0, 0}, {b0, 0}}});
  EXPECT_TRUE(parts.chains.empty());
  ASSERT_EQ(parts.links.size(), 1u);
  EXPECT_EQ(framesOf(parts.links[0]), framesOf(parts.detections[0]));
}

}  // namespace
}  // namespace cf
