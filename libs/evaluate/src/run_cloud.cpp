// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_cloud.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "cf/base/error.h"
#include "cf/evaluate/cloud.h"
#include "cf/evaluate/doming.h"
#include "cf/formats/ply.h"
#include "height_grid.h"
#include "kd_tree.h"
#include "statistics.h"
#include "voxel_means.h"

namespace cf {
namespace {

constexpr std::size_t kMaxSamples = 2'000'000;
constexpr double kFlying_m = 1, kLeastReach_m = 0.25;

using Points = std::vector<Eigen::Vector3f>;

template <class Move>
Points readPoints(const std::filesystem::path& file, const Move& move) {
  Points points;
  PlyReader reader(file);
  PlyPoint point;
  while (reader.next(point))
    if (point.position_m.allFinite())
      points.push_back(move(point.position_m).template cast<float>());
  return points;
}

/// Heights of cloud points above the surface where it is smooth.
Json heightFigures(const Points& samples, const HeightGrid& grid,
                   std::optional<double> matched_size_m) {
  std::vector<double> errors;
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Vector3f& p : samples)
    if (const auto z = grid.smoothHeight(p.head<2>().cast<double>())) {
      places.emplace_back(p.head<2>().cast<double>());
      errors.push_back(static_cast<double>(p.z()) - *z);
    }
  if (errors.empty()) return nullptr;
  const auto flat = withoutBend(places, errors);
  Json out = {{"m", spreadOf(errors)}, {"without_bend_m", flat ? spreadOf(*flat) : Json(nullptr)}};
  if (!matched_size_m) return out;
  const auto inSizes = [&](std::vector<double> values) {
    for (double& v : values) v /= *matched_size_m;
    return values;
  };
  const std::vector<double> sizes = inSizes(errors);
  out["without_bend_matched_pixels"] = flat ? spreadOf(inSizes(*flat)) : Json(nullptr);
  const auto within = [&](double limit) {
    return static_cast<double>(std::count_if(sizes.begin(), sizes.end(),
                                             [&](double e) { return std::abs(e) <= limit; })) /
           static_cast<double>(sizes.size());
  };
  out["matched_pixels"] = spreadOf(sizes);
  out["within_1_matched_pixel"] = within(1);
  out["within_1.5_matched_pixels"] = within(1.5);
  return out;
}

/// Flying: farther than a metre from every surface. Between the heights of cells within one cell of
/// the point is a wall, and a wall is a surface.
Json flyingFigures(const Points& samples, const HeightGrid& grid, const KdTree<3>& reference) {
  enum class Fate : char { kOutside, kOnSurface, kFlying };
  std::vector<Fate> fates(samples.size(), Fate::kOutside);
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    const Eigen::Vector3d p = samples[i].cast<double>();
    if (!grid.heightRange(p.head<2>(), kFlying_m)) return;
    const auto wall = grid.heightRange(p.head<2>(), grid.spacing_m);
    const bool at_wall =
        wall && p.z() >= wall->first - kFlying_m && p.z() <= wall->second + kFlying_m;
    constexpr float kReach2 = static_cast<float>(kFlying_m * kFlying_m);
    fates[i] = at_wall || reference.nearestDistance2(samples[i], kReach2) < kReach2
                   ? Fate::kOnSurface
                   : Fate::kFlying;
  });
  const auto count = [&](Fate fate) {
    return static_cast<double>(std::count(fates.begin(), fates.end(), fate));
  };
  const double judged = count(Fate::kOnSurface) + count(Fate::kFlying);
  return {{"share", judged > 0 ? finite(count(Fate::kFlying) / judged) : Json(nullptr)},
          {"outside_share", count(Fate::kOutside) / static_cast<double>(samples.size())}};
}

/// Share of the reference points with an estimated point nearer than `reach_m`, in 3 dimensions or
/// (Dim = 2) seen from above.
template <int Dim>
double shareReached(const Points& reference, const Points& estimate, double reach_m) {
  std::vector<typename KdTree<Dim>::Point> points;
  points.reserve(estimate.size());
  for (const Eigen::Vector3f& p : estimate) points.push_back(p.head<Dim>());
  const KdTree<Dim> tree(std::move(points));
  const Points samples = everyNth(reference, kMaxSamples);
  const auto reach2 = static_cast<float>(reach_m * reach_m);
  std::vector<char> near(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    near[i] = tree.nearestDistance2(samples[i].head<Dim>(), reach2) < reach2 ? 1 : 0;
  });
  return static_cast<double>(std::count(near.begin(), near.end(), 1)) /
         static_cast<double>(samples.size());
}

}  // namespace

std::optional<double> matchedGroundSize(const RunInputs& run, const std::vector<TruthView>& views) {
  if (!run.matched_megapixels || views.empty()) return std::nullopt;
  std::vector<double> sizes;
  for (const TruthView& view : views) {
    std::vector<double> depths;
    for (int j = 0; j < view.depth.values.rows; ++j)
      for (int i = 0; i < view.depth.values.cols; ++i)
        if (view.depth.values.at<float>(j, i) > 0)
          depths.push_back(static_cast<double>(view.depth.values.at<float>(j, i)));
    if (depths.empty()) continue;
    const double pixels = static_cast<double>(view.camera->width) * view.camera->height;
    const double reduction = std::max(1.0, std::sqrt(pixels / (*run.matched_megapixels * 1e6)));
    sizes.push_back(median(std::move(depths)) * reduction / view.camera->fx);
  }
  if (sizes.empty()) return std::nullopt;
  return median(std::move(sizes));
}

RunSection cloudFigures(const RunInputs& run, const Sim3& S_ref_est,
                        std::optional<double> matched_size_m) {
  const auto estimate_file = run.out_dir / "cloud" / "cloud.ply",
             reference_file = run.truth_dir / "cloud.ply", dsm = run.truth_dir / "dsm.tif";
  if (!std::filesystem::exists(reference_file))
    return Failure{"no_truth", "the truth has no cloud.ply"};
  if (!std::filesystem::exists(estimate_file))
    return Failure{"no_cloud", "the run has no cloud/cloud.ply"};
  CloudPair clouds;
  clouds.common_world = true;
  clouds.reference = readPoints(reference_file, [](const Eigen::Vector3d& p) { return p; });
  clouds.estimate = readPoints(estimate_file, [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(S_ref_est * (run.T_ref_est * p));
  });
  if (clouds.reference.empty()) return Failure{"no_truth", "the truth's cloud.ply has no points"};
  if (clouds.estimate.empty()) return Failure{"no_cloud", "the run's cloud has no points"};
  const double reach_m = std::max(kLeastReach_m, 2 * matched_size_m.value_or(0));
  Json out = {{"points", clouds.estimate.size()},
              {"matched_pixel_m", matched_size_m ? Json(*matched_size_m) : Json(nullptr)},
              {"completeness", shareReached<3>(clouds.reference, clouds.estimate, reach_m)},
              {"coverage", shareReached<2>(clouds.reference, clouds.estimate, reach_m)},
              {"completeness_reach_m", reach_m},
              {"height", nullptr},
              {"flying", nullptr}};
  if (std::filesystem::exists(dsm)) {
    const HeightGrid grid = readHeightGrid(dsm);
    const Points samples = everyNth(clouds.estimate, kMaxSamples);
    out["height"] = heightFigures(samples, grid, matched_size_m);
    out["flying"] = flyingFigures(samples, grid, KdTree<3>(clouds.reference));
  }
  try {
    out["distance"] = Json::parse(toJson(evaluateCloud(std::move(clouds), false), matched_size_m));
  } catch (const RunError& e) {
    return Failure{"apart", e.what()};
  }
  return out;
}

}  // namespace cf
