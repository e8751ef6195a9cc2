// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_depth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace cf {
namespace {

constexpr std::size_t kSamples = 4'000'000;          ///< of all photos together
constexpr std::size_t kCompletenessSamples = 5'000;  ///< of a photo

/// True and estimated depth at one pixel, and the ground size of a matched pixel there [m].
struct Sample {
  double truth = 0, estimate = 0, size_m = 0;
};

struct PhotoDepths {
  std::vector<Sample> samples;
  std::size_t seen_by_two = 0, with_depth = 0;
};

int strideFor(const cv::Mat& values, std::size_t wanted) {
  const double pixels = static_cast<double>(values.rows) * values.cols;
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(
                         pixels / static_cast<double>(std::max<std::size_t>(wanted, 1))))));
}

bool seenByAnother(const std::vector<TruthView>& views, const TruthView& view,
                   const Eigen::Vector3d& p_world) {
  Eigen::Vector2d pixel;
  return std::any_of(views.begin(), views.end(), [&](const TruthView& other) {
    return &other != &view && other.sees(p_world, pixel);
  });
}

PhotoDepths compare(const RunInputs& run, const std::vector<TruthView>& views,
                    const TruthView& view, std::size_t wanted) {
  PhotoDepths out;
  const RunUav& uav = run.uavs[view.uav];
  const RunPhoto& photo = uav.photos[view.photo];
  const SparseDepth truth = readSparseDepth(depthFile(run.truth_dir, uav, photo));
  const std::filesystem::path file = depthFile(run.out_dir, uav, photo);
  const bool mapped = std::filesystem::exists(file);
  const SparseDepth estimate = mapped ? readSparseDepth(file) : truth;
  const Eigen::Isometry3d T_world_cam = view.T_cam_world.inverse();
  const auto each = [&](int stride, const auto& take) {
    for (int j = 0; j < estimate.values.rows; j += stride)
      for (int i = 0; i < estimate.values.cols; i += stride) {
        const Eigen::Vector2d pixel(i * estimate.step, j * estimate.step);
        const double z = truth.at(pixel);
        if (z > 0)
          take(pixel, z, mapped ? static_cast<double>(estimate.values.at<float>(j, i)) : 0.0);
      }
  };
  each(strideFor(estimate.values, wanted), [&](const Eigen::Vector2d&, double z, double found) {
    if (found > 0) out.samples.push_back({z, found, z * estimate.step / view.camera->fx});
  });
  each(strideFor(estimate.values, kCompletenessSamples),
       [&](const Eigen::Vector2d& pixel, double z, double found) {
         const Eigen::Vector3d p = T_world_cam * (z * view.camera->undistort(pixel).homogeneous());
         if (!seenByAnother(views, view, p)) return;
         ++out.seen_by_two;
         if (found > 0) ++out.with_depth;
       });
  return out;
}

Json errorsOf(const std::vector<PhotoDepths>& photos, double scale) {
  std::vector<double> metres, sizes;
  for (const PhotoDepths& photo : photos)
    for (const Sample& s : photo.samples) {
      metres.push_back(scale * s.estimate - s.truth);
      sizes.push_back(metres.back() / s.size_m);
    }
  return {{"m", spreadOf(metres)}, {"matched_pixels", spreadOf(sizes)}};
}

}  // namespace

RunSection depthFigures(const RunInputs& run, const std::vector<TruthView>& views, double scale) {
  std::vector<const TruthView*> mapped;
  for (const TruthView& view : views)
    if (view.mapped) mapped.push_back(&view);
  if (mapped.empty()) return Failure{"no_truth", "the truth has no depth maps"};
  if (!std::filesystem::is_directory(run.out_dir / "depth"))
    return Failure{"no_depth", "the run has no depth maps: cf-run -s deliver.depth_maps=1"};
  std::vector<PhotoDepths> photos(mapped.size());
  tbb::parallel_for(std::size_t{0}, mapped.size(), [&](std::size_t i) {
    photos[i] = compare(run, views, *mapped[i], kSamples / mapped.size());
  });
  std::size_t seen_by_two = 0, with_depth = 0, samples = 0;
  for (const PhotoDepths& photo : photos) {
    seen_by_two += photo.seen_by_two;
    with_depth += photo.with_depth;
    samples += photo.samples.size();
  }
  if (samples == 0) return Failure{"no_common_pixel", "no pixel has a true and an estimated depth"};
  return Json{{"photos", mapped.size()},
              {"completeness", seen_by_two > 0 ? finite(static_cast<double>(with_depth) /
                                                        static_cast<double>(seen_by_two))
                                               : Json(nullptr)},
              {"as_is", errorsOf(photos, 1)},
              {"scaled", errorsOf(photos, scale)}};
}

}  // namespace cf
