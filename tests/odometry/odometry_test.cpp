// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/odometry/odometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <opencv2/core.hpp>
#include <set>
#include <string>

#include "cf/geometry/similarity.h"
#include "support/stereo_scene.h"
#include "support/views.h"

namespace cf {
namespace {

using support::rotationErrorDeg;

constexpr double kHeight_m = 60;

/// Photos of a textured ground, flat or with a house on it, and their true poses.
struct Flight {
  support::HouseScene scene;
  std::vector<Eigen::Isometry3d> T_world_cam;
  std::vector<ImageFrame> photos;

  explicit Flight(double roof_m) {
    scene.roof_m = roof_m;
    scene.half_width_m = roof_m > 0 ? 14 : 0;
    scene.fine_wavelength_m = 0.5;
  }

  /// A camera that looks down, a little askew, as a gimbal leaves it.
  void take(double x, double y, double yaw = 0) {
    const auto n = static_cast<double>(photos.size());
    const auto camera =
        support::cameraAt(support::distortedCamera(), x, y, kHeight_m + 0.6 * std::sin(3 * n),
                          yaw + 0.03 * std::sin(n), 0.03 * std::cos(2 * n), 0.02 * std::sin(5 * n));
    T_world_cam.push_back(camera.T_world_cam);
    add(support::photograph(scene, camera));
  }
  void takeBlack() {
    T_world_cam.push_back(Eigen::Isometry3d::Identity());
    add(cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, 0, 0)));
  }

 private:
  void add(const cv::Mat& image) {
    ImageFrame frame;
    frame.id = {0, static_cast<std::uint32_t>(photos.size())};
    frame.time = static_cast<TimeNs>(photos.size()) * 2 * kNsPerSecond;
    frame.name = "photo_" + std::to_string(photos.size()) + ".jpg";
    frame.camera = support::distortedCamera();
    frame.image = image;
    photos.push_back(frame);
  }
};

using Keyframes = std::vector<std::shared_ptr<const Keyframe>>;

Keyframes track(const Flight& flight, const OdometryOptions& options = {}) {
  Odometry odometry(options);
  Keyframes out;
  for (const ImageFrame& photo : flight.photos)
    for (auto& keyframe : odometry.push(photo)) out.push_back(std::move(keyframe));
  for (auto& keyframe : odometry.flush()) out.push_back(std::move(keyframe));
  return out;
}

std::map<int, std::vector<std::size_t>> segmentsOf(const Keyframes& keyframes) {
  std::map<int, std::vector<std::size_t>> segments;
  for (std::size_t i = 0; i < keyframes.size(); ++i) segments[keyframes[i]->segment].push_back(i);
  return segments;
}

struct ShapeError {
  double position = 0;      ///< worst, as a share of the flight's extent
  double rotation_deg = 0;  ///< worst, after the similarity
  double depth = 0;         ///< median error of a feature's depth, relative
  std::string text() const {
    return std::to_string(100 * position) + " % of extent, " + std::to_string(rotation_deg) +
           " deg, depth " + std::to_string(100 * depth) + " %";
  }
};

/// Shape of one segment against the truth after the best similarity.
ShapeError shapeError(const Flight& flight, const Keyframes& keyframes,
                      const std::vector<std::size_t>& members) {
  std::vector<Eigen::Vector3d> truth, local;
  for (const std::size_t i : members) {
    truth.push_back(flight.T_world_cam[i].translation());
    local.push_back(keyframes[i]->T_local_cam.translation());
  }
  const auto S = alignPoints(truth, local, AlignmentModel::kSim3);
  if (!S) return {1, 180, 1};
  double extent = 0;
  for (const auto& p : truth) extent = std::max(extent, (p - truth.front()).norm());
  ShapeError error;
  std::vector<double> depths;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const Keyframe& keyframe = *keyframes[members[k]];
    const Eigen::Isometry3d& T = flight.T_world_cam[members[k]];
    error.position = std::max(error.position, (*S * local[k] - truth[k]).norm() / extent);
    error.rotation_deg =
        std::max(error.rotation_deg, rotationErrorDeg(S->carry(keyframe.T_local_cam), T));
    for (std::size_t f = 0; f < keyframe.features->size(); ++f) {
      if (keyframe.inverse_depth[f] <= 0) continue;
      const Eigen::Vector3d ray =
          keyframe.camera.undistort(keyframe.features->pixel[f].cast<double>()).homogeneous();
      const Eigen::Vector3d hit = flight.scene.hit(T.translation(), T.linear() * ray);
      const double depth = (T.inverse() * hit).z();
      depths.push_back(
          std::abs(S->scale / static_cast<double>(keyframe.inverse_depth[f]) / depth - 1));
    }
  }
  error.depth = support::quantile(depths, 0.5);
  return error;
}

/// Two lines, there and back: forward overlap 75 %, side overlap 55 %.
Flight twoLines(double roof_m) {
  Flight flight(roof_m);
  for (int i = 0; i < 6; ++i) flight.take(-35 + 14 * i, -15, -M_PI / 2);
  for (int i = 0; i < 6; ++i) flight.take(35 - 14 * i, 15, M_PI / 2);
  return flight;
}

class WholeFlight : public testing::TestWithParam<double> {};

TEST_P(WholeFlight, IsOneSegmentOfTheRightShape) {
  const Flight flight = twoLines(GetParam());
  const Keyframes keyframes = track(flight);
  ASSERT_EQ(keyframes.size(), flight.photos.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const Keyframe& k = *keyframes[i];
    EXPECT_EQ(k.id, flight.photos[i].id);
    EXPECT_EQ(k.time, flight.photos[i].time);
    EXPECT_EQ(k.name, flight.photos[i].name);
    EXPECT_EQ(k.segment, 0);
    EXPECT_GE(k.inliers, 20);
    ASSERT_EQ(k.inverse_depth.size(), k.features->size());
    EXPECT_LE(k.features->size(), 2000u);
    EXPECT_GT(std::count_if(k.inverse_depth.begin(), k.inverse_depth.end(),
                            [](float d) { return d > 0; }),
              100);
  }
  std::vector<std::size_t> all(keyframes.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const ShapeError error = shapeError(flight, keyframes, all);
  RecordProperty("error", error.text());
  // Measured: 0.012 % of the extent, 0.022 degrees, depth 0.017 %.
  EXPECT_LT(error.position, 0.001) << error.text();
  EXPECT_LT(error.rotation_deg, 0.05) << error.text();
  EXPECT_LT(error.depth, 0.0005) << error.text();
}

/// Height of the roof [m]: exactly level ground, and a house.
INSTANTIATE_TEST_SUITE_P(Roof, WholeFlight, testing::Values(0.0, 8.0));

Flight straight(double roof_m, int photos, double step_m) {
  Flight flight(roof_m);
  for (int i = 0; i < photos; ++i) flight.take((i - 0.5 * (photos - 1)) * step_m, 0, -M_PI / 2);
  return flight;
}

OdometryOptions fewFeatures() {
  OdometryOptions options;
  options.features.max_features = 1000;
  return options;
}

/// Of a flight that should be one segment.
ShapeError errorOfOneSegment(const Flight& flight, const Keyframes& keyframes) {
  std::vector<std::size_t> all(keyframes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  EXPECT_EQ(segmentsOf(keyframes).size(), 1u);
  const ShapeError error = shapeError(flight, keyframes, all);
  testing::Test::RecordProperty("error", error.text());
  return error;
}

/// With a forward overlap of 56 % and 54 % the photo before last sees an eighth, and a twelfth of a
/// photo: the few landmarks in that strip at the edge do not hold a pose, but they give the
/// baseline its length.
class LittleOverlap : public testing::TestWithParam<double> {};

TEST_P(LittleOverlap, IsOneSegmentOfTheRightShape) {
  const Flight flight = straight(8, 8, GetParam());
  const Keyframes keyframes = track(flight, fewFeatures());
  const ShapeError error = errorOfOneSegment(flight, keyframes);
  EXPECT_LT(error.position, 0.002) << error.text();
  // Positions on one line leave the whole free to roll about it: rotations from photo to photo.
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    const Eigen::Isometry3d T = keyframes[i - 1]->T_local_cam.inverse() * keyframes[i]->T_local_cam;
    const Eigen::Isometry3d T_true = flight.T_world_cam[i - 1].inverse() * flight.T_world_cam[i];
    EXPECT_LT(rotationErrorDeg(T, T_true), 0.15);
  }
}

/// Between photos [m].
INSTANTIATE_TEST_SUITE_P(Step, LittleOverlap, testing::Values(24.4, 25.5));

/// With a forward overlap of 50 % and 48 % no photo but its neighbours sees what a photo sees: the
/// ground carries the scale from pair to pair.
class HalfOverlap : public testing::TestWithParam<double> {};

TEST_P(HalfOverlap, TheGroundCarriesTheScale) {
  const Flight flight = straight(2, 6, GetParam());
  const ShapeError error = errorOfOneSegment(flight, track(flight, fewFeatures()));
  EXPECT_LT(error.position, 0.02) << error.text();
  EXPECT_LT(error.depth, 0.03) << error.text();
}

/// Between photos [m].
INSTANTIATE_TEST_SUITE_P(Step, HalfOverlap, testing::Values(27.7, 28.8));

/// Read noise of a cheap camera in bad light, and an exposure that swings by half from photo to
/// photo.
TEST(Odometry, NoiseAndExposureBreakNothing) {
  Flight flight(8);
  for (int i = 0; i < 7; ++i) flight.take(-42 + 14 * i, 0, -M_PI / 2);
  cv::RNG random(5);
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    cv::Mat noise(480, 640, CV_16SC3), image;
    random.fill(noise, cv::RNG::NORMAL, 0, 15);
    flight.photos[i].image.convertTo(image, CV_16SC3, i % 2 == 0 ? 1.25 : 0.7);
    image += noise;
    image.convertTo(flight.photos[i].image, CV_8UC3);
  }
  const Keyframes keyframes = track(flight);
  const auto segments = segmentsOf(keyframes);
  ASSERT_EQ(segments.size(), 1u);
  const ShapeError error = shapeError(flight, keyframes, segments.begin()->second);
  RecordProperty("error", error.text());
  EXPECT_LT(error.position, 0.01) << error.text();
}

TEST(Odometry, APoseThatHasLeftNeverChanges) {
  Flight flight(8);
  for (int i = 0; i < 7; ++i) flight.take(-42 + 14 * i, 0, -M_PI / 2);
  Odometry odometry({});
  std::map<std::uint32_t, Keyframe> left;
  std::map<int, Eigen::Isometry3d> newest;
  for (const ImageFrame& photo : flight.photos) {
    for (const auto& keyframe : odometry.push(photo)) {
      // Two photos behind, in order, each once.
      EXPECT_EQ(keyframe->id.index, left.size());
      EXPECT_EQ(keyframe->id.index + 2, photo.id.index);
      left[keyframe->id.index] = *keyframe;
    }
    const Keyframe now = odometry.provisional().back();
    EXPECT_EQ(now.id, photo.id);
    EXPECT_EQ(odometry.provisional().front().id.index, left.size());
    newest[static_cast<int>(photo.id.index)] = now.T_local_cam;
  }
  for (const auto& keyframe : odometry.flush()) left[keyframe->id.index] = *keyframe;
  ASSERT_EQ(left.size(), 7u);
  // The frame in which newer photos are told stays that of the older ones: what provisional() said
  // of a photo, and what left two photos later, differ by the refinement alone.
  for (const auto& [index, keyframe] : left) {
    if (index < 2) continue;
    const Eigen::Isometry3d& early = newest.at(static_cast<int>(index));
    const double step =
        (left.at(1).T_local_cam.translation() - left.at(0).T_local_cam.translation()).norm();
    EXPECT_LT((early.translation() - keyframe.T_local_cam.translation()).norm(), 0.05 * step);
    EXPECT_LT(rotationErrorDeg(early, keyframe.T_local_cam), 0.5);
  }
  // Later photos did not touch what had left: a run that ends earlier gives the same bytes.
  Flight part = flight;
  part.photos.resize(5);
  Odometry shorter({});
  for (const ImageFrame& photo : part.photos)
    for (const auto& keyframe : shorter.push(photo)) {
      EXPECT_EQ(keyframe->T_local_cam.matrix(), left.at(keyframe->id.index).T_local_cam.matrix());
      EXPECT_EQ(keyframe->inverse_depth, left.at(keyframe->id.index).inverse_depth);
    }
}

TEST(Odometry, AGapStartsANewSegmentAndDropsNothing) {
  Flight flight(0);
  for (int i = 0; i < 4; ++i) flight.take(14 * i, 0, -M_PI / 2);
  for (int i = 0; i < 4; ++i) flight.take(400 + 14 * i, 0, -M_PI / 2);
  const Keyframes keyframes = track(flight);
  ASSERT_EQ(keyframes.size(), 8u);
  const auto segments = segmentsOf(keyframes);
  ASSERT_EQ(segments.size(), 2u);
  for (const auto& [number, members] : segments) {
    EXPECT_EQ(members.size(), 4u);
    const ShapeError error = shapeError(flight, keyframes, members);
    EXPECT_LT(error.position, 0.002) << error.text();
  }
}

TEST(Odometry, ABlackPhotoIsAloneAndTheRestGoesOn) {
  Flight flight(8);
  for (int i = 0; i < 4; ++i) flight.take(-42 + 14 * i, 0, -M_PI / 2);
  flight.takeBlack();
  for (int i = 4; i < 7; ++i) flight.take(-42 + 14 * i, 0, -M_PI / 2);
  const Keyframes keyframes = track(flight);
  ASSERT_EQ(keyframes.size(), 8u);
  const auto segments = segmentsOf(keyframes);
  ASSERT_EQ(segments.size(), 2u);
  const int black = keyframes[4]->segment;
  EXPECT_EQ(segments.at(black).size(), 1u);
  EXPECT_EQ(keyframes[4]->matches, 0);
  EXPECT_EQ(keyframes[4]->inliers, 0);
  for (std::size_t i = 0; i < 8; ++i) {
    if (i != 4) {
      EXPECT_NE(keyframes[i]->segment, black);
    }
  }
  const int flown = keyframes[0]->segment;
  const ShapeError error = shapeError(flight, keyframes, segments.at(flown));
  EXPECT_LT(error.position, 0.002) << error.text();
}

/// Photos that show no parallax yet get their poses as soon as the UAV moves; those that had to
/// leave before are alone, none is dropped.
TEST(Odometry, AHoveringStartGetsPosesOnceItMoves) {
  for (const int still : {2, 4}) {
    Flight flight(8);
    for (int i = 0; i < still; ++i) flight.take(-42 + 0.05 * i, 0.04 * i, -M_PI / 2);
    for (int i = 1; i < 5; ++i) flight.take(-42 + 14 * i, 0, -M_PI / 2);
    const Keyframes keyframes = track(flight);
    ASSERT_EQ(keyframes.size(), flight.photos.size());
    const auto segments = segmentsOf(keyframes);
    ASSERT_EQ(segments.size(), static_cast<std::size_t>(still - 1));
    const std::vector<std::size_t>& flown = segments.at(keyframes.back()->segment);
    EXPECT_EQ(flown.size(), 6u);  // two still ones and the four after
    const ShapeError error = shapeError(flight, keyframes, flown);
    EXPECT_LT(error.position, 0.002) << error.text();
  }
}

/// The distortion is told as none: found, the flight is as straight as with the true lens.
TEST(Odometry, FindsADistortionThatItWasNotTold) {
  Flight told = twoLines(8);
  Flight untold = told;
  for (ImageFrame& photo : untold.photos) {
    photo.camera.k1 = photo.camera.k2 = 0;
    photo.camera.k1_sigma = photo.camera.k2_sigma = 0.1;
  }
  const CameraModel truth = support::distortedCamera();
  ASSERT_GT(std::abs(truth.k1), 0.02);
  const Keyframes found = track(untold);
  OdometryOptions as_given;
  as_given.calibration_photos = 0;
  const Keyframes bent = track(untold, as_given);
  ASSERT_EQ(found.size(), 12u);
  for (const auto& keyframe : found) {
    EXPECT_EQ(keyframe->camera.k1, found.front()->camera.k1);
    EXPECT_NEAR(keyframe->camera.k1, truth.k1, 0.15 * std::abs(truth.k1));
    EXPECT_EQ(keyframe->camera.fx, truth.fx);
  }
  for (const auto& keyframe : bent) EXPECT_EQ(keyframe->camera.k1, 0);
  ASSERT_EQ(segmentsOf(found).size(), 1u);
  const auto error = shapeError(untold, found, segmentsOf(found).at(0));
  const auto error_bent = shapeError(untold, bent, segmentsOf(bent).at(0));
  RecordProperty("found", error.text());
  RecordProperty("bent", error_bent.text());
  EXPECT_LT(error.position, 0.006) << error.text();
  EXPECT_LT(error.position, 0.5 * error_bent.position) << error.text() << error_bent.text();
}

/// A lens that was told right, with doubt, stays as told, and so does one told without doubt.
TEST(Odometry, LeavesALensThatIsRight) {
  Flight flight = twoLines(8);
  for (ImageFrame& photo : flight.photos) photo.camera.k1_sigma = photo.camera.k2_sigma = 0.1;
  for (const auto& keyframe : track(flight))
    EXPECT_EQ(keyframe->camera.k1, support::distortedCamera().k1);
}

TEST(Odometry, IsDeterministic) {
  Flight flight(8);
  for (int i = 0; i < 5; ++i) flight.take(-28 + 14 * i, 0, -M_PI / 2);
  const Keyframes p = track(flight), q = track(flight);
  ASSERT_EQ(p.size(), q.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_EQ(p[i]->T_local_cam.matrix(), q[i]->T_local_cam.matrix());
    EXPECT_EQ(p[i]->inverse_depth, q[i]->inverse_depth);
    EXPECT_EQ(p[i]->features->descriptor, q[i]->features->descriptor);
  }
}

}  // namespace
}  // namespace cf
