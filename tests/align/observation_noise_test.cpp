// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "observation_noise.h"

#include <gtest/gtest.h>

#include "support/simulated_flight.h"

namespace cf {
namespace {

using support::FlightSimulator;
using support::LawnMower;
using support::Simulation;
using support::SimulationOptions;

/// Noise of a flight at its true poses, after `shift` has moved each feature [px at the feature
/// size] by its place in the photo (0 to 1 each way).
template <class Shift>
ObservationNoise noiseOf(const Simulation& flight, const Shift& shift) {
  MatchGraph graph{MatchGraphOptions{}};
  std::map<FrameId, PosedPhoto> photos;
  std::vector<MatchGraph::Pair> pairs;
  for (const GeoKeyframe& k : flight.keyframes) {
    auto features = std::make_shared<FeatureSet>(*k.keyframe->features);
    const CameraModel& camera = k.keyframe->camera;
    for (Eigen::Vector2f& pixel : features->pixel)
      pixel += static_cast<float>(features->pixel_size) *
               shift(pixel.x() / static_cast<float>(camera.width),
                     pixel.y() / static_cast<float>(camera.height));
    auto shifted = std::make_shared<Keyframe>(*k.keyframe);
    shifted->features = features;
    graph.add(shifted);
    photos[shifted->id] = {flight.T_world_cam.at(shifted->id), camera};
  }
  for (const auto& [a, photo_a] : photos)
    for (const auto& [b, photo_b] : photos)
      if (a < b) pairs.emplace_back(a, b);
  graph.match(pairs);
  return measureNoise({&graph, triangulateTracks(graph, buildTracks(graph), photos, 4)}, photos);
}

Simulation flight() {
  SimulationOptions options;
  options.pixel_sigma = 0.4;
  LawnMower plan;
  plan.lines = 2;
  plan.per_line = 5;
  return FlightSimulator(options, 3).fly({plan});
}

TEST(MeasureNoise, IndependentErrorsHaveNothingInCommon) {
  const ObservationNoise noise =
      noiseOf(flight(), [](float, float) { return Eigen::Vector2f(0, 0); });
  EXPECT_NEAR(noise.sigma_px, 0.4, 0.04);
  EXPECT_LT(noise.common_variance_px2, 0.0006);
}

/// Corners of the photos drawn outwards by 0.3 px, as a lens that the model cannot follow would.
TEST(MeasureNoise, AShiftOfPartsOfAPhotoIsSeen) {
  const ObservationNoise noise = noiseOf(flight(), [](float x, float y) {
    const bool corner = (x < 0.25F || x > 0.75F) && (y < 0.33F || y > 0.67F);
    return corner ? Eigen::Vector2f(x < 0.5F ? -0.3F : 0.3F, 0) : Eigen::Vector2f(0, 0);
  });
  EXPECT_GT(noise.common_variance_px2, 0.0024);
  EXPECT_LT(noise.common_variance_px2, 0.024);
  EXPECT_NEAR(noise.sigma_px, 0.41, 0.06);
}

TEST(MeasureNoise, NothingWithoutPoints) {
  const MatchGraph graph{MatchGraphOptions{}};
  const ObservationNoise noise = measureNoise({&graph, {}}, {});
  EXPECT_EQ(noise.sigma_px, 0);
  EXPECT_EQ(noise.common_variance_px2, 0);
}

}  // namespace
}  // namespace cf
