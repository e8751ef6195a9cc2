// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "cf/types/depth_frame.h"
#include "truth_flight.h"

namespace cf::bench {

/// A depth frame beside the truth, on the pixels of its reference view. Depths are along the
/// photo's axis [m]; the truth is looked up at the photo's pixel, so that it needs no alignment of
/// a run's poses with the true ones. d is the ground size of a matched pixel: depth over focal
/// length of the rectified view.
struct ComparedFrame {
  cv::Mat truth;      ///< CV_32F, 0 = none
  cv::Mat estimate;   ///< CV_32F, 0 = none
  cv::Mat visible;    ///< CV_8U, 255 where the partner sees what the reference sees
  cv::Mat near_step;  ///< CV_8U, 255 where the truth changes by more than 1 m within 3 px
  double f = 0, baseline_m = 0;

  double groundSize(int v, int u) const { return truth.at<float>(v, u) / f; }
  /// Estimate minus truth in units of d.
  double error(int v, int u) const {
    return (estimate.at<float>(v, u) - truth.at<float>(v, u)) / groundSize(v, u);
  }
};

ComparedFrame compareFrame(const TruthFlight& flight, const DepthFrame& frame);

/// Figures over many frames.
class DenseFigures {
 public:
  void add(const ComparedFrame& compared, const DepthFrame& frame);
  /// A failed pair, or the CPU time of one.
  void addPair(double cpu_s, bool matched, double megapixels);
  /// Ground of a photo that any other photo sees, and how much of it has a depth within 3 d.
  void addPhoto(std::size_t seen, std::size_t complete, double cpu_s);
  std::string text() const;

 private:
  struct Sample {
    float error_d, error_px, phase;
    std::uint8_t confidence;
    bool near_step;
  };
  void addSteps(const ComparedFrame& compared);

  std::vector<Sample> samples_;
  std::size_t pairs_ = 0, failed_ = 0, photos_ = 0;
  double pair_cpu_s_ = 0, photo_cpu_s_ = 0, megapixels_ = 0, base_to_height_ = 0, d_m_ = 0;
  std::size_t pixels_ = 0, valid_ = 0, visible_ = 0, visible_valid_ = 0, visible_close_ = 0;
  std::size_t hidden_ = 0, hidden_valid_ = 0, flying_ = 0, compared_ = 0;
  std::size_t seen_ = 0, complete_ = 0;
  std::array<std::size_t, 13> steps_wrong_{};  ///< steps of the truth by pixels on the wrong side
  std::size_t steps_known_ = 0;
};

/// Writes PREFIX_{photo,truth,depth,error,confidence}.png: depths in one range of colours, errors
/// from -3 d (blue: too near) to 3 d (red).
void drawFrame(const std::filesystem::path& prefix, const ComparedFrame& compared,
               const DepthFrame& frame);

}  // namespace cf::bench
