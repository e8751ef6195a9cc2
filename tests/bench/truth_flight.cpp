// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "truth_flight.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "cf/base/text.h"
#include "cf/formats/camera_ini.h"
#include "cf/formats/csv.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/tum.h"

namespace cf::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kSmooth = 0.02;      // of the depth
constexpr double kSameDepth = 0.006;  // of the depth
constexpr int kRangeSamples = 60;     // of a photo's width and height
constexpr double kWidestField = 1.2;  // of half the photo; beyond, distortions fold over

void setDepthRange(DenseView& view, const TrueDepth& depth) {
  std::vector<float> values;
  for (int j = 0; j < kRangeSamples; ++j)
    for (int i = 0; i < kRangeSamples; ++i) {
      const float z = depth.values.at<float>(j * depth.values.rows / kRangeSamples,
                                             i * depth.values.cols / kRangeSamples);
      if (z > 0) values.push_back(z);
    }
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  const auto share = [&](double s) {
    return static_cast<double>(values[static_cast<std::size_t>(s * (values.size() - 1.0))]);
  };
  view.near_depth_m = share(0.05);
  view.median_depth_m = share(0.5);
  view.far_depth_m = share(0.95);
}

}  // namespace

double TrueDepth::at(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d p = pixel / step;
  if (!(p.minCoeff() >= 0) || p.x() >= values.cols - 1 || p.y() >= values.rows - 1) return 0;
  const int i = static_cast<int>(p.x()), j = static_cast<int>(p.y());
  const double s = p.x() - i, t = p.y() - j;
  const float* a = values.ptr<float>(j) + i;
  const float* b = values.ptr<float>(j + 1) + i;
  const auto [low, high] = std::minmax({a[0], a[1], b[0], b[1]});
  if (low <= 0 || high - low > kSmooth * low) {
    return static_cast<double>((t < 0.5 ? a : b)[s < 0.5 ? 0 : 1]);
  }
  return (1 - t) * ((1 - s) * static_cast<double>(a[0]) + s * static_cast<double>(a[1])) +
         t * ((1 - s) * static_cast<double>(b[0]) + s * static_cast<double>(b[1]));
}

TruthFlight::TruthFlight(const fs::path& folder, const fs::path& run) {
  const fs::path truth = folder / "truth";
  const auto rows = readCsvRows(truth / "images.tsv", '\t');
  const auto poses = readTum(truth / "poses.tum");
  if (rows.size() != poses.size()) throw std::runtime_error("images.tsv and poses.tum differ");
  std::map<std::string, CameraModel> cameras;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const fs::path key = rows[k].at(0);
    TruePhoto photo;
    photo.uav = key.parent_path().string();
    photo.name = key.filename().string();
    photo.image = folder / (photo.uav + "_Images") / photo.name;
    const fs::path depth = truth / "depth" / photo.uav / (key.stem().string() + ".tif");
    const FloatRaster raster = readFloatRaster(depth);
    depths_.push_back({std::stoi(raster.metadata.at("STEP")), raster.values});
    photo.T_world_cam = poses[k].T_world_cam;
    const auto [camera, is_new] = cameras.try_emplace(photo.uav);
    if (is_new) camera->second = readCameraIni(truth / "cameras" / (photo.uav + ".ini"));
    photo.camera = camera->second;
    photo.view.id = {0, static_cast<std::uint32_t>(k)};
    photo.view.T_world_cam = photo.T_world_cam;
    photo.view.camera = photo.camera;
    setDepthRange(photo.view, depths_.back());
    photos_.push_back(photo);
  }
  if (!run.empty()) takePosesOf(run);
}

void TruthFlight::takePosesOf(const fs::path& run) {
  for (TruePhoto& photo : photos_) {
    photo.posed = false;
    const CsvTable images(run / "images" / (photo.uav + ".csv"));
    const std::size_t name = images.column("image"), time = images.column("t");
    for (const CsvRow& row : images.rows()) {
      if (row[name] != photo.name) continue;
      for (const TimedPose& pose : readTum(run / "trajectories" / (photo.uav + ".tum"))) {
        if (timeText(pose.time) != row[time]) continue;
        photo.view.T_world_cam = pose.T_world_cam;
        photo.view.camera = readCameraIni(run / "cameras" / (photo.uav + ".ini"));
        photo.posed = true;
      }
    }
  }
}

const TruePhoto& TruthFlight::photo(FrameId id) const { return photos_.at(id.index); }

std::vector<DenseView> TruthFlight::views() const {
  std::vector<DenseView> views;
  for (const TruePhoto& photo : photos_)
    if (photo.posed) views.push_back(photo.view);
  return views;
}

bool TruthFlight::sees(const TruePhoto& photo, const Eigen::Vector3d& p_world) const {
  const Eigen::Vector3d p = photo.T_world_cam.inverse() * p_world;
  if (p.z() <= 0) return false;
  const CameraModel& c = photo.camera;
  if (std::abs(p.x() / p.z()) > kWidestField * c.width / c.fx / 2 ||
      std::abs(p.y() / p.z()) > kWidestField * c.height / c.fy / 2) {
    return false;
  }
  const Eigen::Vector2d pixel = c.project(p);
  return c.contains(pixel) && std::abs(depth(photo).at(pixel) - p.z()) <= kSameDepth * p.z();
}

cv::Mat decoded(const TruePhoto& photo, double megapixels) {
  const double full = 1e-6 * photo.camera.width * photo.camera.height;
  const int reduction = full / 16 >= megapixels  ? cv::IMREAD_REDUCED_COLOR_4
                        : full / 4 >= megapixels ? cv::IMREAD_REDUCED_COLOR_2
                                                 : cv::IMREAD_COLOR;
  const cv::Mat image = cv::imread(photo.image.string(), reduction | cv::IMREAD_IGNORE_ORIENTATION);
  if (image.empty()) throw std::runtime_error(photo.image.string() + " cannot be read");
  return image;
}

}  // namespace cf::bench
