// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "flight_progress.h"

#include <gtest/gtest.h>

#include "cf/base/stopwatch.h"

namespace cf {
namespace {

class TwoUavs : public StepSource {
 public:
  explicit TwoUavs(bool follows) : follows_(follows) {
    hellos_.resize(2);
    hellos_[0].name = "north";
    if (!follows) hellos_[0].photos = 3;
    hellos_[1].uav = 1;
    hellos_[1].name = "s";
  }
  bool follows() const override { return follows_; }
  tbb::filter<void, Step> steps() override { return {}; }
  std::vector<SeamDone> done() override { return {}; }
  std::uint64_t bytes() const override { return 0; }

 private:
  const bool follows_;
};

SourceStep photoOf(std::uint16_t uav) {
  SourceStep step;
  step.step.uav = uav;
  step.photo.emplace();
  step.photo->id.uav = uav;
  step.taken_s = wallSeconds();
  return step;
}

TEST(FlightProgress, ALineForEachUavOfWhatIsKnown) {
  ::testing::internal::CaptureStderr();
  {
    const TwoUavs source(false);
    FlightProgress progress(source, false);
    EXPECT_EQ(progress.lines()[0], "north      0/3 photos        -  scale -  inliers -  lag -");
    progress.advance(photoOf(0));
    SourceStep step = photoOf(0);
    auto keyframe = std::make_shared<Keyframe>();
    keyframe->inliers = 312;
    step.step.keyframes.push_back({keyframe, {}});
    GeoSegment segment;
    segment.georeferenced = true;
    segment.scale = 7.31425;
    segment.scale_sigma = 0.0212;
    step.step.segments = std::make_shared<std::vector<GeoSegment>>(1, segment);
    progress.advance(step);
    const std::string line = progress.lines()[0];
    EXPECT_EQ(line.find("north      2/3 photos  "), 0u) << line;
    EXPECT_NE(line.find("/s  scale 7.314 +- 0.021  inliers 312  lag -"), std::string::npos) << line;
    EXPECT_EQ(progress.lines()[1], "s            0 photos        -  scale -  inliers -  lag -");
  }
  // Not on a terminal: plain lines, once for each UAV so early.
  const std::string shown = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(shown.find("north      2/3 photos"), 0u) << shown;
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 2) << shown;
  EXPECT_EQ(shown.find('\033'), std::string::npos);
  EXPECT_EQ(shown.find('\r'), std::string::npos);
}

TEST(FlightProgress, OfAFollowedFlightTheNumberOfPhotosIsNotKnownButTheLagIs) {
  ::testing::internal::CaptureStderr();
  {
    const TwoUavs source(true);
    FlightProgress progress(source, true);
    SourceStep step = photoOf(0);
    step.taken_s -= 100;
    progress.advance(step);
    const std::string line = progress.lines()[0];
    EXPECT_EQ(line.find("north        1 photos"), 0u) << line;
    EXPECT_NE(line.find("lag 10"), std::string::npos) << line;
  }
  ::testing::internal::GetCapturedStderr();
}

TEST(FlightProgress, NothingIsShownOfAFlightWithoutPhotos) {
  ::testing::internal::CaptureStderr();
  {
    const TwoUavs source(false);
    const FlightProgress progress(source, false);
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace cf
