// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/local_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr double kA = 6378137.0;          // WGS84 semi-major axis [m]
constexpr double kF = 1 / 298.257223563;  // flattening
constexpr double kB = kA * (1 - kF);      // semi-minor axis

TEST(LocalFrame, OriginIsZero) {
  const LocalFrame frame(46.84, -91.99, 198.3);
  EXPECT_LT(frame.toEnu(46.84, -91.99, 198.3).norm(), 1e-8);
}

TEST(LocalFrame, EcefOnTheAxesIsTheEllipsoidsAxes) {
  EXPECT_LT((LocalFrame(0, 0, 0).toEcef({0, 0, 0}) - Eigen::Vector3d(kA, 0, 0)).norm(), 1e-8);
  EXPECT_LT((LocalFrame(0, 90, 10).toEcef({0, 0, 0}) - Eigen::Vector3d(0, kA + 10, 0)).norm(),
            1e-8);
  EXPECT_LT((LocalFrame(90, 0, 0).toEcef({0, 0, 0}) - Eigen::Vector3d(0, 0, kB)).norm(), 1e-8);
}

TEST(LocalFrame, AxesAreEastNorthUp) {
  const LocalFrame frame(0, 0, 0);  // east = +Y, north = +Z, up = +X of ECEF
  Eigen::Matrix3d expected;
  expected << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  EXPECT_LT((frame.T_ecef_enu().linear() - expected).norm(), 1e-15);

  const LocalFrame here(28.04, -82.7, -6);
  EXPECT_GT(here.toEnu(28.04, -82.699, -6).x(), 90);
  EXPECT_NEAR(here.toEnu(28.04, -82.699, -6).y(), 0, 0.01);
  EXPECT_GT(here.toEnu(28.041, -82.7, -6).y(), 100);
  EXPECT_NEAR(here.toEnu(28.041, -82.7, -6).x(), 0, 1e-9);
  EXPECT_NEAR(here.toEnu(28.04, -82.7, 4).z(), 10, 1e-8);
}

TEST(LocalFrame, MetresPerDegreeAreThoseOfTheRadiiOfCurvature) {
  const double lat = 46.0, phi = lat * M_PI / 180, d = 1e-5, rad = d * M_PI / 180;
  const double e2 = kF * (2 - kF), w = std::sqrt(1 - e2 * std::sin(phi) * std::sin(phi));
  const LocalFrame frame(lat, 10, 0);
  EXPECT_NEAR(frame.toEnu(lat, 10 + d, 0).x(), kA / w * std::cos(phi) * rad, 1e-7);
  EXPECT_NEAR(frame.toEnu(lat + d, 10, 0).y(), kA * (1 - e2) / (w * w * w) * rad, 1e-6);
}

TEST(LocalFrame, RoundTripIsExactFarFromTheOrigin) {
  const LocalFrame frame(-33.9, 179.999, 50);
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(123.4, -567.8, 90),
                                   Eigen::Vector3d(20e3, 30e3, -200)}) {
    const Geodetic g = frame.toGeodetic(p);
    EXPECT_LT((frame.toEnu(g) - p).norm(), 1e-7);
  }
  EXPECT_LT(frame.toGeodetic({200, 0, 0}).longitude_deg, -179.99) << "date line crossed";
}

TEST(LocalFrame, FramesAreRelatedByAnIsometryThatAgreesWithGeodesy) {
  const LocalFrame a(46.84, -91.99, 198), b(46.85, -91.97, 150);
  const Eigen::Vector3d p_b(12, -34, 56);
  EXPECT_LT((a.T_this_other(b) * p_b - a.toEnu(b.toGeodetic(p_b))).norm(), 1e-8);
  EXPECT_LT((a.toEcef(a.T_this_other(b) * p_b) - b.toEcef(p_b)).norm(), 1e-8);
  EXPECT_GT(a.T_this_other(b).linear().isIdentity(1e-5) ? 0 : 1, 0) << "the frames are turned";
}

TEST(LocalFrame, NamesItsUtmZone) {
  EXPECT_EQ(LocalFrame(46.84, -91.99, 0).utmZone(), "15N");
  EXPECT_EQ(LocalFrame(46.84, -91.99, 0).utmEpsg(), 32615);
  EXPECT_EQ(LocalFrame(-33.9, 151.2, 0).utmZone(), "56S");
  EXPECT_EQ(LocalFrame(-33.9, 151.2, 0).utmEpsg(), 32756);
}

TEST(LocalFrame, RefusesWhatIsNoPlace) {
  EXPECT_THROW(LocalFrame(91, 0, 0), RunError);
  EXPECT_THROW(LocalFrame(0, std::numeric_limits<double>::quiet_NaN(), 0), RunError);
}

}  // namespace
}  // namespace cf
