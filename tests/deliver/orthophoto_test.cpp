// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/orthophoto.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "cf/formats/geotiff.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

/// Flat ground with a box of 12 m; the ground is painted by a function of its place in the world,
/// the box's roof red. Photos are made of it ray by ray, with a gain each.
constexpr double kRoof_m = 12;

bool onBox(double x, double y) { return std::abs(x - 5) < 6 && std::abs(y) < 4; }

cv::Vec3d groundColour(double x, double y) {
  return {110 + 50 * std::sin(x / 4), 110 + 50 * std::sin(y / 5), 60 + 0.5 * x};
}

cv::Vec3d colourSeen(const Eigen::Vector3d& c, const Eigen::Vector3d& direction) {
  // The roof, a wall, or the ground: the first that the ray meets.
  const double to_roof = (kRoof_m - c.z()) / direction.z();
  const Eigen::Vector3d roof = c + to_roof * direction;
  if (onBox(roof.x(), roof.y())) return {40, 40, 200};
  const double to_ground = -c.z() / direction.z();
  constexpr int kSteps = 60;
  for (int i = 1; i < kSteps; ++i) {
    const Eigen::Vector3d p = c + (to_roof + (to_ground - to_roof) * i / kSteps) * direction;
    if (onBox(p.x(), p.y())) return {230, 230, 230};  // white walls
  }
  const Eigen::Vector3d ground = c + to_ground * direction;
  return groundColour(ground.x(), ground.y());
}

struct Flight {
  std::vector<OrthoPhoto> photos;
  std::vector<cv::Mat> images;
};

CameraModel camera() {
  CameraModel c;
  c.width = 400;
  c.height = 300;
  c.fx = c.fy = 300;
  c.cx = 202;
  c.cy = 147;
  c.k1 = -0.05;
  return c;
}

/// 4 x 3 photos from 60 m, looking down, tilted a little.
Flight flight() {
  Flight out;
  for (int i = 0; i < 12; ++i) {
    OrthoPhoto photo;
    photo.camera = camera();
    photo.T_world_cam.linear() =
        (Eigen::AngleAxisd(0.4 * i, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(M_PI + 0.03 * std::sin(i), Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    photo.T_world_cam.translation() = Eigen::Vector3d(-30 + 20 * (i % 4), -20 + 20 * (i / 4), 60);
    cv::Mat image(photo.camera.height, photo.camera.width, CV_8UC3);
    const double gain = std::exp(0.12 * std::sin(2.3 * i));
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector2d n = photo.camera.undistort(Eigen::Vector2d(u, v));
        const cv::Vec3d colour =
            gain * colourSeen(photo.T_world_cam.translation(),
                              photo.T_world_cam.linear() * Eigen::Vector3d(n.x(), n.y(), 1));
        for (int c = 0; c < 3; ++c)
          image.at<cv::Vec3b>(v, u)[c] = cv::saturate_cast<std::uint8_t>(colour[c]);
      }
    photo.thumbnail = orthoThumbnail(image);
    out.photos.push_back(photo);
    out.images.push_back(image);
  }
  return out;
}

/// The scene's true surface, 100 m x 80 m, in the grid; a small hole in the ground at (-20, -10).
void writeDsm(const std::filesystem::path& path, const GridFrame& grid) {
  const Eigen::Vector3d corner = grid.toGrid({-50, 40, 0});
  GeoTiffGrid raster{500, 400, std::floor(corner.x()), std::ceil(corner.y()), 0.2, ""};
  if (!grid.relative()) raster.crs = "EPSG:" + std::to_string(grid.epsg());
  GeoTiffWriter out(path, GeoTiffWriter::Kind::kHeights, raster, {});
  cv::Mat heights(raster.height, raster.width, CV_32FC1);
  for (int y = 0; y < raster.height; ++y)
    for (int x = 0; x < raster.width; ++x) {
      const double e = raster.left_m + (x + 0.5) * raster.cell_m;
      const double n = raster.top_m - (y + 0.5) * raster.cell_m;
      const Eigen::Vector3d p = grid.toWorld({e, n, corner.z()});
      const double z = onBox(p.x(), p.y()) ? kRoof_m : 0;
      heights.at<float>(y, x) = std::hypot(p.x() + 20, p.y() + 10) < 1.5
                                    ? std::nanf("")
                                    : static_cast<float>(grid.toGrid({p.x(), p.y(), z}).z());
    }
  out.write(0, 0, heights);
  out.close();
}

struct Picture {
  cv::Mat bgr;  ///< CV_8UC3
  double left = 0, top = 0, gsd = 0;
};

/// What a stock tool makes of it.
Picture opened(const std::filesystem::path& tif, const std::filesystem::path& raw) {
  Picture picture;
  const auto info = support::runCommand("gdalinfo -json '" + tif.string() + "'");
  const auto json = nlohmann::json::parse(info.output);
  const auto size = json["size"];
  picture.left = json["geoTransform"][0];
  picture.gsd = json["geoTransform"][1];
  picture.top = json["geoTransform"][3];
  support::runCommand("gdal_translate -q -of ENVI -co INTERLEAVE=BIP '" + tif.string() + "' '" +
                      raw.string() + "'");
  const std::string bytes = support::fileText(raw);
  cv::Mat rgb(size[1].get<int>(), size[0].get<int>(), CV_8UC3);
  EXPECT_EQ(bytes.size(), rgb.total() * 3);
  if (bytes.size() == rgb.total() * 3) std::copy(bytes.begin(), bytes.end(), rgb.data);
  picture.bgr = rgb;
  for (auto p = rgb.begin<cv::Vec3b>(); p != rgb.end<cv::Vec3b>(); ++p) std::swap((*p)[0], (*p)[2]);
  return picture;
}

class Orthophoto : public ::testing::Test {
 protected:
  void SetUp() override {
    if (support::runCommand("gdalinfo --version").status != 0)
      GTEST_SKIP() << "gdalinfo is not installed";
    writeDsm(folder_ / "dsm.tif", grid_);
  }
  void write(double gsd_m) {
    writeOrthophoto(
        folder_ / "ortho.tif", folder_ / "dsm.tif", grid_, flight_.photos,
        [&](std::size_t i) {
          ++decoded_;
          return flight_.images[i];
        },
        gsd_m);
  }
  cv::Vec3b at(const Picture& picture, double x, double y) const {
    const Eigen::Vector3d p = grid_.toGrid({x, y, 0});
    const int column = static_cast<int>(std::floor((p.x() - picture.left) / picture.gsd));
    const int row = static_cast<int>(std::floor((picture.top - p.y()) / picture.gsd));
    return picture.bgr.at<cv::Vec3b>(row, column);
  }

  const support::TempFolder folder_;
  // Grid north is 1.8 degrees off.
  const GridFrame grid_{LocalFrame(46.95, 11.4, 540), HeightDatum::kEllipsoid};
  const Flight flight_ = flight();
  std::atomic<int> decoded_{0};
};

TEST_F(Orthophoto, ShowsEveryPlaceWhereItIsInTheColourThatItHas) {
  write(0.1);
  EXPECT_EQ(decoded_, 12) << "each photo is decoded once";
  const Picture picture = opened(folder_ / "ortho.tif", folder_ / "raw");
  EXPECT_NEAR(picture.gsd, 0.1, 1e-9);
  // Gains are known up to one common factor.
  double ratio = 0;
  int count = 0, wrong = 0;
  for (int pass = 0; pass < 2; ++pass)
    for (double x = -38; x < 38; x += 0.7)
      for (double y = -28; y < 28; y += 0.7) {
        if (onBox(x, y) || onBox(x + 0.7, y) || onBox(x - 0.7, y) || onBox(x, y + 0.7) ||
            onBox(x, y - 0.7))
          continue;
        const cv::Vec3d expected = groundColour(x, y);
        const cv::Vec3b seen = at(picture, x, y);
        if (pass == 0) {
          ratio += seen[1] / expected[1];
          ++count;
          continue;
        }
        for (int c = 0; c < 3; ++c)
          if (std::abs(seen[c] - ratio / count * expected[c]) > 15) {
            ++wrong;
            break;
          }
      }
  ratio /= count;
  EXPECT_NEAR(ratio, 1, 0.1);
  EXPECT_LT(wrong, 0.015 * count) << "of " << count;
}

// A plain rectified photo would show the roof leaning over the ground, and white walls.
TEST_F(Orthophoto, RoofsStandOnTheirWallsAndHideNothing) {
  write(0.1);
  const Picture picture = opened(folder_ / "ortho.tif", folder_ / "raw");
  int roof = 0, roof_right = 0, around = 0, roof_or_wall = 0;
  for (double x = -8; x < 18; x += 0.2)
    for (double y = -10; y < 10; y += 0.2) {
      const cv::Vec3b c = at(picture, x, y);
      const bool red = c[2] > 120 && c[0] < 90 && c[1] < 90;
      const bool white = c[0] > 170 && c[1] > 170 && c[2] > 170;
      if (std::abs(x - 5) < 5.7 && std::abs(y) < 3.7) {
        ++roof;
        roof_right += red;
      } else if (std::abs(x - 5) > 6.4 || std::abs(y) > 4.4) {
        ++around;
        roof_or_wall += red || white;
      }
    }
  EXPECT_GT(roof_right, 0.99 * roof);
  EXPECT_LT(roof_or_wall, 0.005 * around) << "of " << around;
}

TEST_F(Orthophoto, HolesInTheSurfaceAreBridgedAndTheRestIsMasked) {
  write(0.2);
  const Picture picture = opened(folder_ / "ortho.tif", folder_ / "raw");
  const cv::Vec3b in_hole = at(picture, -20, -10);
  EXPECT_NEAR(in_hole[1], groundColour(-20, -10)[1], 25);
  const auto json = nlohmann::json::parse(
      support::runCommand("gdalinfo -json '" + (folder_ / "ortho.tif").string() + "'").output);
  EXPECT_EQ(json["stac"]["proj:epsg"], 32632);
  EXPECT_EQ(json["bands"][0]["mask"]["flags"], nlohmann::json({"PER_DATASET"}));
  EXPECT_FALSE(json["bands"][0]["overviews"].empty());
  // No photo sees the corners: masked there, not in the middle.
  support::runCommand("gdal_translate -q -of ENVI -b mask '" + (folder_ / "ortho.tif").string() +
                      "' '" + (folder_ / "mask").string() + "'");
  const std::string mask = support::fileText(folder_ / "mask");
  ASSERT_EQ(mask.size(), picture.bgr.total());
  EXPECT_EQ(mask.front(), 0);
  EXPECT_EQ(static_cast<std::uint8_t>(mask[mask.size() / 2 + 250]), 255);
}

TEST_F(Orthophoto, APhotoThatCannotBeReadLeavesNothingBehind) {
  int failed = 0;
  writeOrthophoto(
      folder_ / "ortho.tif", folder_ / "dsm.tif", grid_, flight_.photos,
      [&](std::size_t i) {
        failed += i == 5;
        return i == 5 ? cv::Mat() : flight_.images[i];
      },
      0.4);
  EXPECT_GT(failed, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "ortho.tif"));
}

}  // namespace
}  // namespace cf
