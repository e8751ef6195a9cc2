// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "resample.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

/// Places all over an image of that size and up to 5 px beyond it.
RemapTable anyPlaces(cv::Size image, cv::Size size) {
  cv::RNG random(3);
  RemapTable table;
  table.fixed_xy.create(size, CV_16SC2);
  table.fraction.create(size, CV_16UC1);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      table.fixed_xy.at<cv::Vec2s>(v, u) = {
          static_cast<short>(random.uniform(-5, image.width + 5)),
          static_cast<short>(random.uniform(-5, image.height + 5))};
      table.fraction.at<ushort>(v, u) = static_cast<ushort>(random.uniform(0, 1024));
    }
  return table;
}

TEST(Resample, IsOpencvsToTheLastBit) {
  for (const int type : {CV_8UC1, CV_8UC3})
    for (const cv::Size size : {cv::Size(61, 47), cv::Size(5, 4), cv::Size(1, 1)}) {
      cv::Mat image(size, type);
      cv::RNG random(5);
      random.fill(image, cv::RNG::UNIFORM, 0, 256);
      const RemapTable table = anyPlaces(size, {301, 203});
      cv::Mat out(table.fixed_xy.size(), type), wanted;
      resample(image, table, out);
      cv::remap(image, wanted, table.fixed_xy, table.fraction, cv::INTER_LINEAR,
                cv::BORDER_REPLICATE);
      EXPECT_EQ(cv::norm(out, wanted, cv::NORM_INF), 0) << size << " type " << type;
    }
}

}  // namespace
}  // namespace cf
