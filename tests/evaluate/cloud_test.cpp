// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/cloud.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "cf/base/error.h"
#include "cf/formats/ply.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using Points = std::vector<Eigen::Vector3f>;

/// The plane z = 0.2 x on a grid of 0.1 m: its normal makes heights count 1 / sqrt(1.04).
Points slope(float from, float to) {
  Points points;
  for (float x = from; x < to; x += 0.1F)
    for (float y = 0; y < 10; y += 0.1F) points.emplace_back(x, y, 0.2F * x);
  return points;
}
const double kSlope = 1 / std::sqrt(1.04);

CloudEvaluation evaluate(Points estimate, Points reference) {
  return evaluateCloud({std::move(estimate), std::move(reference), false}, false);
}

TEST(Cloud, BiasAndNoiseAreFound) {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.3F, 0.05F);
  Points estimate = slope(1, 9);
  for (Eigen::Vector3f& p : estimate) p.z() += noise(random);
  const CloudEvaluation e = evaluate(estimate, slope(0, 10));
  EXPECT_EQ(e.compared, estimate.size());
  EXPECT_NEAR(e.plane_bias_m, 0.3 * kSlope, 0.003);
  EXPECT_NEAR(e.plane.median_m, 0.3 * kSlope, 0.003);
  EXPECT_NEAR(e.plane.nmad_m, 0.05 * kSlope, 0.002);
  EXPECT_NEAR(e.plane.rms_m, std::hypot(0.3, 0.05) * kSlope, 0.003);
  EXPECT_NEAR(e.plane.p95_m, (0.3 + 1.645 * 0.05) * kSlope, 0.005);
  EXPECT_NEAR(e.plane.share_within[1], 0.1777, 0.02);  // P(N(0.3, 0.05) kSlope < 0.25)
  EXPECT_EQ(e.plane.share_within[2], 1);
}

TEST(Cloud, OutliersAndBelowCount) {
  Points estimate = slope(1, 9);
  for (std::size_t i = 0; i < estimate.size(); i += 4) estimate[i].z() -= 1.5F;
  const CloudEvaluation e = evaluate(estimate, slope(0, 10));
  EXPECT_NEAR(e.plane.share_within[0], 0.75, 1e-3);
  EXPECT_NEAR(e.plane.share_within[3], 0.75, 1e-3);
  EXPECT_NEAR(e.plane.share_within[4], 1, 1e-3);
  EXPECT_NEAR(e.plane.median_m, 0, 1e-4);
  EXPECT_NEAR(e.plane.nmad_m, 0, 1e-4);
  EXPECT_NEAR(e.plane.rms_m, 0.75 * kSlope, 1e-3);
}

TEST(Cloud, OnlyWhereTheReferenceIsNearHorizontally) {
  // x 0…10 estimated; the reference covers 0…6 and so counts up to 6.4 and a bit.
  const Points estimate = slope(0, 9.99F);
  std::size_t expected = 0;
  for (const Eigen::Vector3f& p : estimate) expected += p.x() < 5.95F + 0.5F;
  const CloudEvaluation e = evaluate(estimate, slope(0, 5.95F));
  EXPECT_NEAR(static_cast<double>(e.compared), static_cast<double>(expected), 100.5);  // a column
  EXPECT_EQ(e.sampled, estimate.size());
  EXPECT_LT(e.compared, e.sampled);
  // The reference is complete, the other way round it is not.
  EXPECT_EQ(e.completeness_050, 1);
  const CloudEvaluation reverse = evaluate(slope(0, 5.95F), slope(0, 9.99F));
  EXPECT_NEAR(reverse.completeness_050, 0.64, 0.02);
  EXPECT_NEAR(reverse.completeness_100, 0.69, 0.02);
  EXPECT_THROW(evaluate(slope(0, 3), slope(20, 30)), RunError);
  EXPECT_THROW(evaluate(slope(0, 0), slope(0, 1)), RunError);
}

TEST(Cloud, NearestDistancesAgreeWithBruteForce) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> at(0, 2);
  const auto cloud = [&](int n) {
    Points points;
    for (int i = 0; i < n; ++i) points.emplace_back(at(random), at(random), 3 * at(random));
    return points;
  };
  const Points reference = cloud(1500), estimate = cloud(400);
  double squares = 0, worst = 0;
  int covered = 0;
  const auto nearest = [](const Eigen::Vector3f& p, const Points& others) {
    float best = std::numeric_limits<float>::max();
    for (const Eigen::Vector3f& q : others) best = std::min(best, (p - q).norm());
    return static_cast<double>(best);
  };
  for (const Eigen::Vector3f& p : estimate) {
    const double d = nearest(p, reference);
    squares += d * d;
    worst = std::max(worst, d);
  }
  for (const Eigen::Vector3f& q : reference) covered += nearest(q, estimate) <= 0.5;
  const CloudEvaluation e = evaluate(estimate, reference);
  ASSERT_EQ(e.compared, 400u);
  EXPECT_NEAR(e.nearest.rms_m, std::sqrt(squares / 400), 1e-6);
  EXPECT_NEAR(e.completeness_050, covered / 1500.0, 1e-9);
  EXPECT_LT(e.nearest.p95_m, worst);
}

TEST(Cloud, JsonInPixelsOfTheGround) {
  Points estimate = slope(1, 9);
  for (Eigen::Vector3f& p : estimate) p.z() += 0.3F;
  const CloudEvaluation e = evaluate(estimate, slope(0, 10));
  const auto json = nlohmann::json::parse(toJson(e, 0.05));
  EXPECT_NEAR(json["plane"]["median_gsd"].get<double>(), 6 * kSlope, 0.01);
  EXPECT_EQ(json["plane"]["share_within"]["0.5m"], 1.0);
  EXPECT_FALSE(nlohmann::json::parse(toJson(e, std::nullopt))["plane"].contains("median_gsd"));
}

TEST(Cloud, FoldersAndOriginsOfFiles) {
  const fs::path root = fs::path(testing::TempDir()) / "cf_evaluate_cloud";
  fs::remove_all(root);
  fs::create_directories(root / "out/cloud");
  fs::create_directories(root / "ref");
  const auto write = [](const fs::path& file, float dz) {
    PlyWriter writer(file);
    for (const Eigen::Vector3f& p : slope(0, 5)) writer.add(p + dz * Eigen::Vector3f::UnitZ(), {});
    writer.add({std::numeric_limits<float>::quiet_NaN(), 0, 0}, {});
    writer.close();
  };
  write(root / "out/cloud/cloud.ply", -7);
  write(root / "ref/cloud.ply", 0);
  const auto bias = [&] {
    return evaluateCloud(readClouds(root / "out", root / "ref"), false).plane_bias_m;
  };
  EXPECT_NEAR(bias(), -7 * kSlope, 1e-3);
  EXPECT_FALSE(readClouds(root / "out", root / "ref").common_world);
  writeFileAtomically(root / "out/world.json", R"({"origin":{"lat":46.84,"lon":-91.99,"h":207}})");
  writeFileAtomically(root / "ref/world.json", R"({"origin":{"lat":46.84,"lon":-91.99,"h":200}})");
  EXPECT_TRUE(readClouds(root / "out", root / "ref").common_world);
  EXPECT_NEAR(bias(), 0, 1e-3);
  writeFileAtomically(root / "ref/world.json", R"({"origin":{"lat":"x"}})");
  EXPECT_THROW(bias(), RunError);
  fs::remove(root / "ref/cloud.ply");
  EXPECT_THROW(bias(), RunError);
}

}  // namespace
}  // namespace cf
