// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/photographer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "cf/features/extract.h"
#include "cf/features/match.h"

namespace cf {
namespace {

constexpr std::uint64_t kSeed = 2;

Eigen::AlignedBox2d area() { return {Eigen::Vector2d(-60, -60), Eigen::Vector2d(60, 60)}; }

TrueCamera camera(int width, int height, double focal) {
  TrueCamera c;
  c.width = width, c.height = height, c.focal = focal;
  c.cx = 0.5 * (width - 1) + 3, c.cy = 0.5 * (height - 1) - 2;
  c.k1 = -0.12, c.k2 = 0.03, c.p1 = 4e-4, c.p2 = -3e-4;
  return c;
}

/// Looking down, turned and tilted a little.
CameraMotion cameraAt(const Eigen::Vector3d& place, double yaw = 0.3, double tilt = 0.05) {
  CameraMotion m;
  Eigen::Matrix3d down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  m.T_world_cam.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * down *
                           Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()).toRotationMatrix();
  m.T_world_cam.translation() = place;
  return m;
}

PhotoOptions clean() {
  PhotoOptions o;
  o.exposure_sigma = o.vignetting = o.noise_sigma = o.exposure_s = 0;
  return o;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

TEST(Photographer, DepthsOfTwoViewsAgree) {
  const Scene scene({}, area(), kSeed);
  const TrueCamera c = camera(800, 600, 700);
  const CameraMotion a = cameraAt({-8, 0, 80}), b = cameraAt({8, 5, 85}, 0.9, -0.06);
  const cv::Mat depth_a = trueDepth(scene, c, a, clean(), 5);
  const Eigen::Isometry3d T_b_a = b.T_world_cam.inverse() * a.T_world_cam;
  int seen = 0, agreeing = 0;
  for (int r = 0; r < depth_a.rows; ++r) {
    for (int q = 0; q < depth_a.cols; ++q) {
      const auto z = static_cast<double>(depth_a.at<float>(r, q));
      ASSERT_GT(z, 0);
      const Eigen::Vector3d in_b = T_b_a * (z * c.rayThrough({5.0 * q, 5.0 * r}));
      // The ray of view B through that very point, not through the nearest pixel.
      const Eigen::Vector3d ray = c.rayThrough(c.pixelOf(in_b));
      const auto hit = scene.hit(b.T_world_cam.translation(), b.T_world_cam.linear() * ray);
      ASSERT_TRUE(hit);
      EXPECT_LT(hit->distance, in_b.z() + 2e-2);
      ++seen;
      if (std::abs(hit->distance - in_b.z()) < 2e-4) ++agreeing;
    }
  }
  EXPECT_GT(agreeing, 0.85 * seen);  // the rest is hidden behind roofs and crowns
}

TEST(Photographer, ThreadsDoNotMatter) {
  CameraMotion m = cameraAt({0, 0, 70});
  m.velocity_mps = {12, 0, 0};
  const TrueCamera c = camera(500, 300, 700);
  const Scene scene({}, area(), kSeed);
  const cv::Mat free_threads = takePhoto(scene, c, m, {}, 9);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Scene again({}, area(), kSeed);
  EXPECT_TRUE(same(free_threads, takePhoto(again, c, m, {}, 9)));
  EXPECT_FALSE(same(free_threads, takePhoto(again, c, m, {}, 10)));
}

TEST(Photographer, TextureIsBandLimited) {
  SceneOptions options;
  options.terrain = "flat";
  options.building_density = options.tree_density = 0;
  const Scene scene(options, area(), kSeed);
  TrueCamera fine = camera(960, 720, 1200), coarse = fine;
  fine.k1 = coarse.k1 = fine.k2 = coarse.k2 = 0;
  coarse.width /= 2, coarse.height /= 2, coarse.focal /= 2;
  coarse.cx = fine.cx / 2 - 0.25, coarse.cy = fine.cy / 2 - 0.25;
  const CameraMotion m = cameraAt({0, 0, 60});
  cv::Mat reduced, difference;
  cv::resize(takePhoto(scene, fine, m, clean(), 1), reduced, cv::Size(coarse.width, coarse.height),
             0, 0, cv::INTER_AREA);
  const cv::Mat direct = takePhoto(scene, coarse, m, clean(), 1);
  cv::absdiff(reduced, direct, difference);
  const cv::Scalar mean = cv::mean(difference);
  EXPECT_LT(mean[1], 3.5);
  // And it is no fog: neighbouring pixels differ.
  cv::Mat grey, edges;
  cv::cvtColor(direct, grey, cv::COLOR_BGR2GRAY);
  cv::Laplacian(grey, edges, CV_32F);
  EXPECT_GT(cv::norm(edges, cv::NORM_L1) / static_cast<double>(edges.total()), 6.0);
}

TEST(Photographer, RollingShutterMovesRowsAsPredicted) {
  const Scene scene({}, area(), kSeed);
  const TrueCamera c = camera(640, 480, 600);
  CameraMotion m = cameraAt({0, 0, 75});
  m.velocity_mps = {9, -4, 1};
  m.angular_velocity_radps = {0.2, -0.1, 0.3};
  PhotoOptions rolling = clean();
  rolling.readout_s = 0.03;
  const cv::Mat depth = trueDepth(scene, c, m, rolling, 16);
  const cv::Mat photo = takePhoto(scene, c, m, rolling, 1);
  for (const int row : {0, 160, 464}) {
    CameraMotion still = m;
    const double t = 0.03 * (row / 479.0 - 0.5);
    const Eigen::Vector3d turn = t * m.angular_velocity_radps;
    still.T_world_cam.linear() =
        m.T_world_cam.linear() * Eigen::AngleAxisd(turn.norm(), turn.normalized());
    still.T_world_cam.translation() += t * m.velocity_mps;
    still.velocity_mps.setZero();
    still.angular_velocity_radps.setZero();
    const cv::Mat expected = trueDepth(scene, c, still, clean(), 16);
    const cv::Mat expected_photo = takePhoto(scene, c, still, clean(), 1);
    int equal = 0;
    for (int q = 0; q < depth.cols; ++q) {
      if (std::abs(depth.at<float>(row / 16, q) - expected.at<float>(row / 16, q)) < 1e-3F) ++equal;
    }
    EXPECT_GE(equal, depth.cols - 1) << row;
    // A row beside the one at hand differs by far more than rounding.
    EXPECT_LT(cv::norm(photo.row(row), expected_photo.row(row), cv::NORM_L1) / (3 * c.width), 1.0);
    EXPECT_GT(cv::norm(photo.row(row), expected_photo.row(row + 4), cv::NORM_L1) / (3 * c.width),
              2.5);
  }
}

TEST(Photographer, MotionBlursAlongTheFlight) {
  const Scene scene({}, area(), kSeed);
  const TrueCamera c = camera(400, 300, 600);
  CameraMotion m = cameraAt({0, 0, 60}, 0, 0);
  m.velocity_mps = {15, 0, 0};  // along the image's x
  PhotoOptions slow = clean();
  slow.exposure_s = 0.03;  // 4.5 px
  cv::Mat dx_still, dx_moved, dy_still, dy_moved;
  const cv::Mat still = takePhoto(scene, c, m, clean(), 1), moved = takePhoto(scene, c, m, slow, 1);
  cv::Sobel(still, dx_still, CV_32F, 1, 0);
  cv::Sobel(moved, dx_moved, CV_32F, 1, 0);
  cv::Sobel(still, dy_still, CV_32F, 0, 1);
  cv::Sobel(moved, dy_moved, CV_32F, 0, 1);
  const double along = cv::norm(dx_moved) / cv::norm(dx_still);
  const double across = cv::norm(dy_moved) / cv::norm(dy_still);
  EXPECT_LT(along, 0.75);
  EXPECT_GT(across, 1.25 * along);
}

TEST(Photographer, NoiseAndVignettingAreAsAskedFor) {
  SceneOptions options;
  options.blank_share = 1;
  options.crop_share = options.road_spacing_m = 0;
  options.building_density = options.tree_density = 0;
  options.terrain = "flat";
  const Scene scene(options, area(), kSeed);
  const TrueCamera c = camera(400, 300, 600);
  PhotoOptions noisy = clean();
  noisy.noise_sigma = 2;
  const cv::Mat photo = takePhoto(scene, c, cameraAt({0, 0, 50}), noisy, 1);
  cv::Scalar mean, deviation;
  cv::meanStdDev(photo, mean, deviation);
  EXPECT_NEAR(deviation[1], 2 * std::sqrt(1 + mean[1] / 255), 0.15);
  PhotoOptions dark_corners = clean();
  dark_corners.vignetting = 0.5;
  const cv::Mat vignetted = takePhoto(scene, c, cameraAt({0, 0, 50}), dark_corners, 1);
  EXPECT_LT(vignetted.at<cv::Vec3b>(0, 0)[1], 0.85 * vignetted.at<cv::Vec3b>(150, 200)[1]);
}

/// Where the patch around `from` in grey photo a lies in b, by least squares from a first guess.
Eigen::Vector2d refine(const cv::Mat& a, const Eigen::Vector2d& from, const cv::Mat& b,
                       Eigen::Vector2d guess) {
  const cv::Size size(21, 21);
  auto patch = [&](const cv::Mat& image, const Eigen::Vector2d& at) {
    cv::Mat cut;
    cv::getRectSubPix(image, size, {static_cast<float>(at.x()), static_cast<float>(at.y())}, cut);
    return cv::Mat(cut - cv::mean(cut));
  };
  const cv::Mat wanted = patch(a, from);
  const cv::Mat dx =
      (patch(a, from + Eigen::Vector2d(0.5, 0)) - patch(a, from - Eigen::Vector2d(0.5, 0)));
  const cv::Mat dy =
      (patch(a, from + Eigen::Vector2d(0, 0.5)) - patch(a, from - Eigen::Vector2d(0, 0.5)));
  Eigen::Matrix2d normal;
  normal << dx.dot(dx), dx.dot(dy), dx.dot(dy), dy.dot(dy);
  for (int k = 0; k < 15; ++k) {
    const cv::Mat seen = patch(b, guess);
    // The photos differ in exposure.
    const cv::Mat off = wanted - seen * (wanted.dot(seen) / seen.dot(seen));
    guess += normal.inverse() * Eigen::Vector2d(dx.dot(off), dy.dot(off));
  }
  return guess;
}

/// The truth check: what is matched between two photos lies where poses and depths say.
TEST(Photographer, MatchedFeaturesReprojectThroughTruth) {
  const Scene scene({}, area(), kSeed);
  const TrueCamera c = camera(2000, 1500, 1700);
  const CameraMotion a = cameraAt({-3, 0, 75}, 0.3, 0.01), b = cameraAt({3, 2, 75.2}, 0.3, -0.01);
  struct View {
    cv::Mat grey;
    FeatureSet features;
  };
  auto see = [&](const CameraMotion& m, std::uint64_t seed) {
    ImageFrame frame;
    frame.image = takePhoto(scene, c, m, {}, seed);
    frame.camera.width = c.width, frame.camera.height = c.height;
    FeatureOptions wanted;
    wanted.megapixels = 3;  // the photo's own size
    View view;
    view.features = extractFeatures(frame, wanted);
    cv::cvtColor(frame.image, view.grey, cv::COLOR_BGR2GRAY);
    view.grey.convertTo(view.grey, CV_32F);
    cv::GaussianBlur(view.grey, view.grey, {}, 1.2);  // finer detail suffers from interpolation
    return view;
  };
  const View in_a = see(a, 1), in_b = see(b, 2);
  std::vector<double> as_found, refined;
  int raised = 0;
  for (const auto& match : matchFeatures(in_a.features, in_b.features)) {
    const Eigen::Vector2d pixel =
        in_a.features.pixel[static_cast<std::size_t>(match.a)].cast<double>();
    const Eigen::Vector2d found =
        in_b.features.pixel[static_cast<std::size_t>(match.b)].cast<double>();
    const auto hit =
        scene.hit(a.T_world_cam.translation(), a.T_world_cam.linear() * c.rayThrough(pixel));
    ASSERT_TRUE(hit);
    if (hit->object != 0) ++raised;
    const Eigen::Vector2d expected = c.pixelOf(b.T_world_cam.inverse() * hit->position_m);
    as_found.push_back((expected - found).norm());
    refined.push_back((expected - refine(in_a.grey, pixel, in_b.grey, found)).norm());
  }
  auto median = [](std::vector<double> v) {
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
  };
  ASSERT_GT(refined.size(), 1000U);
  EXPECT_GT(raised, 100);  // roofs and crowns take part
  std::printf("%zu matches, %d above the ground; median error of SIFT %.3f px, refined %.4f px\n",
              refined.size(), raised, median(as_found), median(refined));
  EXPECT_LT(median(as_found), 0.4);  // SIFT's own accuracy
  EXPECT_LT(median(refined), 0.1);
}

}  // namespace
}  // namespace cf
