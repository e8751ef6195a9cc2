// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "reference_surface.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cf/base/error.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/ply.h"
#include "cf/geodesy/utm.h"
#include "srgb.h"

namespace cf {
namespace {

/// Cells of the ENU plane, row 0 in the north.
struct Grid {
  double west = 0, north = 0, spacing = 1;
  int columns = 0, rows = 0;

  Eigen::Vector2d centre(int column, int row) const {
    return {west + (column + 0.5) * spacing, north - (row + 0.5) * spacing};
  }
};

Grid gridOver(const Eigen::AlignedBox2d& area, double spacing) {
  constexpr double kMostCells = 4e8;
  Grid grid;
  grid.spacing = spacing;
  grid.west = std::floor(area.min().x() / spacing) * spacing;
  grid.north = std::ceil(area.max().y() / spacing) * spacing;
  const double columns = std::ceil((area.max().x() - grid.west) / spacing);
  const double rows = std::ceil((grid.north - area.min().y()) / spacing);
  if (columns * rows > kMostCells)
    throw UsageError(fmt::format(
        "[simulation] reference_spacing = {} makes {:.3g} cells: give a coarser one, or 0 for none",
        spacing, columns * rows));
  grid.columns = static_cast<int>(columns);
  grid.rows = static_cast<int>(rows);
  return grid;
}

/// A camera that may have seen a point.
class Witness {
 public:
  Witness(const TrueCamera& camera, const Eigen::Isometry3d& T_world_cam)
      : camera_(camera), T_cam_world_(T_world_cam.inverse()), centre_(T_world_cam.translation()) {}

  bool sees(const Eigen::Vector3d& point, const Scene& scene) const {
    const Eigen::Vector3d p = T_cam_world_ * point;
    if (p.z() <= 0 || !inside(p)) return false;
    const Eigen::Vector3d way = point - centre_;
    // Up to a hair before the point itself, nothing may stand in the way.
    constexpr double kNear_m = 0.02;
    const auto hit = scene.hit(centre_, way);
    return !hit || (1 - hit->distance) * way.norm() < kNear_m;
  }

 private:
  bool inside(const Eigen::Vector3d& p) const {
    // Far outside, distortion may fold points back into the photo.
    const double far = std::hypot(camera_.width, camera_.height) / camera_.focal;
    if (p.head<2>().norm() > far * p.z()) return false;
    const Eigen::Vector2d pixel = camera_.pixelOf(p);
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera_.width - 1 &&
           pixel.y() <= camera_.height - 1;
  }

  TrueCamera camera_;
  Eigen::Isometry3d T_cam_world_;
  Eigen::Vector3d centre_;
};

std::array<std::uint8_t, 3> displayed(const Eigen::Vector3f& linear_bgr) {
  const auto encoded = [](float value) {
    const double light = std::clamp(static_cast<double>(value), 0.0, 1.0);
    return static_cast<std::uint8_t>(std::lround(255 * srgbOf(light)));
  };
  return {encoded(linear_bgr[2]), encoded(linear_bgr[1]), encoded(linear_bgr[0])};
}

cv::Mat visibleHeights(const Scene& scene, const Grid& grid,
                       const std::vector<Witness>& witnesses) {
  cv::Mat heights(grid.rows, grid.columns, CV_32FC1,
                  cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  tbb::parallel_for(0, grid.rows, [&](int row) {
    std::size_t last = 0;  // the neighbour's witness has probably seen this cell too
    for (int column = 0; column < grid.columns; ++column) {
      const Eigen::Vector2d xy = grid.centre(column, row);
      const double z = scene.surfaceHeight(xy.x(), xy.y());
      if (!std::isfinite(z)) continue;
      const Eigen::Vector3d point(xy.x(), xy.y(), z);
      for (std::size_t i = 0; i < witnesses.size(); ++i) {
        const std::size_t k = (last + i) % witnesses.size();
        if (!witnesses[k].sees(point, scene)) continue;
        heights.at<float>(row, column) = static_cast<float>(z);
        last = k;
        break;
      }
    }
  });
  return heights;
}

void writeCloud(const Scene& scene, const Grid& grid, const cv::Mat& heights,
                const std::filesystem::path& file) {
  PlyWriter ply(file);
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const float z = heights.at<float>(row, column);
      if (std::isnan(z)) continue;
      const Eigen::Vector2d xy = grid.centre(column, row);
      const Eigen::Vector3d above(xy.x(), xy.y(), z + 1.0);
      const auto hit = scene.hit(above, -Eigen::Vector3d::UnitZ());
      const Eigen::Vector3f light =
          hit ? scene.radiance(*hit, grid.spacing) : Eigen::Vector3f(0.5F, 0.5F, 0.5F);
      ply.add({static_cast<float>(xy.x()), static_cast<float>(xy.y()), z}, displayed(light));
    }
  ply.close();
}

/// The grid's place in UTM: exact at the world's origin, turned and scaled as the ENU axes are
/// there.
std::array<double, 6> geotransformOf(const Grid& grid, const LocalFrame& world,
                                     const UtmZone& zone) {
  constexpr double kArm_m = 100;
  const auto utm = [&](double e, double n) {
    const Geodetic place = world.toGeodetic(Eigen::Vector3d(e, n, 0));
    const auto p = geodeticToUtm(zone, place);
    if (!p) throw RunError("the world's origin has no place in UTM: " + p.failure().detail);
    return Eigen::Vector2d(p->easting_m, p->northing_m);
  };
  const Eigen::Vector2d o = utm(0, 0);
  const Eigen::Vector2d east = (utm(kArm_m, 0) - o) / kArm_m, north = (utm(0, kArm_m) - o) / kArm_m;
  const Eigen::Vector2d corner = o + grid.west * east + grid.north * north;
  const Eigen::Vector2d right = grid.spacing * east, down = -grid.spacing * north;
  return {corner.x(), right.x(), down.x(), corner.y(), right.y(), down.y()};
}

}  // namespace

void writeReferenceSurface(const Scene& scene, const std::vector<PlannedUav>& uavs,
                           const LocalFrame& world, double spacing_m,
                           const std::filesystem::path& truth) {
  const Grid grid = gridOver(scene.area(), spacing_m);
  std::vector<Witness> witnesses;
  for (const PlannedUav& uav : uavs)
    for (const PlannedPhoto& photo : uav.photos)
      witnesses.emplace_back(uav.camera, photo.motion.T_world_cam);
  FloatRaster dsm;
  dsm.values = visibleHeights(scene, grid, witnesses);
  writeCloud(scene, grid, dsm.values, truth / "cloud.ply");

  const UtmZone zone = utmZoneOf(world.origin().latitude_deg, world.origin().longitude_deg);
  dsm.metadata = {{"ORIGIN_E", fmt::format("{}", grid.west)},
                  {"ORIGIN_N", fmt::format("{}", grid.north)},
                  {"SPACING", fmt::format("{}", grid.spacing)}};
  dsm.geotransform = geotransformOf(grid, world, zone);
  dsm.crs_wkt_or_epsg = fmt::format("EPSG:{}", zone.epsg());
  writeFloatRaster(truth / "dsm.tif", dsm);
}

}  // namespace cf
