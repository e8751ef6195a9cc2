// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link_alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

namespace cf {
namespace {

constexpr int kWidth = 320, kHeight = 240;

/// Grey value of the ground, z = 0, with an exact value everywhere.
double texture(double x, double y) {
  return 128 + 35 * std::sin(15 * x + 10 * y) + 30 * std::cos(8 * x - 18 * y) +
         20 * std::sin(22 * y + 3 * x);
}

CameraModel camera() {
  CameraModel c;
  c.width = kWidth;
  c.height = kHeight;
  c.fx = c.fy = 300;
  c.cx = (kWidth - 1) / 2.0;
  c.cy = (kHeight - 1) / 2.0;
  c.k1 = -0.05;
  return c;
}

/// Looks down from `height_m`, turned by `yaw`, a little tilted.
PosedPhoto lookDown(const Eigen::Vector2d& above, double height_m, double yaw) {
  PosedPhoto photo;
  photo.camera = camera();
  photo.T_world_cam.translation() = Eigen::Vector3d(above.x(), above.y(), height_m);
  photo.T_world_cam.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(M_PI + 0.04, Eigen::Vector3d::UnitX()))
                                   .toRotationMatrix();
  return photo;
}

cv::Mat picture(const PosedPhoto& photo) {
  cv::Mat grey(kHeight, kWidth, CV_8UC1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector3d ray =
          photo.T_world_cam.linear() * photo.camera.undistort({double(x), double(y)}).homogeneous();
      const Eigen::Vector3d p =
          photo.T_world_cam.translation() - photo.T_world_cam.translation().z() / ray.z() * ray;
      grey.at<uchar>(y, x) = cv::saturate_cast<uchar>(texture(p.x(), p.y()));
    }
  return grey;
}

/// Photos of the ground whose detections lie off by up to a pixel, each link seen by all.
struct Scene {
  std::map<FrameId, PosedPhoto> photos;
  std::map<FrameId, cv::Mat> pictures;
  std::vector<Eigen::Vector3d> ground;
  MatchGraph graph{MatchGraphOptions{}};
  std::vector<SparsePoint> links;

  explicit Scene(std::vector<std::pair<FrameId, PosedPhoto>> of) {
    for (double x = -1.5; x <= 1.5; x += 0.5)
      for (double y = -1; y <= 1; y += 0.5) ground.emplace_back(x, y, 0);
    cv::RNG random(5);
    links.resize(ground.size());
    for (auto& [id, photo] : of) {
      auto features = std::make_shared<FeatureSet>();
      for (std::size_t i = 0; i < ground.size(); ++i) {
        const Eigen::Vector2d off(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7));
        features->pixel.push_back(
            (photo.camera.project(photo.T_world_cam.inverse() * ground[i]) + off).cast<float>());
        features->scale_px.push_back(6);
        features->colour.insert(features->colour.end(), {10, 20, 30});
        links[i].position_m = ground[i];
        links[i].observations.push_back({id, static_cast<int>(i)});
      }
      auto keyframe = std::make_shared<Keyframe>();
      keyframe->id = id;
      keyframe->camera = photo.camera;
      keyframe->features = features;
      graph.add(keyframe);
      pictures[id] = picture(photo);
      photos[id] = std::move(photo);
    }
  }

  PhotoSource source() const {
    return [this](FrameId id) {
      const auto found = pictures.find(id);
      return found == pictures.end() ? cv::Mat() : found->second;
    };
  }

  /// How far the sight of a link in a photo lies from where the first one's pixel really is there.
  double error(const AlignedLinks& aligned, const Track& track, std::size_t sight) const {
    const auto pixelOf = [&](const SparseObservation& o) -> Eigen::Vector2d {
      return aligned.graph.photo(o.frame)
          .features->pixel[static_cast<std::size_t>(o.feature)]
          .cast<double>();
    };
    const PosedPhoto& first = photos.at(track[0].frame);
    const Eigen::Vector3d ray =
        first.T_world_cam.linear() * first.camera.undistort(pixelOf(track[0])).homogeneous();
    const Eigen::Vector3d p =
        first.T_world_cam.translation() - first.T_world_cam.translation().z() / ray.z() * ray;
    const PosedPhoto& photo = photos.at(track[sight].frame);
    return (photo.camera.project(photo.T_world_cam.inverse() * p) - pixelOf(track[sight])).norm();
  }
};

const FrameId kWest{0, 0}, kEast{0, 9}, kAcross{1, 0}, kHigh{2, 0};

TEST(AlignLinks, SightsOfOtherStripsAndUavsComeToLieWhereTheFirstSays) {
  const Scene scene({{kWest, lookDown({-0.5, 0}, 6, 0)},
                     {kEast, lookDown({0.7, 0.2}, 6, M_PI)},
                     {kAcross, lookDown({0.1, -0.4}, 7, M_PI / 2)}});
  const AlignedLinks aligned = alignLinks(scene.graph, scene.links, scene.photos, scene.source());
  EXPECT_GT(aligned.tracks.size(), scene.links.size() * 9 / 10);
  EXPECT_EQ(aligned.tracks.size() + aligned.left.size(), scene.links.size());
  double sum = 0, worst = 0;
  int count = 0;
  for (const Track& track : aligned.tracks)
    for (std::size_t i = 1; i < track.size(); ++i, ++count) {
      const double e = scene.error(aligned, track, i);
      sum += e * e;
      worst = std::max(worst, e);
    }
  EXPECT_GT(count, static_cast<int>(aligned.tracks.size()) * 3 / 2);
  EXPECT_LT(std::sqrt(sum / count), 0.06);  // detections: 0.8
  EXPECT_LT(worst, 0.2);
}

TEST(AlignLinks, WhatCannotBeAlignedIsLeftAsItIs) {
  Scene scene({{kWest, lookDown({0, 0}, 6, 0)}, {kHigh, lookDown({0, 0}, 12, 0)}});
  const AlignedLinks far = alignLinks(scene.graph, scene.links, scene.photos, scene.source());
  EXPECT_TRUE(far.tracks.empty()) << "a quarter of the area";
  ASSERT_EQ(far.left.size(), scene.links.size());
  EXPECT_EQ(far.left[3].observations.size(), 2u);

  Scene missing({{kWest, lookDown({0, 0}, 6, 0)}, {kEast, lookDown({0.5, 0}, 6, 0)}});
  missing.pictures.erase(kEast);
  EXPECT_EQ(alignLinks(missing.graph, missing.links, missing.photos, missing.source()).left.size(),
            missing.links.size());
  missing.pictures.clear();
  EXPECT_TRUE(
      alignLinks(missing.graph, missing.links, missing.photos, missing.source()).tracks.empty());
}

}  // namespace
}  // namespace cf
