// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/extract.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace cf {
namespace {

cv::Mat greyAtWorkingSize(const cv::Mat& bgr, double megapixels) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  const double factor = std::sqrt(megapixels * 1e6 / static_cast<double>(grey.total()));
  if (factor >= 1) return grey;
  cv::Mat reduced;
  cv::resize(grey, reduced,
             cv::Size(static_cast<int>(std::lround(grey.cols * factor)),
                      static_cast<int>(std::lround(grey.rows * factor))),
             0, 0, cv::INTER_AREA);
  return reduced;
}

/// The strongest of every grid cell, then the second strongest of every cell, and so on until
/// `wanted` are taken. Ties are broken by position, so the result has one order.
std::vector<int> spread(const std::vector<cv::KeyPoint>& keypoints, cv::Size size, int wanted) {
  const int columns = 16, rows = std::max(1, 16 * size.height / size.width);
  std::vector<std::vector<int>> cells(static_cast<std::size_t>(columns * rows));
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const int cx =
        std::clamp(static_cast<int>(keypoints[i].pt.x * columns / size.width), 0, columns - 1);
    const int cy =
        std::clamp(static_cast<int>(keypoints[i].pt.y * rows / size.height), 0, rows - 1);
    cells[static_cast<std::size_t>(cy * columns + cx)].push_back(static_cast<int>(i));
  }
  const auto stronger = [&](int i, int j) {
    const auto& a = keypoints[static_cast<std::size_t>(i)];
    const auto& b = keypoints[static_cast<std::size_t>(j)];
    if (a.response != b.response) return a.response > b.response;
    if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
    if (a.pt.x != b.pt.x) return a.pt.x < b.pt.x;
    return i < j;
  };
  for (auto& cell : cells) std::sort(cell.begin(), cell.end(), stronger);
  std::vector<int> chosen;
  for (std::size_t rank = 0; static_cast<int>(chosen.size()) < wanted; ++rank) {
    const std::size_t before = chosen.size();
    for (const auto& cell : cells)
      if (rank < cell.size() && static_cast<int>(chosen.size()) < wanted)
        chosen.push_back(cell[rank]);
    if (chosen.size() == before) break;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

void FeatureOptions::visit(OptionVisitor& v) {
  v.number("megapixels", megapixels, {0.05, 20}, "size at which features are sought [MP]");
  v.integer("max_features", max_features, {100, 20000}, "features kept per photo");
  v.number("contrast", contrast, {0.0001, 0.2}, "SIFT's contrast threshold");
}

FeatureSet extractFeatures(const ImageFrame& frame, const FeatureOptions& options) {
  const cv::Mat grey = greyAtWorkingSize(frame.image, options.megapixels);
  // Three times as many as wanted by strength, from which the even spread chooses.
  const auto sift = cv::SIFT::create(3 * options.max_features, 3, options.contrast, 10, 1.6);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  sift->detectAndCompute(grey, cv::noArray(), keypoints, descriptors);

  const double sx = static_cast<double>(frame.camera.width) / grey.cols;
  const double sy = static_cast<double>(frame.camera.height) / grey.rows;
  FeatureSet set;
  set.pixel_size = sx;
  for (const int index : spread(keypoints, grey.size(), options.max_features)) {
    const cv::KeyPoint& k = keypoints[static_cast<std::size_t>(index)];
    set.pixel.emplace_back(static_cast<float>((k.pt.x + 0.5) * sx - 0.5),
                           static_cast<float>((k.pt.y + 0.5) * sy - 0.5));
    set.scale_px.push_back(static_cast<float>(k.size * sx));
    const float* d = descriptors.ptr<float>(index);
    const float sum = std::max(1e-6f, std::accumulate(d, d + FeatureSet::kDescriptorSize, 0.0f));
    for (int i = 0; i < FeatureSet::kDescriptorSize; ++i)
      set.descriptor.push_back(static_cast<std::uint8_t>(
          std::min(255L, std::lround(512.0f * std::sqrt(std::max(0.0f, d[i]) / sum)))));
    const int px = std::clamp(static_cast<int>(k.pt.x * frame.image.cols / grey.cols), 0,
                              frame.image.cols - 1);
    const int py = std::clamp(static_cast<int>(k.pt.y * frame.image.rows / grey.rows), 0,
                              frame.image.rows - 1);
    const auto& bgr = frame.image.at<cv::Vec3b>(py, px);
    set.colour.insert(set.colour.end(), {bgr[0], bgr[1], bgr[2]});
  }
  return set;
}

FeatureSet subset(const FeatureSet& features, const std::vector<int>& indices) {
  FeatureSet out;
  out.pixel_size = features.pixel_size;
  for (const int index : indices) {
    const auto i = static_cast<std::size_t>(index);
    out.pixel.push_back(features.pixel[i]);
    out.scale_px.push_back(features.scale_px[i]);
    out.descriptor.insert(out.descriptor.end(), features.row(i),
                          features.row(i) + FeatureSet::kDescriptorSize);
    out.colour.insert(out.colour.end(), features.colour.begin() + 3 * index,
                      features.colour.begin() + 3 * index + 3);
  }
  return out;
}

}  // namespace cf
