// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// A depth frame whose checksum is right, so that what it guards is reached too.
#include <zlib.h>

#include <cstring>
#include <opencv2/core.hpp>

#include "cf/formats/depth_frame_file.h"
#include "fuzz/fuzz_target.h"

std::vector<std::string> cf::fuzz::seeds() {
  DepthFrame frame;
  frame.reference_view.width = frame.partner_view.width = 40;
  frame.reference_view.height = frame.partner_view.height = 30;
  frame.disparity.create(30, 40, CV_16U);
  frame.confidence.create(30, 40, CV_8U);
  frame.colour = cv::Mat(30, 40, CV_8UC3, cv::Scalar(10, 120, 90));
  for (int v = 0; v < 30; ++v)
    for (int u = 0; u < 40; ++u) {
      frame.disparity.at<ushort>(v, u) = static_cast<ushort>(u % 7 == 0 ? 0 : 60'000 + v - 3 * u);
      frame.confidence.at<uchar>(v, u) = static_cast<uchar>(u + v);
    }
  return {encodeDepthFrame(frame)};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string bytes(reinterpret_cast<const char*>(data), size);
  std::uint32_t checksum = 0;
  if (size > sizeof checksum) {
    checksum = static_cast<std::uint32_t>(crc32_z(0, data, size - sizeof checksum));
    std::memcpy(&bytes[size - sizeof checksum], &checksum, sizeof checksum);
  }
  cf::fuzz::expectOneLineAtMost("a.depth", [&] {
    const cf::DepthFrame frame = cf::decodeDepthFrame(bytes, "a.depth");
    const cv::Size size_px(frame.reference_view.width, frame.reference_view.height);
    cf::fuzz::require(frame.disparity.size() == size_px && frame.confidence.size() == size_px &&
                          frame.colour.size() == size_px,
                      "pictures of the size told");
  });
  return 0;
}
