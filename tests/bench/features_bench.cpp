// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "cf/features/extract.h"
#include "cf/features/match.h"

namespace cf {
namespace {

/// Noise of several sizes, as full of blobs as a photo of a wood.
ImageFrame texturedFrame(int width, int height) {
  cv::RNG random(1);
  cv::Mat sum(height, width, CV_32FC3, cv::Scalar::all(128));
  for (const double sigma : {1.0, 2.0, 4.0, 8.0, 16.0}) {
    cv::Mat noise(height, width, CV_32FC3);
    random.fill(noise, cv::RNG::NORMAL, 0, 60 * sigma);
    cv::GaussianBlur(noise, noise, cv::Size(), sigma);
    sum += noise;
  }
  ImageFrame frame;
  sum.convertTo(frame.image, CV_8UC3);
  frame.camera.width = width;
  frame.camera.height = height;
  return frame;
}

FeatureSet randomFeatures(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::exponential_distribution<double> value(1 / 25.0);
  FeatureSet set;
  set.pixel.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count * FeatureSet::kDescriptorSize; ++i)
    set.descriptor.push_back(static_cast<std::uint8_t>(std::min(255.0, value(random))));
  return set;
}

/// Argument: pixels across of a 4:3 photo.
void extract(benchmark::State& state) {
  const auto width = static_cast<int>(state.range(0));
  const ImageFrame frame = texturedFrame(width, width * 3 / 4);
  for (auto _ : state) benchmark::DoNotOptimize(extractFeatures(frame, {}));
}
BENCHMARK(extract)->Arg(1155)->Arg(2000)->Unit(benchmark::kMillisecond);

/// Argument: descriptors of each photo.
void match(benchmark::State& state) {
  const auto count = static_cast<int>(state.range(0));
  const FeatureSet a = randomFeatures(count, 1), b = randomFeatures(count, 2);
  for (auto _ : state) benchmark::DoNotOptimize(matchFeatures(a, b));
}
BENCHMARK(match)->Arg(2000)->Arg(4000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cf
