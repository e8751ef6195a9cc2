// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/seam_message.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "formats/seam_examples.h"

namespace cf {
namespace {

using support::grownSegment;
using support::same;
using support::someDone;
using support::someHello;
using support::someKeyframe;
using support::someStep;

/// Through bytes and back.
::testing::AssertionResult survives(const SeamMessage& message) {
  const auto back = decodeSeamMessage(SeamEncoder().encode(message));
  if (!back) return ::testing::AssertionFailure() << back.failure().detail;
  return same(*back, message) ? ::testing::AssertionSuccess()
                              : ::testing::AssertionFailure() << "something has changed";
}

TEST(SeamMessage, keepsEveryBit) {
  std::mt19937 random(1);
  EXPECT_TRUE(survives(someHello()));
  EXPECT_TRUE(survives(someStep(50, random)));
  EXPECT_TRUE(survives(someDone()));
}

TEST(SeamMessage, keepsWhatIsNotThere) {
  std::mt19937 random(1);
  EXPECT_TRUE(survives(SeamHello{}));
  EXPECT_TRUE(survives(SeamDone{}));
  EXPECT_TRUE(survives(SeamStep{}));
  SeamStep message = someStep(0, random);
  ChainStep& step = message.step;
  auto bare = std::make_shared<Keyframe>(*step.keyframes[0].keyframe);
  bare->attitude.reset();
  bare->height_above_ground_m.reset();
  step.keyframes[0] = {bare, {}};
  step.segments = std::make_shared<std::vector<GeoSegment>>();
  step.provisional.pop_back();
  EXPECT_TRUE(survives(message));
  message.photo.reset();
  EXPECT_TRUE(survives(message));
  SeamHello hello = someHello();
  hello.photos.reset();
  EXPECT_TRUE(survives(hello));
  hello.photos = 0;
  EXPECT_TRUE(survives(hello));
}

TEST(SeamMessage, differencesAreSeenByTheComparison) {
  std::mt19937 random(1);
  const SeamStep step = someStep(5, random);
  SeamStep other = step;
  auto segments = *step.step.segments;
  segments.back().poses.back().covariance(5, 4) += 1e-16;
  other.step.segments = std::make_shared<std::vector<GeoSegment>>(segments);
  EXPECT_FALSE(same(SeamMessage(step), SeamMessage(other)));
}

TEST(SeamMessage, segmentsCrossAsFarAsTheyHaveChanged) {
  std::mt19937 random(1);
  SeamEncoder encoder;
  SeamDecoder decoder;
  GeoSegment segment;
  std::size_t largest = 0;
  for (int step = 0; step < 100; ++step) {
    segment = grownSegment(segment, random);
    if (step == 60) segment.poses.erase(segment.poses.begin() + 20, segment.poses.end());
    SeamStep message;
    if (step % 10 != 5)  // a damaged photo tells nothing of segments
      message.step.segments = std::make_shared<std::vector<GeoSegment>>(1, segment);
    const std::string bytes = encoder.encode(message);
    const auto back = decoder.decode(bytes);
    ASSERT_TRUE(back) << step << ": " << back.failure().detail;
    EXPECT_TRUE(same(*back, SeamMessage(message))) << step;
    largest = std::max(largest, bytes.size());
  }
  EXPECT_LT(largest, 2500U);  // three or six poses of a hundred
}

TEST(SeamMessage, aStepWithoutTheOneBeforeIsRefused) {
  std::mt19937 random(1);
  SeamEncoder encoder;
  const GeoSegment three = grownSegment(grownSegment(grownSegment({}, random), random), random);
  const GeoSegment four = grownSegment(three, random);
  SeamStep message;
  message.step.segments = std::make_shared<std::vector<GeoSegment>>(1, three);
  const std::string first = encoder.encode(message);
  message.step.segments = std::make_shared<std::vector<GeoSegment>>(1, four);
  const std::string second = encoder.encode(message);
  EXPECT_FALSE(decodeSeamMessage(second));
  SeamDecoder decoder;
  EXPECT_TRUE(decoder.decode(first));
  EXPECT_TRUE(decoder.decode(second));
  EXPECT_TRUE(decoder.decode(SeamEncoder().encode(someHello())));  // begins anew
  EXPECT_FALSE(decoder.decode(second));
}

TEST(SeamMessage, aSegmentNamedAgainAndAgainBringsItsPosesOnce) {
  std::mt19937 random(1);
  const GeoSegment segment = grownSegment({}, random);
  SeamEncoder encoder;
  SeamDecoder decoder;
  SeamStep message;
  message.step.segments = std::make_shared<std::vector<GeoSegment>>(1, segment);
  EXPECT_TRUE(decoder.decode(encoder.encode(message)));
  message.step.segments = std::make_shared<std::vector<GeoSegment>>(5, segment);
  EXPECT_FALSE(decoder.decode(encoder.encode(message)));
}

TEST(SeamMessage, aKeyframeOf2000FeaturesIsWithinTheBudget) {
  std::mt19937 random(1);
  SeamStep message;
  message.step.keyframes = {someKeyframe({0, 1}, 2000, random)};
  EXPECT_LE(SeamEncoder().encode(message).size(), 300'000U);
}

TEST(SeamMessage, featuresThatAreNotEquallyManyAreRefused) {
  std::mt19937 random(1);
  SeamStep message;
  message.step.keyframes = {someKeyframe({0, 1}, 20, random)};
  auto keyframe = std::make_shared<Keyframe>(*message.step.keyframes[0].keyframe);
  keyframe->chain.pop_back();
  message.step.keyframes[0].keyframe = keyframe;
  EXPECT_THROW(SeamEncoder().encode(message), RunError);
}

TEST(SeamMessage, otherBytesAreRefused) {
  std::mt19937 random(1);
  EXPECT_EQ(decodeSeamMessage("").failure().code, "damaged");
  EXPECT_EQ(decodeSeamMessage("not a message").failure().code, "damaged");
  std::string hello = SeamEncoder().encode(someHello());
  const std::size_t protocol = hello.find("\x08\x03");
  hello[protocol + 1] = 2;
  EXPECT_EQ(decodeSeamMessage(hello).failure().code, "version");
}

/// No byte of a message can make the decoder crash, hang, or take much memory; what it takes for a
/// message can be encoded again.
TEST(SeamMessage, anyByteMayBeWrong) {
  std::mt19937 random(1);
  for (const SeamMessage& message :
       {SeamMessage(someHello()), SeamMessage(someStep(2, random)), SeamMessage(someDone())}) {
    const std::string bytes = SeamEncoder().encode(message);
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      for (const int value : {0x00, 0x01, 0x7F, 0x80, 0xFF}) {
        std::string changed = bytes;
        changed[at] = static_cast<char>(value);
        const auto back = decodeSeamMessage(changed);
        EXPECT_TRUE(!back || survives(*back));
      }
      (void)decodeSeamMessage(std::string_view(bytes).substr(0, at));
    }
  }
}

}  // namespace
}  // namespace cf
