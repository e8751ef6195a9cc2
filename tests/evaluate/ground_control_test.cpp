// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Two UAVs with different cameras, and marks that are exact but for one known fault each.
#include "cf/evaluate/ground_control.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "cf/base/time.h"
#include "cf/formats/tum.h"
#include "cf/geodesy/local_frame.h"
#include "cf/geodesy/utm.h"
#include "cf/types/camera_model.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using nlohmann::json;

struct Faults {
  double map_scale = 1;                                   ///< of poses about the origin
  Eigen::Vector3d map_shift_m = Eigen::Vector3d::Zero();  ///< of poses
  double first_mark_px = 0;                               ///< to the right
  double list_scale = 1;       ///< the list was made in photos so many times as large
  bool same_names = false;     ///< both UAVs have photos of one name
  bool say_uav = false;        ///< the list calls photos <uav>/<name>
  bool first_unposed = false;  ///< the first photo of UAV a
};

class GroundControl : public ::testing::Test {
 protected:
  static constexpr int kPhotos = 4;

  void write(const Faults& faults) {
    support::writeText(
        out() / "world.json",
        R"({"origin": {"lat": 28.041, "lon": -82.698, "h": 12}, "h_datum": "unknown"})");
    std::vector<std::string> marks(points_.size());
    for (const bool second : {false, true}) writeUav(second, faults, marks);
    std::string list = "+proj=utm +zone=17 +datum=WGS84 +units=m\n";
    for (const std::string& of_point : marks) list += of_point;
    support::writeText(list_, list);
  }

  json evaluate(std::optional<AlignmentModel> align = {}, std::optional<PhotoSize> size = {}) {
    return json::parse(evaluateGroundControl(out(), list_, {align, size}));
  }
  template <class Error>
  std::string errorOf(std::optional<AlignmentModel> align = {}) {
    try {
      static_cast<void>(evaluate(align));
    } catch (const Error& e) {
      return e.what();
    }
    return "no such error";
  }

  std::filesystem::path out() const { return folder_ / "out"; }

  support::TempFolder folder_;
  const std::filesystem::path list_ = folder_ / "gcp_list.txt";
  const std::vector<Eigen::Vector3d> points_ = {
      {-12, 9, 1}, {14, 11, -2}, {13, -10, 0.5}, {-11, -9, 3}, {1, 2, -1}};

 private:
  static CameraModel cameraOf(bool second) {
    CameraModel camera;
    camera.width = second ? 1000 : 400;
    camera.height = second ? 750 : 300;
    camera.fx = camera.fy = second ? 900 : 320;
    camera.cx = camera.width / 2.0 + 3;
    camera.cy = camera.height / 2.0 - 2;
    camera.k1 = second ? 0.02 : -0.05;
    camera.p1 = 1e-3;
    return camera;
  }

  static Eigen::Isometry3d poseOf(bool second, int k) {
    const double w = std::sin(2.0 * k + (second ? 1 : 0));
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translate(second ? Eigen::Vector3d(w, 10.0 * k - 15, 70 + 3 * w)
                       : Eigen::Vector3d(10.0 * k - 15, w, 50 + 3 * w));
    T.rotate(Eigen::AngleAxisd(M_PI + 0.03 * w, Eigen::Vector3d::UnitX()));
    T.rotate(Eigen::AngleAxisd(second ? 1.5 : 0.2 * w, Eigen::Vector3d::UnitZ()));
    return T;
  }

  void writeUav(bool second, const Faults& faults, std::vector<std::string>& marks) {
    const std::string uav = second ? "b" : "a";
    const CameraModel camera = cameraOf(second);
    support::writeText(out() / "cameras" / (uav + ".ini"),
                       fmt::format("[before]\nfx = 1\n[camera]\nwidth = {}\nheight = {}\nfx = {}\n"
                                   "cx = {}\ncy = {}\nk1 = {}\np1 = {}\n",
                                   camera.width, camera.height, camera.fx, camera.cx, camera.cy,
                                   camera.k1, camera.p1));
    std::string images = "image,t,status,segment,keypoints,matches,inliers,reason\n";
    std::vector<TimedPose> poses;
    for (int k = 0; k < kPhotos; ++k) {
      const bool unposed = faults.first_unposed && !second && k == 0;
      const std::string name = fmt::format("{}{}.jpg", faults.same_names ? "p" : uav, k);
      const TimeNs time = (1'780'308'000 + k) * kNsPerSecond;
      images +=
          fmt::format("{},{},{},0,9,9,9,\n", name, timeText(time), unposed ? "unposed" : "posed");
      Eigen::Isometry3d T = poseOf(second, k);
      mark(camera, T, faults, (faults.say_uav ? uav + "/" : "") + name, marks);
      T.translation() = faults.map_scale * T.translation() + faults.map_shift_m;
      if (!unposed) poses.push_back({time, T});
    }
    support::writeText(out() / "images" / (uav + ".csv"), images);
    std::filesystem::create_directories(out() / "trajectories");
    writeTum(out() / "trajectories" / (uav + ".tum"), poses);
  }

  void mark(const CameraModel& camera, const Eigen::Isometry3d& T_world_cam, const Faults& faults,
            const std::string& image, std::vector<std::string>& marks) {
    const LocalFrame world(28.041, -82.698, 12);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Eigen::Vector2d pixel = camera.project(T_world_cam.inverse() * points_[i]);
      ASSERT_TRUE(camera.contains(pixel));
      if (i == 0 && marks[0].empty()) pixel.x() += faults.first_mark_px;
      pixel = ((pixel.array() + 0.5) * faults.list_scale - 0.5).matrix();
      const Geodetic p = world.toGeodetic(points_[i]);
      const auto utm = geodeticToUtm({17, true}, p);
      marks[i] += fmt::format("{:.7f} {:.7f} {:.7f} {:.7f} {:.7f} {} point_{}\n", utm->easting_m,
                              utm->northing_m, p.height_m, pixel.x(), pixel.y(), image, i);
    }
  }
};

TEST_F(GroundControl, ExactMarksMeetInTheSurveyedPoints) {
  write({});
  for (const auto& align : {std::optional<AlignmentModel>(), std::optional(AlignmentModel::kSe3),
                            std::optional(AlignmentModel::kSim3)}) {
    const json f = evaluate(align);
    EXPECT_EQ(f["points"], 5);
    EXPECT_EQ(f["triangulated"], 5);
    EXPECT_EQ(f["across_uavs"], 5);
    EXPECT_EQ(f["marks"], 40);
    EXPECT_NEAR(f["max_px"].get<double>(), 0, 1e-4);
    EXPECT_NEAR(f["difference_m"]["rms"].get<double>(), 0, 1e-5);
    EXPECT_NEAR(f["scale"].get<double>(), 1, 1e-6);
    EXPECT_TRUE(f["missing"].empty());
    EXPECT_TRUE(f["photos_without_pose"].empty());
    EXPECT_EQ(f["per_uav"]["b"]["marks"], 20);
  }
  const json point = evaluate()["per_point"][1];
  EXPECT_EQ(point["name"], "point_1");
  EXPECT_EQ(point["uavs"], 2);
  EXPECT_EQ(point["sights"].size(), 8u);
  for (std::size_t i = 0; i < 3; ++i) {
    const double truth = points_[1][static_cast<Eigen::Index>(i)];
    EXPECT_NEAR(point["position_m"][i].get<double>(), truth, 1e-5);
    EXPECT_NEAR(point["surveyed_m"][i].get<double>(), truth, 1e-5);
  }
  EXPECT_GT(point["angle_deg"].get<double>(), 15);
}

TEST_F(GroundControl, AMapShiftedOrTooLargeDiffersFromTheSurveyOnly) {
  Faults faults;
  faults.map_shift_m = {1, -2, 5};
  write(faults);
  json f = evaluate();
  EXPECT_NEAR(f["max_px"].get<double>(), 0, 1e-4);
  EXPECT_NEAR(f["difference_m"]["mean"][1].get<double>(), -2, 1e-5);
  EXPECT_NEAR(f["difference_m"]["vertical_rms"].get<double>(), 5, 1e-5);
  EXPECT_NEAR(f["difference_m"]["horizontal_rms"].get<double>(), std::sqrt(5), 1e-5);
  EXPECT_NEAR(evaluate(AlignmentModel::kSe3)["difference_m"]["rms"].get<double>(), 0, 1e-5);

  faults.map_scale = 1.02;
  write(faults);
  f = evaluate(AlignmentModel::kSe3);
  EXPECT_NEAR(f["max_px"].get<double>(), 0, 1e-4);
  EXPECT_NEAR(f["per_point"][0]["difference_m"][0].get<double>(), -0.02 * 13, 0.01);
  f = evaluate(AlignmentModel::kSim3);
  EXPECT_NEAR(f["scale"].get<double>(), 1 / 1.02, 1e-6);
  EXPECT_NEAR(f["difference_m"]["rms"].get<double>(), 0, 1e-5);
}

TEST_F(GroundControl, OneBadMarkIsTheWorst) {
  Faults faults;
  faults.first_mark_px = 8;
  write(faults);
  const json f = evaluate();
  const json bad = f["per_point"][0]["sights"][0];
  EXPECT_EQ(bad["image"], "a0.jpg");
  // The point is drawn after the mark a little, not by most of it.
  const double error =
      std::hypot(bad["error_px"][0].get<double>(), bad["error_px"][1].get<double>());
  EXPECT_NEAR(f["max_px"].get<double>(), error, 1e-9);
  EXPECT_LT(bad["error_px"][0].get<double>(), -5);
  EXPECT_GE(bad["error_px"][0].get<double>(), -8);
  // Least squares: no more than the mark itself would leave at the true place.
  EXPECT_LT(f["rms_px"].get<double>(), 8 / std::sqrt(40));
  EXPECT_GT(f["rms_px"].get<double>(), 5 / std::sqrt(40));
  EXPECT_NEAR(f["per_point"][1]["max_px"].get<double>(), 0, 1e-4);
}

TEST_F(GroundControl, MarksMadeInLargerPhotos) {
  Faults faults;
  faults.list_scale = 10;
  write(faults);
  EXPECT_NE(errorOf<RunError>().find("--size"), std::string::npos);
  EXPECT_THROW(static_cast<void>(evaluate({}, PhotoSize{4000, 2250})), RunError);
  // One size for all photos: just those of UAV a.
  std::string list = support::fileText(list_), of_a;
  for (std::size_t begin = 0, end; (end = list.find('\n', begin)) != std::string::npos;
       begin = end + 1)
    if (list.substr(begin, end - begin).find(" b") == std::string::npos)
      of_a += list.substr(begin, end + 1 - begin);
  support::writeText(list_, of_a);
  const json f = evaluate({}, PhotoSize{4000, 3000});
  EXPECT_EQ(f["marks"], 20);
  EXPECT_EQ(f["across_uavs"], 0);
  EXPECT_NEAR(f["max_px"].get<double>(), 0, 1e-3);
  EXPECT_NEAR(f["difference_m"]["rms"].get<double>(), 0, 1e-4);
}

TEST_F(GroundControl, PhotosOfOneNameNeedTheirUav) {
  Faults faults;
  faults.same_names = true;
  faults.say_uav = true;
  write(faults);
  const json f = evaluate();
  EXPECT_EQ(f["marks"], 40);
  EXPECT_NEAR(f["max_px"].get<double>(), 0, 1e-4);

  std::string list = support::fileText(list_);
  for (std::size_t at; (at = list.find("a/p")) != std::string::npos;) list.erase(at, 2);
  support::writeText(list_, list);
  EXPECT_NE(errorOf<UsageError>().find("a/p0.jpg"), std::string::npos);
}

TEST_F(GroundControl, WhatHasNoPoseIsSaid) {
  Faults faults;
  faults.first_unposed = true;
  write(faults);
  std::string list = support::fileText(list_);
  list += "333000 3102900 3 1 2 a1.jpg alone\n333000 3102900 3 1 2 nowhere.jpg alone\n";
  support::writeText(list_, list);
  const json f = evaluate();
  EXPECT_EQ(f["points"], 6);
  EXPECT_EQ(f["triangulated"], 5);
  EXPECT_EQ(f["marks"], 35);
  EXPECT_EQ(f["photos_without_pose"], json({"a0.jpg", "nowhere.jpg"}));
  EXPECT_FALSE(f["missing"]["alone"].get<std::string>().empty());
}

TEST_F(GroundControl, FilesThatAreNotWhatTheyShouldBeAreNamed) {
  write({});
  const std::string list = support::fileText(list_);
  support::writeText(list_, "EPSG:3857\n1 2 3 4 5 a0.jpg\n");
  EXPECT_NE(errorOf<UsageError>().find("EPSG:3857"), std::string::npos);
  support::writeText(list_, "EPSG:4326\n-82.7 28 3 4 5 x.jpg\n");
  EXPECT_NE(errorOf<RunError>().find("no point is marked in two photos"), std::string::npos);
  // Two points determine no rotation.
  std::size_t third = list.find("point_2");
  support::writeText(list_, list.substr(0, list.rfind('\n', third) + 1));
  EXPECT_NE(errorOf<RunError>(AlignmentModel::kSe3).find("cannot be aligned"), std::string::npos);
  EXPECT_EQ(evaluate()["triangulated"], 2);
  support::writeText(out() / "world.json", "{}");
  EXPECT_NE(errorOf<RunError>().find("world.json"), std::string::npos);
  std::filesystem::remove(out() / "cameras" / "b.ini");
  write({});
  std::filesystem::remove(out() / "cameras" / "b.ini");
  EXPECT_NE(errorOf<RunError>().find("b.ini"), std::string::npos);
}

}  // namespace
}  // namespace cf
