// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pacer.h"

#include <gtest/gtest.h>

#include "cf/base/stopwatch.h"

namespace cf {
namespace {

ImageFrame photoAt(double t) {
  ImageFrame photo;
  photo.name = "P.JPG";
  photo.time = static_cast<TimeNs>(t * 1e9);
  return photo;
}

TEST(Pacer, PhotosComeAsFarApartAsTheyWereTaken) {
  PlaybackOptions options;
  options.rate = 10;
  Pacer pacer(options);
  const double first = pacer.await(photoAt(100));
  EXPECT_NEAR(pacer.await(photoAt(100.5)), first + 0.05, 1e-5);
  EXPECT_NEAR(pacer.await(photoAt(100.5)), first + 0.05, 1e-5);
  EXPECT_NEAR(pacer.await(photoAt(102)), first + 0.2, 1e-5);
  EXPECT_GE(wallSeconds(), first + 0.2);
}

/// A wrong stamp, or a night between two flights, does not stop playback for years.
TEST(Pacer, ALongPauseIsCutOnce) {
  PlaybackOptions options;
  options.rate = 1;
  options.max_gap_s = 0.05;
  Pacer pacer(options);
  const double first = pacer.await(photoAt(100));
  ::testing::internal::CaptureStderr();
  EXPECT_NEAR(pacer.await(photoAt(3e9)), first + 0.05, 1e-5);
  EXPECT_NEAR(pacer.await(photoAt(3e9 + 0.01)), first + 0.06, 1e-5);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "playback: 34722 days without a photo before P.JPG: cut to 0.05 s\n");
}

TEST(Pacer, AsFastAsPossibleNothingWaits) {
  const PlaybackOptions options;
  Pacer pacer(options);
  const double first = pacer.await(photoAt(0));
  EXPECT_GE(pacer.await(photoAt(3e9)), first);
}

}  // namespace
}  // namespace cf
