// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/gnss_receiver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr TimeNs kStart = 1780308000 * kNsPerSecond;

FlightOptions longFlight() {
  FlightOptions o;
  o.length_m = 20000;
  o.width_m = 1;
  return o;
}

class GnssReceiver : public ::testing::Test {
 protected:
  GnssRecord receive(std::uint64_t seed = 1) const {
    return simulateGnss(options_, flight_, kStart, world_, seed, "[uav.a] ");
  }

  Flight flight_{longFlight(), {60, 80}, 0, 3, ""};
  LocalFrame world_{46.95, 7.44, 540};
  GnssOptions options_;
};

TEST_F(GnssReceiver, recordsWhatItMeasuresInWgs84) {
  options_.sigma_h_m = options_.sigma_v_m = 0;
  const GnssRecord record = receive();
  ASSERT_EQ(record.fixes.size(), flight_.photoTimes().size());
  for (std::size_t i = 0; i < record.fixes.size(); ++i) {
    const SimulatedFix& fix = record.fixes[i];
    const Eigen::Vector3d camera = flight_.T_world_cam(flight_.photoTimes()[i]).translation();
    EXPECT_LT((fix.true_m - camera).norm(), 1e-9);
    EXPECT_LT((world_.toEnu(fix.fix.latitude_deg, fix.fix.longitude_deg, fix.fix.height_m) - camera)
                  .norm(),
              1e-5);
    EXPECT_EQ(fix.fix.time, kStart + std::llround(flight_.photoTimes()[i] * 1e6) * 1000);
    EXPECT_EQ(fix.fix.datum, HeightDatum::kEllipsoid);
  }
}

TEST_F(GnssReceiver, hasTheNoiseAndBiasThatItTells) {
  options_.bias_e_m = 2;
  options_.bias_u_m = -7;
  const GnssRecord record = receive();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
  for (const SimulatedFix& fix : record.fixes) {
    const Eigen::Vector3d error = fix.measured_m - fix.true_m;
    sum += error;
    squares += error.cwiseAbs2();
    EXPECT_EQ(fix.fix.sigma_enu_m, Eigen::Vector3d(1.5, 1.5, 3));
  }
  const double n = static_cast<double>(record.fixes.size());
  const Eigen::Vector3d mean = sum / n;
  const Eigen::Vector3d sigma = (squares / n - mean.cwiseAbs2()).cwiseSqrt();
  EXPECT_LT((mean - Eigen::Vector3d(2, 0, -7)).norm(), 0.3);
  EXPECT_LT((sigma - Eigen::Vector3d(1.5, 1.5, 3)).norm(), 0.3);
  EXPECT_EQ(record.bias_m, Eigen::Vector3d(2, 0, -7));
}

TEST_F(GnssReceiver, drawsBiasesWithinTheirLimits) {
  options_.bias_limit_h_m = 3;
  options_.bias_limit_v_m = 8;
  double most = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Eigen::Vector3d bias = receive(seed).bias_m;
    EXPECT_LE(bias.head<2>().cwiseAbs().maxCoeff(), 3);
    EXPECT_LE(std::abs(bias.z()), 8);
    most = std::max(most, std::abs(bias.z()));
  }
  EXPECT_GT(most, 6);
}

TEST_F(GnssReceiver, walksAsFarAsTimeAllows) {
  options_.sigma_h_m = options_.sigma_v_m = 0;
  options_.walk_v = 0.1;
  double squares = 0;
  constexpr int kRuns = 60;
  double duration = 0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const GnssRecord record = receive(seed);
    squares += std::pow(record.fixes.back().measured_m.z() - record.fixes.back().true_m.z(), 2);
    duration = seconds(record.fixes.back().fix.time - kStart);
  }
  EXPECT_NEAR(std::sqrt(squares / kRuns) / (0.1 * std::sqrt(duration)), 1, 0.3);
}

TEST_F(GnssReceiver, keepsItsNoiseWhenOtherErrorsChange) {
  const GnssRecord plain = receive();
  options_.bias_e_m = 5;
  options_.outages = "100:200";
  options_.outlier_share = 0.2;
  options_.walk_h = 0;
  const GnssRecord worse = receive();
  int compared = 0;
  for (const SimulatedFix& fix : worse.fixes) {
    const auto same =
        std::find_if(plain.fixes.begin(), plain.fixes.end(),
                     [&](const SimulatedFix& p) { return p.fix.time == fix.fix.time; });
    ASSERT_NE(same, plain.fixes.end());
    if (fix.outlier) continue;
    ++compared;
    EXPECT_LT((fix.measured_m - same->measured_m - Eigen::Vector3d(5, 0, 0)).norm(), 1e-9);
  }
  EXPECT_GT(compared, 500);
}

TEST_F(GnssReceiver, hasOutliersAndOutages) {
  options_.outlier_share = 0.1;
  options_.outlier_size_m = 100;
  options_.outages = "100:200";
  const GnssRecord record = receive();
  int outliers = 0;
  for (const SimulatedFix& fix : record.fixes) {
    const double t = seconds(fix.fix.time - kStart);
    EXPECT_FALSE(t >= 100 && t <= 200);
    if (!fix.outlier) continue;
    ++outliers;
    EXPECT_GT((fix.measured_m - fix.true_m).norm(), 35);
  }
  EXPECT_NEAR(outliers / static_cast<double>(record.fixes.size()), 0.1, 0.03);
  options_.outages = "from 3 to 5";
  EXPECT_THROW(receive(), UsageError);
}

TEST_F(GnssReceiver, isMountedAndTimedAndReferredAsTold) {
  options_.sigma_h_m = options_.sigma_v_m = 0;
  options_.lever_forward_m = 0.5;
  options_.lever_up_m = 0.2;
  options_.time_offset_s = 0.3;
  options_.datum = "msl";
  options_.datum_offset_m = -48;
  options_.told_sigma_v_m = 9;
  const SimulatedFix fix = receive().fixes[3];
  const double t = flight_.photoTimes()[3];
  const Eigen::Vector3d camera = flight_.T_world_cam(t).translation();
  EXPECT_LT((fix.true_m - camera - Eigen::Vector3d(0, 0.5, 0.2)).norm(), 1e-9);  // northward
  EXPECT_NEAR(seconds(fix.fix.time - kStart), t + 0.3, 1e-6);
  EXPECT_EQ(fix.fix.datum, HeightDatum::kMsl);
  EXPECT_NEAR(world_.toEnu(fix.fix.latitude_deg, fix.fix.longitude_deg, fix.fix.height_m).z(),
              fix.true_m.z() - 48, 1e-3);
  EXPECT_EQ(fix.fix.sigma_enu_m.z(), 9);
}

TEST_F(GnssReceiver, fixesAtItsOwnRate) {
  options_.rate_hz = 5;
  const GnssRecord record = receive();
  EXPECT_EQ(record.fixes[1].fix.time - record.fixes[0].fix.time, kNsPerSecond / 5);
  EXPECT_GE(record.fixes.back().fix.time, kStart + std::llround(flight_.photoTimes().back() * 1e9));
}

}  // namespace
}  // namespace cf
