// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/extract.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>

#include "cf/features/match.h"

namespace cf {
namespace {

/// A photo of the given size, decoded at the size of `image`.
ImageFrame frameOf(const cv::Mat& image, int width, int height) {
  ImageFrame frame;
  frame.image = image;
  frame.camera.width = width;
  frame.camera.height = height;
  return frame;
}

/// Smoothed noise at three scales, sharp enough for features everywhere.
cv::Mat texture(int width, int height, unsigned seed, double amplitude = 45) {
  std::mt19937 random(seed);
  std::normal_distribution<float> gauss;
  cv::Mat sum(height, width, CV_32F, cv::Scalar(128));
  for (const double sigma : {1.5, 4.0, 10.0}) {
    cv::Mat noise(height, width, CV_32F);
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) noise.at<float>(v, u) = gauss(random);
    cv::GaussianBlur(noise, noise, {}, sigma);
    sum += noise * (amplitude * sigma * 2);
  }
  cv::Mat grey, bgr;
  sum.convertTo(grey, CV_8U);
  cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

TEST(ExtractFeatures, LeavesNoTexturedCellEmpty) {
  // The left half has five times the contrast of the right one: by strength alone, it takes all.
  const int w = 960, h = 720;
  cv::Mat image = texture(w, h, 1, 9);
  texture(w, h, 2).colRange(0, w / 2).copyTo(image.colRange(0, w / 2));
  FeatureOptions options;
  options.max_features = 600;
  const FeatureSet set = extractFeatures(frameOf(image, w, h), options);
  EXPECT_LE(set.size(), 600u);
  EXPECT_GT(set.size(), 500u);
  constexpr int kColumns = 8, kRows = 6;
  std::vector<int> cells(kColumns * kRows);
  for (const auto& p : set.pixel)
    ++cells[static_cast<std::size_t>(static_cast<int>(p.y()) * kRows / h * kColumns +
                                     static_cast<int>(p.x()) * kColumns / w)];
  EXPECT_GE(*std::min_element(cells.begin(), cells.end()), 3);
  EXPECT_LE(*std::max_element(cells.begin(), cells.end()), 4 * 600 / (kColumns * kRows));
}

TEST(ExtractFeatures, IsDeterministic) {
  const ImageFrame frame = frameOf(texture(500, 375, 3), 500, 375);
  const FeatureSet p = extractFeatures(frame, {}), q = extractFeatures(frame, {});
  ASSERT_GT(p.size(), 200u);
  EXPECT_EQ(p.pixel, q.pixel);
  EXPECT_EQ(p.scale_px, q.scale_px);
  EXPECT_EQ(p.descriptor, q.descriptor);
  EXPECT_EQ(p.colour, q.colour);
}

TEST(ExtractFeatures, FillsEveryColumnOfTheSet) {
  cv::Mat image = texture(480, 360, 4);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      // Red on the left, blue on the right, under the same texture.
      image.at<cv::Vec3b>(v, u)[0] = u < 240 ? 10 : 200;
      image.at<cv::Vec3b>(v, u)[2] = u < 240 ? 200 : 10;
    }
  const FeatureSet set = extractFeatures(frameOf(image, 480, 360), {});
  ASSERT_GT(set.size(), 100u);
  ASSERT_EQ(set.scale_px.size(), set.size());
  ASSERT_EQ(set.descriptor.size(), set.size() * FeatureSet::kDescriptorSize);
  ASSERT_EQ(set.colour.size(), set.size() * 3);
  EXPECT_DOUBLE_EQ(set.pixel_size, 1);
  for (std::size_t i = 0; i < set.size(); ++i) {
    EXPECT_EQ(set.colour[3 * i], set.pixel[i].x() < 239.5f ? 10 : 200);
    EXPECT_EQ(set.colour[3 * i + 2], set.pixel[i].x() < 239.5f ? 200 : 10);
    EXPECT_GT(set.scale_px[i], 1);
    double sum = 0;
    for (int k = 0; k < FeatureSet::kDescriptorSize; ++k)
      sum += static_cast<double>(set.row(i)[k]) * set.row(i)[k];
    // RootSIFT has length 1, here 512, less what the clamp at 255 takes away.
    EXPECT_LT(std::sqrt(sum), 520);
    EXPECT_GT(std::sqrt(sum), 400);
  }
}

TEST(ExtractFeatures, BlankPhotoHasNone) {
  const cv::Mat black(300, 400, CV_8UC3, cv::Scalar(0, 0, 0));
  EXPECT_EQ(extractFeatures(frameOf(black, 400, 300), {}).size(), 0u);
}

/// Blobs at known places of the photo, bright and dark. `sigma` in pixels of the photo, the image
/// decoded at 1/decoded of the photo's size.
struct Blobs {
  std::vector<Eigen::Vector2d> places;
  cv::Mat image;

  Blobs(int width, int height, int decoded, double sigma, unsigned seed)
      : image(height / decoded, width / decoded, CV_8UC3) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> jitter(-0.1, 0.1);
    const double cell = 20 * sigma;
    cv::Mat sum(image.size(), CV_64F, cv::Scalar(128));
    for (int row = 0; (row + 1) * cell < height; ++row)
      for (int column = 0; (column + 1) * cell < width; ++column) {
        const Eigen::Vector2d p((column + 0.5 + jitter(random)) * cell,
                                (row + 0.5 + jitter(random)) * cell);
        const double sign = (row + column) % 2 == 0 ? 1 : -1;
        places.push_back(p);
        const auto reach = static_cast<int>(cell / 2 / decoded);
        // Pixel u of the decoded image is centred at (u + 0.5) decoded - 0.5 of the photo.
        const int cu = static_cast<int>(p.x() / decoded), cv = static_cast<int>(p.y() / decoded);
        for (int v = std::max(0, cv - reach); v <= std::min(sum.rows - 1, cv + reach); ++v)
          for (int u = std::max(0, cu - reach); u <= std::min(sum.cols - 1, cu + reach); ++u) {
            const Eigen::Vector2d at((u + 0.5) * decoded - 0.5, (v + 0.5) * decoded - 0.5);
            sum.at<double>(v, u) +=
                sign * 100 * std::exp(-(at - p).squaredNorm() / (2 * sigma * sigma));
          }
      }
    cv::Mat grey;
    sum.convertTo(grey, CV_8U);
    cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  }
};

struct Reduction {
  int width, height;  ///< of the photo
  int decoded;        ///< the image given is smaller by this factor
  double megapixels;  ///< features are sought at
};

class KnownPlaces : public testing::TestWithParam<Reduction> {};

TEST_P(KnownPlaces, AreFoundInThePhotosFrame) {
  const Reduction r = GetParam();
  const double expected_size =
      std::max(static_cast<double>(r.decoded),
               std::sqrt(r.width * static_cast<double>(r.height) / 1e6 / r.megapixels));
  const double sigma = 4 * expected_size;
  const Blobs blobs(r.width, r.height, r.decoded, sigma, 5);
  FeatureOptions options;
  options.megapixels = r.megapixels;
  const FeatureSet set = extractFeatures(frameOf(blobs.image, r.width, r.height), options);
  EXPECT_NEAR(set.pixel_size, expected_size, 0.01 * expected_size);
  ASSERT_GT(blobs.places.size(), 20u);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  std::size_t missed = 0;
  for (const Eigen::Vector2d& place : blobs.places) {
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t best = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      const double d = (set.pixel[i].cast<double>() - place).norm();
      if (d >= nearest) continue;
      nearest = d;
      best = i;
    }
    if (nearest > set.pixel_size) {
      ++missed;
      continue;
    }
    EXPECT_LT(nearest / set.pixel_size, 0.3) << place.transpose();
    // The diameter of a Gaussian blob is 2 sigma sqrt(2) by the scale of the strongest response;
    // SIFT's convention (2 sigma) and its sampling of scales leave half an octave.
    EXPECT_GT(set.scale_px[best], 1.4 * sigma);
    EXPECT_LT(set.scale_px[best], 4 * sigma);
    mean += (set.pixel[best].cast<double>() - place) / set.pixel_size /
            static_cast<double>(blobs.places.size());
  }
  // SIFT fits a parabola to the extremum; halfway between two pixels the fit may never settle.
  EXPECT_LE(missed, blobs.places.size() / 30);
  // No shift common to all: half a pixel of a wrong convention would show here.
  EXPECT_LT(mean.norm(), 0.2) << mean.transpose();
}

INSTANTIATE_TEST_SUITE_P(Reductions, KnownPlaces,
                         testing::Values(Reduction{1000, 750, 1, 1.0},
                                         Reduction{2000, 1500, 1, 0.5},
                                         Reduction{1600, 1200, 1, 0.48},
                                         Reduction{4000, 3000, 2, 0.75},
                                         Reduction{4000, 3000, 4, 0.75}));

TEST(ExtractFeatures, AreFoundAgainInATurnedAndScaledPhoto) {
  const int w = 800, h = 600;
  const cv::Mat a = texture(w, h, 6);
  const double angle = 0.6, scale = 0.8;
  Eigen::Matrix2d A = scale * Eigen::Rotation2Dd(angle).toRotationMatrix();
  const Eigen::Vector2d centre(w / 2., h / 2.);
  const Eigen::Vector2d t = centre + Eigen::Vector2d(21.3, -13.8) - A * centre;
  const cv::Mat warp = (cv::Mat_<double>(2, 3) << A(0, 0), A(0, 1), t.x(), A(1, 0), A(1, 1), t.y());
  cv::Mat b;
  cv::warpAffine(a, b, warp, a.size(), cv::INTER_AREA, cv::BORDER_CONSTANT, {128, 128, 128});
  FeatureOptions options;
  options.max_features = 1500;
  const FeatureSet fa = extractFeatures(frameOf(a, w, h), options);
  const FeatureSet fb = extractFeatures(frameOf(b, w, h), options);
  const auto warped = [&](std::size_t i) {
    return Eigen::Vector2d(A * fa.pixel[i].cast<double>() + t);
  };

  std::size_t visible = 0, repeated = 0;
  for (std::size_t i = 0; i < fa.size(); ++i) {
    const Eigen::Vector2d p = warped(i);
    if (p.x() < 20 || p.y() < 20 || p.x() > w - 20 || p.y() > h - 20) continue;
    ++visible;
    repeated += std::any_of(fb.pixel.begin(), fb.pixel.end(), [&](const auto& q) {
      return (q.template cast<double>() - p).norm() < 1.5;
    });
  }
  const auto matches = matchFeatures(fa, fb);
  std::size_t right = 0;
  for (const FeatureMatch& m : matches)
    right += (fb.pixel[static_cast<std::size_t>(m.b)].cast<double>() -
              warped(static_cast<std::size_t>(m.a)))
                 .norm() < 1.5;
  RecordProperty("visible", static_cast<int>(visible));
  RecordProperty("repeated", static_cast<int>(repeated));
  RecordProperty("matches", static_cast<int>(matches.size()));
  RecordProperty("right", static_cast<int>(right));
  ASSERT_GT(visible, 500u);
  EXPECT_GT(static_cast<double>(repeated), 0.5 * static_cast<double>(visible));
  EXPECT_GT(static_cast<double>(matches.size()), 0.35 * static_cast<double>(visible));
  EXPECT_GT(static_cast<double>(right), 0.95 * static_cast<double>(matches.size()));
}

TEST(Subset, TakesTheRowsAskedForInThatOrder) {
  const FeatureSet all = extractFeatures(frameOf(texture(300, 225, 7), 600, 450), {});
  ASSERT_GT(all.size(), 50u);
  const std::vector<int> wanted{40, 3, 17, 3};
  const FeatureSet some = subset(all, wanted);
  ASSERT_EQ(some.size(), wanted.size());
  ASSERT_EQ(some.descriptor.size(), wanted.size() * FeatureSet::kDescriptorSize);
  ASSERT_EQ(some.colour.size(), 3 * wanted.size());
  EXPECT_EQ(some.pixel_size, all.pixel_size);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto from = static_cast<std::size_t>(wanted[i]);
    EXPECT_EQ(some.pixel[i], all.pixel[from]);
    EXPECT_EQ(some.scale_px[i], all.scale_px[from]);
    EXPECT_TRUE(std::equal(some.row(i), some.row(i) + FeatureSet::kDescriptorSize, all.row(from)));
    EXPECT_TRUE(std::equal(some.colour.begin() + 3 * static_cast<long>(i),
                           some.colour.begin() + 3 * static_cast<long>(i) + 3,
                           all.colour.begin() + 3 * static_cast<long>(from)));
  }
  EXPECT_EQ(subset(all, {}).size(), 0u);
}

}  // namespace
}  // namespace cf
