// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/grid_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cf/base/error.h"

namespace cf {
namespace {

/// Places with a strong convergence, a strong scale error, both hemispheres.
const Geodetic kPlaces[] = {{46.95, 7.44, 540}, {-33.9, 151.2, 20}, {70.2, 29.9, 5}, {0.3, 3, 0}};

TEST(GridFrame, IsUtmAndHeightOfTheOriginsZone) {
  const GridFrame grid(LocalFrame(46.95, 7.44, 540), HeightDatum::kMsl);
  EXPECT_EQ(grid.epsg(), 32632);
  EXPECT_EQ(grid.datum(), HeightDatum::kMsl);
  const auto utm = geodeticToUtm({32, true}, {46.95, 7.44, 540});
  ASSERT_TRUE(utm.ok());
  const Eigen::Vector3d p = grid.toGrid({0, 0, 0});
  EXPECT_NEAR(p.x(), utm->easting_m, 1e-6);
  EXPECT_NEAR(p.y(), utm->northing_m, 1e-6);
  EXPECT_NEAR(p.z(), 540, 1e-6);
}

TEST(GridFrame, HeightsFollowTheEllipsoidNotTheTangentPlane) {
  const GridFrame grid(LocalFrame(46.95, 7.44, 540), HeightDatum::kEllipsoid);
  EXPECT_NEAR(grid.toGrid({2000, 0, 0}).z() - 540, 2000. * 2000 / (2 * 6388000), 0.001);
}

TEST(GridFrame, GoesThereAndBack) {
  for (const Geodetic& place : kPlaces) {
    const GridFrame grid(LocalFrame(place), HeightDatum::kEllipsoid);
    const Eigen::Vector3d p(812, -455, 31);
    EXPECT_LT((grid.toWorld(grid.toGrid(p)) - p).norm(), 1e-6);
  }
}

TEST(GridFrame, TheAffineOfAPlaceIsExactAroundIt) {
  for (const Geodetic& place : kPlaces) {
    const GridFrame grid(LocalFrame(place), HeightDatum::kEllipsoid);
    for (const Eigen::Vector3d& centre :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(3000, -2000, 60)}) {
      const Eigen::Affine3d T = grid.T_grid_world(centre);
      for (const double radius_m : {50., 80.})
        for (int k = 0; k < 8; ++k) {
          const Eigen::Vector3d p = centre + Eigen::Vector3d(radius_m * std::cos(k),
                                                             radius_m * std::sin(k), 10 * (k - 4));
          EXPECT_LT((T * p - grid.toGrid(p)).norm(), radius_m > 60 ? 1e-3 : 5e-4) << radius_m;
        }
    }
  }
}

TEST(GridFrame, OfARelativeMapIsTheMapItself) {
  const GridFrame grid;
  EXPECT_TRUE(grid.relative());
  EXPECT_EQ(grid.epsg(), 0);
  const Eigen::Vector3d p(1, 2, 3);
  EXPECT_EQ(grid.toGrid(p), p);
  EXPECT_EQ(grid.toWorld(p), p);
  EXPECT_EQ(grid.T_grid_world(p) * p, p);
}

TEST(GridFrame, SaysWhatIsOutsideUtm) {
  const GridFrame grid(LocalFrame(46.95, 7.44, 540), HeightDatum::kEllipsoid);
  EXPECT_THROW((void)grid.toGrid({6e6, 0, 0}), RunError);
}

}  // namespace
}  // namespace cf
