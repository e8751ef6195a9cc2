// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// What a run hands over, read as other programs do: COLMAP's model by its documentation (and by
// COLMAP, where it is installed), shots.geojson, and map.kml by GDAL.
#include <gdal/gdal_priv.h>
#include <gdal/ogrsf_frmts.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/formats/camera_ini.h"
#include "cf/formats/tum.h"
#include "cf/geodesy/utm.h"
#include "cf/pipeline/flight_run.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

struct ColmapCamera {
  std::string model;
  int width = 0, height = 0;
  std::vector<double> parameters;

  /// The documentation's OPENCV: fx fy cx cy k1 k2 p1 p2; (0, 0) is the image's corner.
  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    const auto& v = parameters;
    const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
    const double radial = v[4] * r2 + v[5] * r2 * r2;
    return {v[0] * (x + x * radial + 2 * v[6] * x * y + v[7] * (r2 + 2 * x * x)) + v[2],
            v[1] * (y + y * radial + 2 * v[7] * x * y + v[6] * (r2 + 2 * y * y)) + v[3]};
  }
};

struct ColmapImage {
  Eigen::Isometry3d T_cam_world = Eigen::Isometry3d::Identity();
  int camera = 0;
  std::string name;
  struct Sight {
    Eigen::Vector2d pixel;
    long point;
  };
  std::vector<Sight> sights;
};

struct ColmapPoint {
  Eigen::Vector3d position;
  double error_px = 0;
  std::vector<std::pair<int, std::size_t>> track;
};

struct ColmapModel {
  std::map<int, ColmapCamera> cameras;
  std::map<int, ColmapImage> images;
  std::map<long, ColmapPoint> points;
};

std::vector<std::string> linesOf(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    if (line.empty() || line[0] != '#') lines.push_back(line);
  return lines;
}

ColmapModel readColmap(const fs::path& folder) {
  ColmapModel model;
  for (const std::string& line : linesOf(folder / "cameras.txt")) {
    std::istringstream in(line);
    int id = 0;
    ColmapCamera camera;
    in >> id >> camera.model >> camera.width >> camera.height;
    for (double value = 0; in >> value;) camera.parameters.push_back(value);
    model.cameras[id] = camera;
  }
  const std::vector<std::string> lines = linesOf(folder / "images.txt");
  for (std::size_t i = 0; i + 1 < lines.size(); i += 2) {
    std::istringstream first(lines[i]), second(lines[i + 1]);
    int id = 0;
    ColmapImage image;
    Eigen::Quaterniond q;
    Eigen::Vector3d t;
    first >> id >> q.w() >> q.x() >> q.y() >> q.z() >> t.x() >> t.y() >> t.z() >> image.camera >>
        image.name;
    EXPECT_NEAR(q.norm(), 1, 1e-9);
    image.T_cam_world.linear() = q.toRotationMatrix();
    image.T_cam_world.translation() = t;
    ColmapImage::Sight sight;
    while (second >> sight.pixel.x() >> sight.pixel.y() >> sight.point)
      image.sights.push_back(sight);
    model.images[id] = image;
  }
  for (const std::string& line : linesOf(folder / "points3D.txt")) {
    std::istringstream in(line);
    long id = 0;
    int r = 0, g = 0, b = 0;
    ColmapPoint point;
    in >> id >> point.position.x() >> point.position.y() >> point.position.z() >> r >> g >> b >>
        point.error_px;
    std::pair<int, std::size_t> sight;
    while (in >> sight.first >> sight.second) point.track.push_back(sight);
    model.points[id] = point;
  }
  return model;
}

class HandOver : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    setLogQuiet(true);
    folder_ = std::make_unique<support::TempFolder>();
    support::writeSyntheticFlight(*folder_ / "in");
    run(false, true);
    model_ = readColmap(out("colmap"));
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static void run(bool overwrite, bool handover) {
    Config config = Config::fromFile(*folder_ / "in/config.ini");
    for (const char* setting : {"view.snapshots=0", "deliver.orthophoto=0",
                                "densify.megapixels=0.1", "world.origin=46.801, -91.899, 190"})
      config.override(setting);
    if (!handover) config.override("deliver.handover=0");
    runFlight(config, {out(""), overwrite, "1.2.3"});
  }
  static fs::path out(const std::string& file) { return *folder_ / "out" / file; }

  /// <uav>/<photo> and its pose.
  static std::map<std::string, Eigen::Isometry3d> poses() {
    std::map<std::string, Eigen::Isometry3d> poses;
    for (const auto& uav : support::syntheticFlight().uavs) {
      const auto track = readTum(out("trajectories/" + uav.name + ".tum"));
      EXPECT_EQ(track.size(), uav.photos.size());
      for (std::size_t i = 0; i < std::min(track.size(), uav.photos.size()); ++i)
        poses[uav.name + "/" + uav.photos[i].name] = track[i].T_world_cam;
    }
    return poses;
  }
  static LocalFrame world() { return {46.801, -91.899, 190}; }

  static std::unique_ptr<support::TempFolder> folder_;
  static ColmapModel model_;
};
std::unique_ptr<support::TempFolder> HandOver::folder_;
ColmapModel HandOver::model_;

TEST_F(HandOver, TheColmapModelHasThePhotosAndCamerasOfTheRun) {
  const auto expected = poses();
  ASSERT_EQ(model_.images.size(), expected.size());
  for (const auto& [id, image] : model_.images) {
    const auto pose = expected.find(image.name);
    ASSERT_NE(pose, expected.end()) << image.name;
    EXPECT_TRUE((image.T_cam_world * pose->second).isApprox(Eigen::Isometry3d::Identity(), 1e-5));
    EXPECT_TRUE(fs::is_regular_file(out("colmap/images/" + image.name)));
  }
  ASSERT_EQ(model_.cameras.size(), 3u);
  int number = 0;
  for (const auto& uav : support::syntheticFlight().uavs) {
    const CameraModel told = readCameraIni(out("cameras/" + uav.name + ".ini"));
    const ColmapCamera& camera = model_.cameras.at(++number);
    EXPECT_EQ(camera.model, "OPENCV");
    ASSERT_EQ(camera.parameters.size(), 8u);
    EXPECT_EQ(camera.width, told.width);
    EXPECT_EQ(camera.height, told.height);
    const Eigen::Vector3d p(0.3, -0.2, 1);
    EXPECT_LT((camera.project(p) - told.project(p) - Eigen::Vector2d(0.5, 0.5)).norm(), 1e-6);
  }
  EXPECT_NE(support::fileText(out("colmap/origin.txt")).find("longitude_deg = -91.899"),
            std::string::npos);
}

TEST_F(HandOver, PointsAndSightsOfTheColmapModelAgree) {
  ASSERT_GT(model_.points.size(), 500u);
  std::size_t sights = 0, observations = 0;
  for (const auto& [id, image] : model_.images) {
    sights += image.sights.size();
    for (std::size_t i = 0; i < image.sights.size(); ++i) {
      const auto point = model_.points.find(image.sights[i].point);
      ASSERT_NE(point, model_.points.end());
      const auto& track = point->second.track;
      EXPECT_EQ(std::count(track.begin(), track.end(), std::pair(id, i)), 1);
    }
  }
  double squares = 0;
  Eigen::Vector2d mean(0, 0);
  for (const auto& [id, point] : model_.points) {
    ASSERT_GE(point.track.size(), 2u);
    double error = 0;
    for (const auto& [number, place] : point.track) {
      const ColmapImage& image = model_.images.at(number);
      ASSERT_LT(place, image.sights.size());
      EXPECT_EQ(image.sights[place].point, id);
      const Eigen::Vector2d e =
          model_.cameras.at(image.camera).project(image.T_cam_world * point.position) -
          image.sights[place].pixel;
      EXPECT_LT(e.norm(), 2.2) << "what localisation takes, in pixels of a photo this small";
      error += e.norm();
      squares += e.squaredNorm();
      mean += e;
    }
    observations += point.track.size();
    EXPECT_NEAR(point.error_px, error / static_cast<double>(point.track.size()), 2e-3);
  }
  EXPECT_EQ(sights, observations);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(observations)), 0.5);
  EXPECT_LT((mean / static_cast<double>(observations)).norm(), 0.02) << "half a pixel forgotten?";
}

TEST_F(HandOver, ColmapItselfReadsTheModelAndUndistortsWithIt) {
  if (support::runCommand("colmap help").status != 0) GTEST_SKIP() << "colmap is not installed";
  const auto said =
      support::runCommand("colmap model_analyzer --path '" + out("colmap").string() + "'");
  ASSERT_EQ(said.status, 0) << said.output;
  EXPECT_NE(said.output.find("Registered images: 15"), std::string::npos) << said.output;
  EXPECT_NE(said.output.find("Points: " + std::to_string(model_.points.size())), std::string::npos)
      << said.output;
  const std::string key = "Mean reprojection error: ";
  const std::size_t at = said.output.find(key);
  ASSERT_NE(at, std::string::npos) << said.output;
  EXPECT_LT(std::stod(said.output.substr(at + key.size())), 0.5);
  const auto undistorted = support::runCommand(
      "colmap image_undistorter --input_path '" + out("colmap").string() + "' --image_path '" +
      out("colmap/images").string() + "' --output_path '" + (*folder_ / "dense").string() + "'");
  ASSERT_EQ(undistorted.status, 0) << undistorted.output;
  for (const auto& [name, pose] : poses())
    EXPECT_TRUE(fs::is_regular_file(*folder_ / "dense/images" / name)) << name;
}

TEST_F(HandOver, ShotsStandWhereThePhotosWereTaken) {
  const auto shots = nlohmann::json::parse(support::fileText(out("shots.geojson")));
  EXPECT_EQ(shots["type"], "FeatureCollection");
  auto expected = poses();
  ASSERT_EQ(shots["features"].size(), expected.size());
  for (const auto& shot : shots["features"]) {
    const auto& told = shot["properties"];
    const std::string uav = told["uav"], photo = told["filename"];
    const auto pose = expected.find(uav + "/" + photo);
    ASSERT_NE(pose, expected.end()) << uav << "/" << photo;
    const Eigen::Vector3d centre = pose->second.translation();
    const auto& place = shot["geometry"]["coordinates"];
    EXPECT_EQ(shot["geometry"]["type"], "Point");
    EXPECT_LT((world().toEnu(place[1], place[0], place[2]) - centre).norm(), 1e-3);
    const auto& utm = told["translation"];
    const auto by_grid = utmToGeodetic({15, true}, utm[0], utm[1], utm[2]);
    ASSERT_TRUE(by_grid.ok());
    EXPECT_LT((world().toEnu(*by_grid) - centre).norm(), 1e-3);
    // The grid's north is not the meridian's.
    const auto here = geodeticToUtm({15, true}, world().toGeodetic(centre));
    const auto north =
        geodeticToUtm({15, true}, world().toGeodetic(centre + Eigen::Vector3d(0, 10, 0)));
    const double turn = std::atan2(north->easting_m - here->easting_m,  // clockwise
                                   north->northing_m - here->northing_m);
    EXPECT_GT(std::abs(turn), 1e-3);
    const Eigen::Vector3d v(told["rotation"][0], told["rotation"][1], told["rotation"][2]);
    const Eigen::Matrix3d R_cam_grid =
        Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix();
    const Eigen::Matrix3d R_grid_world =
        Eigen::AngleAxisd(-turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Matrix3d off = R_cam_grid * R_grid_world * pose->second.linear();
    EXPECT_LT(Eigen::AngleAxisd(off).angle(), 1e-4);
    const CameraModel camera = readCameraIni(out("cameras/" + uav + ".ini"));
    EXPECT_EQ(told["camera"], uav);
    EXPECT_NEAR(told["focal"].get<double>(), camera.fx / camera.width, 1e-9);
    EXPECT_EQ(told["width"], camera.width);
    EXPECT_EQ(told["height"], camera.height);
    EXPECT_NEAR(told["capture_time"].get<double>(), 1466699519, 20);
    expected.erase(pose);
  }
}

TEST_F(HandOver, TheKmlHasTracksPhotosAndTheOutline) {
  GDALAllRegister();
  const std::unique_ptr<GDALDataset> kml(GDALDataset::Open(out("map.kml").c_str(), GDAL_OF_VECTOR));
  ASSERT_TRUE(kml);
  const auto place = [](const OGRPoint& p) { return world().toEnu(p.getY(), p.getX(), p.getZ()); };
  const auto expected = poses();
  int tracks = 0, photos = 0, outlines = 0;
  for (OGRLayer* layer : kml->GetLayers())
    for (const auto& feature : *layer) {
      const std::string name = feature->GetFieldAsString("Name");
      const OGRGeometry* geometry = feature->GetGeometryRef();
      ASSERT_NE(geometry, nullptr) << name;
      if (const auto* point = dynamic_cast<const OGRPoint*>(geometry)) {
        const auto pose = expected.find(std::string(layer->GetName()) + "/" + name);
        ASSERT_NE(pose, expected.end()) << name;
        EXPECT_LT((place(*point) - pose->second.translation()).norm(), 2e-3);
        ++photos;
      } else if (const auto* polygon = dynamic_cast<const OGRPolygon*>(geometry)) {
        const OGRLinearRing& ring = *polygon->getExteriorRing();
        EXPECT_TRUE(ring.get_IsClosed());
        EXPECT_TRUE(ring.getNumPoints() > 6);
        const Eigen::Vector3d middle = world().toEnu(support::SyntheticFlight::origin());
        double area = 0, farthest = 0;
        for (int i = 0; i + 1 < ring.getNumPoints(); ++i) {
          OGRPoint a, b;
          ring.getPoint(i, &a);
          ring.getPoint(i + 1, &b);
          const Eigen::Vector3d from = place(a) - middle, to = place(b) - middle;
          EXPECT_GT(from.x() * to.y() - from.y() * to.x(), 0) << "all around the scene";
          area += (from.x() * to.y() - from.y() * to.x()) / 2;
          farthest = std::max(farthest, from.head<2>().norm());
        }
        EXPECT_GT(area, 1000);
        EXPECT_LT(farthest, 60);
        ++outlines;
      } else if (const auto* line = dynamic_cast<const OGRLineString*>(geometry)) {
        EXPECT_EQ(name, layer->GetName());
        EXPECT_EQ(line->getNumPoints(), 5);
        ++tracks;
      }
    }
  EXPECT_EQ(tracks, 3);
  EXPECT_EQ(photos, 15);
  EXPECT_EQ(outlines, 1);
}

/// Last: the result is replaced.
TEST_F(HandOver, WhatIsReplacedIsTheResultAndNotThePhotos) {
  run(true, false);
  for (const char* file : {"colmap/images.txt", "colmap/images/northA", "shots.geojson", "map.kml"})
    EXPECT_FALSE(fs::exists(fs::symlink_status(out(file)))) << file;
  for (const auto& uav : support::syntheticFlight().uavs)
    for (const auto& photo : uav.photos)
      EXPECT_TRUE(fs::exists(*folder_ / "in" / (uav.name + "_Images") / photo.name));
}

}  // namespace
}  // namespace cf
