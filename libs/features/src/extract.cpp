// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/extract.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <utility>

#include "describe.h"
#include "extrema.h"
#include "scale_space.h"

namespace cf {
namespace {

constexpr double kMostEnlarged = 2;   ///< there is no more to find in a small photo
constexpr double kCameraSigma = 0.5;  ///< blur of a photo as taken [px] (Lowe 2004, section 3.3)
constexpr int kLeastSide = 32;        ///< of an octave [px]

using sift::Keypoint;
using sift::Plane;

/// The photo at the size that is searched: larger ones reduced, smaller ones enlarged.
cv::Mat greyAtWorkingSize(const cv::Mat& bgr, double megapixels) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  const double factor =
      std::min(kMostEnlarged, std::sqrt(megapixels * 1e6 / static_cast<double>(grey.total())));
  const cv::Size size(static_cast<int>(std::lround(grey.cols * factor)),
                      static_cast<int>(std::lround(grey.rows * factor)));
  if (size == grey.size()) return grey;
  cv::Mat resized;
  cv::resize(grey, resized, size, 0, 0, factor < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return resized;
}

Plane planeOf(const cv::Mat& grey) {
  Plane plane(grey.cols, grey.rows);
  for (int y = 0; y < grey.rows; ++y) {
    const std::uint8_t* from = grey.ptr<std::uint8_t>(y);
    float* to = plane.row(y);
    for (int x = 0; x < grey.cols; ++x) to[x] = static_cast<float>(from[x]) / 255;
  }
  return plane;
}

/// Pixels of the searched image per pixel of an octave.
float octavePixel(const Keypoint& k) { return static_cast<float>(1 << k.octave); }

/// The strongest of every grid cell, then the second strongest of every cell, and so on. Ties are
/// broken by position, so the result has one order.
std::vector<Keypoint> spread(const std::vector<Keypoint>& keypoints, cv::Size size, int wanted) {
  const int columns = 16, rows = std::max(1, 16 * size.height / size.width);
  std::vector<std::vector<Keypoint>> cells(static_cast<std::size_t>(columns * rows));
  for (const Keypoint& k : keypoints) {
    const auto cellAt = [&](float at, int cells_across, int pixels) {
      return std::clamp(static_cast<int>(at * octavePixel(k)) * cells_across / pixels, 0,
                        cells_across - 1);
    };
    const int cell = cellAt(k.y, rows, size.height) * columns + cellAt(k.x, columns, size.width);
    cells[static_cast<std::size_t>(cell)].push_back(k);
  }
  const auto order = [](const Keypoint& k) {
    return std::make_tuple(-k.response, k.octave, k.y, k.x, k.level);
  };
  for (auto& cell : cells) {
    std::sort(cell.begin(), cell.end(),
              [&](const Keypoint& a, const Keypoint& b) { return order(a) < order(b); });
    // Two neighbours of one value are both extrema, and fit the same one.
    cell.erase(
        std::unique(cell.begin(), cell.end(),
                    [&](const Keypoint& a, const Keypoint& b) { return order(a) == order(b); }),
        cell.end());
  }
  std::vector<Keypoint> chosen;
  for (std::size_t rank = 0; static_cast<int>(chosen.size()) < wanted; ++rank) {
    const std::size_t before = chosen.size();
    for (const auto& cell : cells)
      if (rank < cell.size() && static_cast<int>(chosen.size()) < wanted)
        chosen.push_back(cell[rank]);
    if (chosen.size() == before) break;
  }
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
  const double enlarged = std::max(1.0, static_cast<double>(grey.cols) / frame.image.cols);

  // Of the octaves only the levels that keypoints are described on are kept.
  std::vector<std::array<Plane, sift::kScales>> described;
  std::vector<Keypoint> keypoints;
  sift::Octave octave = sift::firstOctave(planeOf(grey), kCameraSigma * enlarged);
  for (int o = 0;; ++o) {
    sift::findExtrema(octave, o, options.contrast, keypoints);
    const bool last = std::min(octave[0].width(), octave[0].height()) < 2 * kLeastSide;
    sift::Octave next = last ? sift::Octave{} : sift::nextOctave(octave);
    described.push_back({std::move(octave[1]), std::move(octave[2]), std::move(octave[3])});
    if (last) break;
    octave = std::move(next);
  }

  const double sx = static_cast<double>(frame.camera.width) / grey.cols;
  const double sy = static_cast<double>(frame.camera.height) / grey.rows;
  FeatureSet set;
  set.pixel_size = std::max(1.0, sx);
  for (const Keypoint& k : spread(keypoints, grey.size(), options.max_features)) {
    const auto nearest = std::clamp(std::lround(k.level), 1L, static_cast<long>(sift::kScales));
    const Plane& level =
        described[static_cast<std::size_t>(k.octave)][static_cast<std::size_t>(nearest - 1)];
    const double x = k.x * octavePixel(k), y = k.y * octavePixel(k);
    const int px = std::clamp(static_cast<int>((x + 0.5) * frame.image.cols / grey.cols), 0,
                              frame.image.cols - 1);
    const int py = std::clamp(static_cast<int>((y + 0.5) * frame.image.rows / grey.rows), 0,
                              frame.image.rows - 1);
    const auto& bgr = frame.image.at<cv::Vec3b>(py, px);
    for (const float orientation : sift::orientations(level, k)) {
      if (static_cast<int>(set.size()) >= options.max_features) break;
      set.pixel.emplace_back(static_cast<float>((x + 0.5) * sx - 0.5),
                             static_cast<float>((y + 0.5) * sy - 0.5));
      set.scale_px.push_back(
          static_cast<float>(2 * sift::sigmaOfLevel(k.level) * octavePixel(k) * sx));
      const std::size_t end = set.descriptor.size();
      set.descriptor.resize(end + FeatureSet::kDescriptorSize);
      sift::describe(level, k, orientation, set.descriptor.data() + end);
      set.colour.insert(set.colour.end(), {bgr[0], bgr[1], bgr[2]});
    }
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
