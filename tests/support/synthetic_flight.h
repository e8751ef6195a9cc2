// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "cf/geodesy/local_frame.h"
#include "cf/rawlog/rawlog_writer.h"
#include "support/stereo_scene.h"

namespace cf::support {

/// Three UAVs on parallel lines over HouseScene, five photos each, 85 % forward and 70 % side
/// overlap. The truth is in ENU at `origin()`.
struct SyntheticFlight {
  struct Photo {
    std::string name;
    TimeNs time = 0;
    PosedCamera truth;
    GnssFix fix;            ///< the truth and some centimetres
    GimbalAttitude gimbal;  ///< straight down: up to 1.5 degrees wrong
    std::vector<unsigned char> jpeg;
  };
  struct Uav {
    std::string name;
    std::vector<Photo> photos;
  };
  std::vector<Uav> uavs;
  HouseScene scene;

  static Geodetic origin() { return {46.8, -91.9, 200}; }
  static const char* originText() { return "46.8, -91.9, 200"; }
};

/// Rendered once for each process.
inline const SyntheticFlight& syntheticFlight() {
  static const SyntheticFlight flight = [] {
    constexpr int kUavs = 3, kPhotos = 5;
    constexpr double kHeight_m = 40, kBetweenLines_m = 14, kStep_m = 5.5;
    CameraModel camera = distortedCamera();
    camera.focal_sigma = 1;
    camera.k1_sigma = camera.k2_sigma = 0.002;
    const LocalFrame world(SyntheticFlight::origin());
    SyntheticFlight made;
    for (int u = 0; u < kUavs; ++u) {
      auto& uav = made.uavs.emplace_back();
      uav.name = std::string("north") + static_cast<char>('A' + u);
      for (int i = 0; i < kPhotos; ++i) {
        const double wobble = std::sin(2.3 * i + 1.7 * u);
        auto& photo = uav.photos.emplace_back();
        photo.name = "P" + std::to_string(u) + std::to_string(i) + ".JPG";
        photo.time =
            1466699519 * kNsPerSecond + TimeNs{i} * 2'123'456'700 + TimeNs{u} * 310'000'100;
        photo.truth = cameraAt(camera, (u - 1) * kBetweenLines_m + wobble,
                               (i - (kPhotos - 1) / 2.0) * kStep_m, kHeight_m + 0.5 * wobble,
                               0.05 * wobble, 0.02 * std::cos(i + u), -0.015 * wobble);
        photo.gimbal.yaw_deg = -0.05 * wobble * 180 / M_PI;
        const Eigen::Vector3d noise =
            0.05 * Eigen::Vector3d(std::sin(11.0 * i + u), std::cos(7.0 * i - u), wobble);
        const Geodetic fix = world.toGeodetic(photo.truth.T_world_cam.translation() + noise);
        photo.fix.time = photo.time;
        photo.fix.latitude_deg = fix.latitude_deg;
        photo.fix.longitude_deg = fix.longitude_deg;
        photo.fix.height_m = fix.height_m;
        photo.fix.sigma_enu_m = {0.05, 0.05, 0.08};
        photo.fix.datum = HeightDatum::kEllipsoid;
        cv::imencode(".jpg", photograph(made.scene, photo.truth), photo.jpeg);
      }
    }
    return made;
  }();
  return flight;
}

inline void writeBytes(const std::filesystem::path& file, const std::vector<unsigned char>& bytes) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// As its record in the rawlog tells of it; the file stands beside that.
inline ImageFrame frameOf(const SyntheticFlight::Photo& photo, const std::filesystem::path& rawlog,
                          bool with_gimbal = true) {
  ImageFrame frame;
  frame.time = photo.time;
  frame.name = photo.name;
  frame.file = imagesFolderOf(std::filesystem::absolute(rawlog)) / photo.name;
  frame.camera = photo.truth.camera;
  if (with_gimbal) frame.attitude = photo.gimbal;
  return frame;
}

/// Rawlogs, their photos and config.ini in a folder; returns the ini.
inline std::filesystem::path writeSyntheticFlight(const std::filesystem::path& folder,
                                                  bool with_gnss = true, bool with_gimbal = true) {
  std::filesystem::create_directories(folder);
  std::ofstream ini(folder / "config.ini");
  for (const auto& uav : syntheticFlight().uavs) {
    const std::filesystem::path rawlog = folder / (uav.name + ".rawlog");
    RawlogWriter writer(rawlog);
    for (const auto& photo : uav.photos) {
      const ImageFrame frame = frameOf(photo, rawlog, with_gimbal);
      writeBytes(frame.file, photo.jpeg);
      writer.write(frame);
      if (with_gnss) writer.write(photo.fix);
    }
    writer.finish();
    ini << "[uav." << uav.name << "]\nrawlog = " << uav.name << ".rawlog\n\n";
  }
  return folder / "config.ini";
}

}  // namespace cf::support
