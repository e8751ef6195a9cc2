// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cf/base/time.h"
#include "cf/formats/csv.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/ply.h"
#include "cf/formats/pose_covariance_csv.h"
#include "cf/formats/tum.h"
#include "cf/types/camera_model.h"
#include "support/temp_folder.h"

namespace cf::support {

/// What a run may get wrong, each by a known amount.
struct Faults {
  double map_scale = 1;       ///< of poses, depths and cloud, about the origin
  double scale_estimate = 1;  ///< of the scales that georeferencing told
  Eigen::Vector3d shift_b_m = Eigen::Vector3d::Zero();
  double turn_b_deg = 0;  ///< about the vertical through the middle of UAV b
  double bend_per_m = 0;  ///< the ground at (x, y) rises by this times x^2 + y^2
  double focal = 1;       ///< factor
  double depth_offset_m = 0;
  int depth_rows_lost = 0;  ///< at the top of each depth map
  double cloud_rise_m = 0;
  int flying_every = 0;                    ///< of so many cloud points one flies
  double bias_common_m = 0, bias_b_m = 0;  ///< east, of the receivers as estimated
  double relative_turn_deg = 0;
  bool depth_maps = true, photo_lost = false;
  int photos = 8;  ///< of each UAV, at the same eight places again and again
};

/// Two UAVs over the plane z = 0, eight photos each (or more), as cf-simulate writes them: truth/,
/// and in out/ what a run made of it, exact but for the faults.
class SimulatedRun {
 public:
  static constexpr double kLocalUnits_m = 7;  ///< metres per VO unit
  static constexpr double kSigma_m = 0.5;
  /// As told of a pose, in the world and in the map.
  static constexpr double kPoseSigma_m = 0.4, kPoseSigma_rad = 0.002, kInMap = 0.1;
  static constexpr int kStep = 4;

  explicit SimulatedRun(const Faults& faults) : faults_(faults) {
    camera_.width = 400;
    camera_.height = 300;
    camera_.fx = camera_.fy = 320;
    camera_.cx = 199.5;
    camera_.cy = 149.5;
    camera_.k1 = -0.05;
    write(truth() / "world.json", kWorld);
    write(out() / "world.json", kWorld);
    write(out() / "config.effective.ini", "[densify]\nmegapixels = 0.03\nmatcher = sgm\n");
    for (const char* uav : {"a", "b"}) writeUav(uav);
    write(truth() / "images.tsv", images_);
    writeTum(truth() / "poses.tum", poses_);
    write(truth() / "gnss.json", "{" + gnss_ + "}");
    write(out() / "report.json", "{\"uavs\": {" + report_ + "}}");
    writeRelativePose();
    writeClouds();
  }

  std::filesystem::path truth() const { return folder_ / "truth"; }
  std::filesystem::path out() const { return folder_ / "out"; }
  const CameraModel& camera() const { return camera_; }

 private:
  static constexpr const char* kWorld =
      "{\"origin\": {\"lat\": 46.8, \"lon\": -91.9, \"h\": 200}, \"h_datum\": \"ellipsoid\"}";

  static void write(const std::filesystem::path& file, const std::string& text) {
    writeText(file, text);
  }

  /// Two strips of four photos, looking down but for a little.
  static Eigen::Isometry3d poseOf(bool second_uav, int k) {
    const double w = std::sin(2.0 * k + (second_uav ? 1 : 0));
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translate(Eigen::Vector3d((k / 4) * 14.0 + (second_uav ? 10 : -24),
                                (k % 4) * 10.0 - 15 + 2 * w, 50 + 3 * w));
    T.rotate(Eigen::AngleAxisd(M_PI + 0.03 * w, Eigen::Vector3d::UnitX()));
    T.rotate(Eigen::AngleAxisd(0.2 * w, Eigen::Vector3d::UnitZ()));
    return T;
  }

  /// The pose that the run tells.
  Eigen::Isometry3d wrong(const Eigen::Isometry3d& truth, bool second_uav) const {
    Eigen::Isometry3d T = truth;
    const Eigen::Vector3d ground(T.translation().x(), T.translation().y(), 0);
    const double k = faults_.bend_per_m;
    const Eigen::Vector3d up(-2 * k * ground.x(), -2 * k * ground.y(), 1);
    Eigen::Isometry3d bent = Eigen::Isometry3d::Identity();
    bent.translate(Eigen::Vector3d(ground + k * ground.squaredNorm() * Eigen::Vector3d::UnitZ()));
    bent.rotate(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up));
    T = bent * Eigen::Translation3d(-ground) * T;
    if (second_uav) {
      const Eigen::Vector3d middle(17, 0, 50);
      const Eigen::AngleAxisd turn(faults_.turn_b_deg * M_PI / 180, Eigen::Vector3d::UnitZ());
      T = Eigen::Translation3d(faults_.shift_b_m + middle) * turn * Eigen::Translation3d(-middle) *
          T;
    }
    T.translation() *= faults_.map_scale;
    return T;
  }

  std::string cameraText(const char* section, double focal) const {
    return fmt::format(
        "[{}]\nwidth = {}\nheight = {}\nfx = {}\ncx = {}\ncy = {}\nk1 = {}\n"
        "focal_sigma = 1.6\n",
        section, camera_.width, camera_.height, focal, camera_.cx, camera_.cy, camera_.k1);
  }

  void writeUav(const std::string& uav) {
    const bool second = uav == "b";
    std::vector<TimedPose> estimate, local;
    std::vector<PoseCovarianceRow> covariances;
    std::string images = "image,t,status,segment,keypoints,matches,inliers,reason\n";
    std::string scale = "t,segment,scale,sigma\n";
    for (int k = 0; k < faults_.photos; ++k) {
      const std::string name = fmt::format("{}_{:04}", uav, k);
      const TimeNs time = 1780308000 * kNsPerSecond + (2 * k + (second ? 1 : 0)) * kNsPerSecond;
      const Eigen::Isometry3d T = poseOf(second, k % 8);
      poses_.push_back({time, T});
      images_ += fmt::format("{}/{}.jpg\t{}\n", uav, name, timeText(time));
      writeDepth(uav, name, T);
      const bool lost = faults_.photo_lost && second && k == 7;
      images +=
          fmt::format("{}.jpg,{},{},0,9,9,9,\n", name, timeText(time), lost ? "unposed" : "posed");
      if (lost) continue;
      estimate.push_back({time, wrong(T, second)});
      PoseCovariance covariance;
      covariance.in_world.diagonal() << Eigen::Vector3d::Constant(kPoseSigma_m * kPoseSigma_m),
          Eigen::Vector3d::Constant(kPoseSigma_rad * kPoseSigma_rad);
      covariance.in_map = kInMap * kInMap * covariance.in_world;
      covariances.push_back({name + ".jpg", time, 0, covariance});
      Eigen::Isometry3d T_local = T;
      T_local.translation() = (T.translation() - Eigen::Vector3d(9, 8, 7)) / kLocalUnits_m;
      local.push_back({time, T_local});
      // The first photo has no scale yet; the second one's is 5 % off.
      if (k > 0)
        scale += fmt::format("{},0,{:.9f},0.07\n", timeText(time),
                             kLocalUnits_m * faults_.scale_estimate * (k == 1 ? 1.05 : 1));
    }
    std::filesystem::create_directories(out() / "trajectories");
    std::filesystem::create_directories(out() / "odometry");
    writeTum(out() / "trajectories" / (uav + ".tum"), estimate);
    writePoseCovariances(out() / "trajectories" / (uav + ".covariance.csv"), covariances);
    writeTum(out() / "odometry" / (uav + ".tum"), local);
    write(out() / "images" / (uav + ".csv"), images);
    write(out() / "scale" / (uav + ".csv"), scale);
    writeFixes(uav);
    write(truth() / "cameras" / (uav + ".ini"), cameraText("camera", camera_.fx));
    write(out() / "cameras" / (uav + ".ini"), cameraText("camera", camera_.fx * faults_.focal) +
                                                  cameraText("before", camera_.fx * 1.03));
    const std::string comma = gnss_.empty() ? "" : ", ";
    const double bias = second ? 1.5 : -0.5;
    gnss_ += fmt::format("{}\"{}\": {{\"sigma_m\": [{}, {}, 1], \"bias_m\": [{}, 0, 2]}}", comma,
                         uav, kSigma_m, kSigma_m, bias);
    report_ += fmt::format(
        "{}\"{}\": {{\"gnss_sigma_m\": [1, {}, 1], \"gnss_bias_m\": [{}, 0, 2]}}", comma, uav,
        kSigma_m, bias + faults_.bias_common_m + (second ? faults_.bias_b_m : 0));
  }

  /// Four fixes and an outlier, the last of them with the last photo.
  void writeFixes(const std::string& uav) {
    const TimeNs begin = 1780308000 * kNsPerSecond + (uav == "b" ? kNsPerSecond : 0);
    const TimeNs last = begin + 2 * (faults_.photos - 1) * kNsPerSecond;
    std::string text = "t,e,n,u,true_e,true_n,true_u,outlier\n";
    const std::array<std::array<int, 3>, 5> fixes = {
        {{0, 30, 0}, {0, -30, 0}, {900, 900, 1}, {40, 0, 0}, {-40, 0, 0}}};
    for (std::size_t i = 0; i < fixes.size(); ++i)
      text += fmt::format("{},0,0,0,{},{},50,{}\n",
                          timeText(i + 1 == fixes.size() ? last : begin + TimeNs(i)), fixes[i][0],
                          fixes[i][1], fixes[i][2]);
    write(truth() / "gnss" / (uav + ".csv"), text);
  }

  void writeDepth(const std::string& uav, const std::string& name, const Eigen::Isometry3d& T) {
    FloatRaster depth;
    depth.values.create((camera_.height - 1) / kStep + 1, (camera_.width - 1) / kStep + 1,
                        CV_32FC1);
    depth.metadata["STEP"] = std::to_string(kStep);
    for (int j = 0; j < depth.values.rows; ++j)
      for (int i = 0; i < depth.values.cols; ++i) {
        const Eigen::Vector2d pixel(i * kStep, j * kStep);
        const Eigen::Vector3d ray = T.linear() * camera_.undistort(pixel).homogeneous();
        depth.values.at<float>(j, i) = static_cast<float>(-T.translation().z() / ray.z());
      }
    std::filesystem::create_directories(truth() / "depth" / uav);
    writeFloatRaster(truth() / "depth" / uav / (name + ".tif"), depth);
    if (!faults_.depth_maps) return;
    depth.values = depth.values * faults_.map_scale + faults_.depth_offset_m;
    depth.values.rowRange(0, faults_.depth_rows_lost) = 0;
    std::filesystem::create_directories(out() / "depth" / uav);
    writeFloatRaster(out() / "depth" / uav / (name + ".tif"), depth);
  }

  void writeRelativePose() {
    Eigen::Isometry3d T = poseOf(false, 5).inverse() * poseOf(true, 1);
    T.linear() = T.linear() * Eigen::AngleAxisd(faults_.relative_turn_deg * M_PI / 180,
                                                Eigen::Vector3d::UnitX());
    const Eigen::Quaterniond q(T.linear());
    const Eigen::Vector3d t = T.translation();
    write(out() / "relative_poses.csv",
          fmt::format(
              "uav_a,uav_b,image_a,image_b,inliers,tx,ty,tz,qx,qy,qz,qw,sigma_tx,sigma_ty,sigma_tz,"
              "sigma_rx,sigma_ry,sigma_rz,residual_before,residual_after\n"
              "a,b,a_0005.jpg,b_0001.jpg,50,{},{},{},{},{},{},{},1,1,1,0.001,0.001,0.001,0,0\n",
              t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()));
  }

  void writeClouds() {
    constexpr double kSpacing_m = 0.5, kReach_m = 40;
    const int cells = static_cast<int>(2 * kReach_m / kSpacing_m);
    std::filesystem::create_directories(out() / "cloud");
    PlyWriter reference(truth() / "cloud.ply"), estimate(out() / "cloud" / "cloud.ply");
    for (int k = 0; k < cells * cells; ++k) {
      const Eigen::Vector3d p(-kReach_m + (k % cells + 0.5) * kSpacing_m,
                              kReach_m - (k / cells + 0.5) * kSpacing_m, 0);
      reference.add(p.cast<float>(), {1, 2, 3});
      Eigen::Vector3d q = faults_.map_scale * p;
      q.z() += faults_.cloud_rise_m;
      if (faults_.flying_every > 0 && k % faults_.flying_every == 0) q.z() += 5;
      estimate.add(q.cast<float>(), {1, 2, 3});
    }
    reference.close();
    estimate.close();
    FloatRaster dsm;
    dsm.values = cv::Mat::zeros(cells, cells, CV_32FC1);
    dsm.metadata = {{"ORIGIN_E", fmt::format("{}", -kReach_m)},
                    {"ORIGIN_N", fmt::format("{}", kReach_m)},
                    {"SPACING", fmt::format("{}", kSpacing_m)}};
    writeFloatRaster(truth() / "dsm.tif", dsm);
  }

  TempFolder folder_;
  Faults faults_;
  CameraModel camera_;
  std::vector<TimedPose> poses_;
  std::string images_, gnss_, report_;
};

}  // namespace cf::support
