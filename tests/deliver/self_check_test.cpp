// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/self_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "deliver/flight_record.h"
#include "gnss_residuals.h"
#include "reprojection.h"
#include "seam_cells.h"

namespace cf {
namespace {

using support::RecordedFlight;

std::map<std::string, SelfCheck> checksOf(const RunRecord& run) {
  std::map<std::string, SelfCheck> checks;
  for (const SelfCheck& check : selfCheck(run)) checks[check.name] = check;
  return checks;
}

/// All checks but one are green.
void expectOnly(const std::string& wrong, Grade grade, const RunRecord& run) {
  for (const auto& [name, check] : checksOf(run)) {
    EXPECT_EQ(check.grade, name == wrong ? grade : Grade::kGreen) << name << ": " << check.finding;
    EXPECT_EQ(check.advice.empty(), name != wrong) << name;
  }
}

TEST(SelfCheck, AGoodFlightIsGreenAndSaysSoInOneLine) {
  const RunRecord run = RecordedFlight().record();
  expectOnly("", Grade::kGreen, run);
  const auto lines = doubts(selfCheck(run));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].find("nothing doubtful"), 0u);
}

TEST(SelfCheck, ASeamIsFoundWhateverWrongMatchesThereAre) {
  RecordedFlight flight;
  flight.seam_m = {0.03, -0.04, 0.12};  // 0.13 m; a pixel is 0.027 m
  const RunRecord run = flight.record();
  const auto seam = seamOf(run.seam_points);
  ASSERT_TRUE(seam);
  EXPECT_NEAR(seam->rms_m, 0.13, 0.01);
  expectOnly("seam", Grade::kAmber, run);
  flight.seam_m *= 3;
  expectOnly("seam", Grade::kRed, flight.record());
  EXPECT_LT(seamOf(RecordedFlight().record().seam_points)->rms_m, 0.02);
}

TEST(SelfCheck, UavsThatNeverMeetAreDoubtfulAndOneAloneHasNoSeam) {
  RunRecord run = RecordedFlight().record();
  run.seam_points.clear();
  expectOnly("seam", Grade::kAmber, run);
  run.uavs.resize(1);
  run.sparse_points.clear();  // the other UAV is among those who see them
  EXPECT_EQ(checksOf(run).at("seam").grade, Grade::kUntested);
  EXPECT_FALSE(checksOf(run).at("seam").value);
}

TEST(SelfCheck, ABendIsSeenOnlyWhereTheReceiversAreGoodEnough) {
  RecordedFlight flight;
  flight.bend_m = 5;
  flight.fix_sigma_m = 0.3;
  const auto bend = bendAgainstGnss(flight.record());
  ASSERT_TRUE(bend);
  EXPECT_NEAR(bend->span_m, 5, 3 * bend->sigma_m);
  EXPECT_LT(bend->sigma_m, 0.3);
  EXPECT_EQ(checksOf(flight.record()).at("doming").grade, Grade::kRed);

  flight.bend_m = 0;
  flight.rows = 6;
  for (unsigned seed = 1; seed <= 30; ++seed) {  // noise alone is no bend
    flight.seed = seed;
    EXPECT_EQ(checksOf(flight.record()).at("doming").grade, Grade::kGreen) << seed;
  }
}

TEST(SelfCheck, APredictedBendCountsWithoutGnss) {
  RunRecord run = RecordedFlight().record();
  for (UavRecord& uav : run.uavs) {
    uav.fixes.clear();
    for (auto& [photo, known] : uav.covariances) known.covariance.in_map(2, 2) = 0.1 * 0.1;
  }
  const SelfCheck check = checksOf(run).at("doming");
  EXPECT_NEAR(*check.value, 0.2, 1e-9);
  EXPECT_EQ(check.grade, Grade::kAmber);
  for (UavRecord& uav : run.uavs) uav.covariances.clear();
  EXPECT_EQ(checksOf(run).at("doming").grade, Grade::kAmber) << "nothing tells";
}

TEST(SelfCheck, ABendThatReceiversAreTooNoisyToTellIsAmberWithAdvice) {
  RunRecord run = RecordedFlight().record();
  for (UavRecord& uav : run.uavs) {
    uav.covariances.clear();
    double sign = 30;
    for (auto& [photo, fix] : uav.fixes) fix.position_m.z() += (sign = -sign);
  }
  const SelfCheck check = checksOf(run).at("doming");
  EXPECT_EQ(check.grade, Grade::kAmber);
  EXPECT_FALSE(check.advice.empty());
}

TEST(SelfCheck, ALensThatDoesNotFitLeavesAPattern) {
  RecordedFlight flight;
  flight.seen_by.k1 = 0.01;
  const auto wrong = reprojectionsOf(flight.record());
  EXPECT_GT(wrong[0].systematic_px, 2);
  EXPECT_EQ(checksOf(flight.record()).at("lens").grade, Grade::kRed);
  const auto right = reprojectionsOf(RecordedFlight().record());
  EXPECT_LT(right[0].systematic_px, 0.05);
  EXPECT_NEAR(right[0].median_px, 0.3 * 1.1774, 0.02);  // of a Rayleigh distribution
  EXPECT_NEAR(groundPixel(RecordedFlight().record()), 80.0 / 3000, 1e-3);
}

TEST(SelfCheck, ReceiversThatScatterMoreThanTheyTag) {
  RecordedFlight flight;
  flight.fix_sigma_m = 3;
  RunRecord run = flight.record();
  EXPECT_NEAR(gnssNoiseRatio(gnssResiduals(run.uavs[0])), 3, 0.6);
  expectOnly("gnss", Grade::kAmber, run);
  for (UavRecord& uav : run.uavs) uav.gnss.trusted = false;
  expectOnly("gnss", Grade::kRed, run);
  for (UavRecord& uav : run.uavs) uav.fixes.clear();
  run.world.relative = true;
  expectOnly("gnss", Grade::kAmber, run);
}

TEST(SelfCheck, LostPhotosPartsAndLooseDepth) {
  RunRecord run = RecordedFlight().record();
  for (int i = 0; i < 6; ++i) run.uavs[0].photos[i].status = PhotoStatus::kUnposed;
  expectOnly("photos", Grade::kAmber, run);
  for (int i = 0; i < 30; ++i) run.uavs[0].photos[i].status = PhotoStatus::kUnposed;
  expectOnly("photos", Grade::kRed, run);

  run = RecordedFlight().record();
  run.components = 2;
  expectOnly("photos", Grade::kAmber, run);
  const auto lines = doubts(selfCheck(run));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].find("doubtful (amber): Photos placed: "), 0u) << lines[0];

  run = RecordedFlight().record();
  run.cloud = {};
  expectOnly("depth", Grade::kRed, run);
}

TEST(CloudSketch, IsThinnedEvenlyAndCountsWhatIsConfirmed) {
  CloudSketch sketch;
  for (int t = 0; t < 10; ++t) {
    Tile tile;
    tile.offset_m = {100.0 * t, 0, 0};
    for (int i = 0; i < 100'000; ++i) {
      TilePoint p;
      p.position_m = {static_cast<float>(i % 300) / 3, static_cast<float>(i) / 1000, 1};
      p.views = i % 4 == 0 ? 1 : 2;
      tile.points.push_back(p);
    }
    sketch.add(tile);
  }
  EXPECT_EQ(sketch.total(), 1'000'000u);
  EXPECT_EQ(sketch.confirmed(), 750'000u);
  EXPECT_LE(sketch.points().size(), CloudSketch::kMost);
  EXPECT_GT(sketch.points().size(), CloudSketch::kMost / 2);
  std::map<int, int> by_tile;
  for (const auto& p : sketch.points()) ++by_tile[static_cast<int>(p.position_m.x() / 100.001f)];
  for (const auto& [tile, count] : by_tile)
    EXPECT_NEAR(count, static_cast<double>(sketch.points().size()) / 10, 1500) << tile;
}

}  // namespace
}  // namespace cf
