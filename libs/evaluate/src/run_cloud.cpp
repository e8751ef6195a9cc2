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
constexpr std::size_t kSeenSamples = 200'000;
constexpr int kLooks = 2;  ///< on either side of a pixel, for a surface near a point
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

/// Is one of the surfaces that the photos really see within `reach_m` of the point? Looks at the
/// true depths about its pixel in each photo: walls and ground below crowns are surfaces, too,
/// which a model of the topmost one lacks.
bool onSeenSurface(const std::vector<TruthView>& views, const Eigen::Vector3d& p_world,
                   double reach_m) {
  return std::any_of(views.begin(), views.end(), [&](const TruthView& view) {
    const Eigen::Vector3d p = view.T_cam_world * p_world;
    const CameraModel& c = *view.camera;
    if (p.z() <= 0 || std::abs(p.x() / p.z()) > c.width / c.fx ||
        std::abs(p.y() / p.z()) > c.height / c.fy)
      return false;
    const Eigen::Vector2d pixel = c.project(p);
    const double reach_px = reach_m * c.fx / p.z();
    for (int j = -kLooks; j <= kLooks; ++j)
      for (int i = -kLooks; i <= kLooks; ++i) {
        const Eigen::Vector2d at = pixel + Eigen::Vector2d(i, j) * (reach_px / (kLooks + 1));
        const Eigen::Vector2d cell = (at / view.depth.step).array().round();
        if (!(cell.minCoeff() >= 0) || cell.x() >= view.depth.values.cols ||
            cell.y() >= view.depth.values.rows)
          continue;
        const auto z = static_cast<double>(
            view.depth.values.at<float>(static_cast<int>(cell.y()), static_cast<int>(cell.x())));
        if (!(z > 0) || std::abs(z - p.z()) > reach_m) continue;
        const Eigen::Vector3d seen = z * c.undistort(cell * view.depth.step).homogeneous();
        if ((seen - p).norm() <= reach_m) return true;
      }
    return false;
  });
}

/// Heights of cloud points above the topmost surface where it is smooth; points on another one, as
/// a facade or the ground below a crown, do not count.
Json heightFigures(const Points& samples, const HeightGrid& grid,
                   const std::vector<TruthView>& views, std::optional<double> matched_size_m) {
  std::vector<double> errors;
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Vector3f& sample : samples) {
    const Eigen::Vector3d p = sample.cast<double>();
    const auto z = grid.smoothHeight(p.head<2>());
    if (!z) continue;
    if (std::abs(p.z() - *z) > kFlying_m && onSeenSurface(views, p, kFlying_m)) continue;
    places.emplace_back(p.head<2>());
    errors.push_back(p.z() - *z);
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
/// the point is a wall, and a wall is a surface; so is what any photo really sees.
Json flyingFigures(const Points& samples, const HeightGrid& grid, const KdTree<3>& reference,
                   const std::vector<TruthView>& views) {
  enum class Fate : char { kOutside, kOnSurface, kFlying };
  std::vector<Fate> fates(samples.size(), Fate::kOutside);
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    const Eigen::Vector3d p = samples[i].cast<double>();
    if (!grid.heightRange(p.head<2>(), kFlying_m)) return;
    const auto wall = grid.heightRange(p.head<2>(), grid.spacing_m);
    const bool at_wall =
        wall && p.z() >= wall->first - kFlying_m && p.z() <= wall->second + kFlying_m;
    constexpr float kReach2 = static_cast<float>(kFlying_m * kFlying_m);
    const bool on_surface = at_wall || reference.nearestDistance2(samples[i], kReach2) < kReach2 ||
                            onSeenSurface(views, p, kFlying_m);
    fates[i] = on_surface ? Fate::kOnSurface : Fate::kFlying;
  });
  const auto count = [&](Fate fate) {
    return static_cast<double>(std::count(fates.begin(), fates.end(), fate));
  };
  const double judged = count(Fate::kOnSurface) + count(Fate::kFlying);
  return {{"share", judged > 0 ? finite(count(Fate::kFlying) / judged) : Json(nullptr)},
          {"outside_share", count(Fate::kOutside) / static_cast<double>(samples.size())}};
}

/// The reference points that two photos see; all where no photo's depths are known.
Points seenByTwo(const Points& reference, const std::vector<TruthView>& views) {
  const Points samples = everyNth(reference, views.empty() ? kMaxSamples : kSeenSamples);
  if (views.empty()) return samples;
  std::vector<char> kept(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    Eigen::Vector2d pixel;
    int seen = 0;
    for (const TruthView& view : views) {
      if (!view.sees(samples[i].cast<double>(), pixel)) continue;
      if (++seen == 2) break;
    }
    kept[i] = seen == 2;
  });
  Points out;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (kept[i]) out.push_back(samples[i]);
  return out;
}

/// Share of the reference points with an estimated point nearer than `reach_m`, in 3 dimensions or
/// (Dim = 2) seen from above.
template <int Dim>
Json shareReached(const Points& reference, const Points& estimate, double reach_m) {
  if (reference.empty()) return nullptr;
  std::vector<typename KdTree<Dim>::Point> points;
  points.reserve(estimate.size());
  for (const Eigen::Vector3f& p : estimate) points.push_back(p.head<Dim>());
  const KdTree<Dim> tree(std::move(points));
  const auto reach2 = static_cast<float>(reach_m * reach_m);
  std::vector<char> near(reference.size());
  tbb::parallel_for(std::size_t{0}, reference.size(), [&](std::size_t i) {
    near[i] = tree.nearestDistance2(reference[i].head<Dim>(), reach2) < reach2 ? 1 : 0;
  });
  return static_cast<double>(std::count(near.begin(), near.end(), 1)) /
         static_cast<double>(reference.size());
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

RunSection cloudFigures(const RunInputs& run, const std::vector<TruthView>& views,
                        const Sim3& S_ref_est, std::optional<double> matched_size_m) {
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
  const Points seen = seenByTwo(clouds.reference, views);
  const double reach_m = std::max(kLeastReach_m, 2 * matched_size_m.value_or(0));
  Json out = {{"points", clouds.estimate.size()},
              {"matched_pixel_m", matched_size_m ? Json(*matched_size_m) : Json(nullptr)},
              {"completeness", shareReached<3>(seen, clouds.estimate, reach_m)},
              {"coverage", shareReached<2>(seen, clouds.estimate, reach_m)},
              {"completeness_reach_m", reach_m},
              {"height", nullptr},
              {"flying", nullptr}};
  if (std::filesystem::exists(dsm)) {
    const HeightGrid grid = readHeightGrid(dsm);
    const Points samples = everyNth(clouds.estimate, kMaxSamples);
    out["height"] = heightFigures(samples, grid, views, matched_size_m);
    out["flying"] = flyingFigures(samples, grid, KdTree<3>(clouds.reference), views);
  }
  try {
    out["distance"] = Json::parse(toJson(evaluateCloud(std::move(clouds), false), matched_size_m));
  } catch (const RunError& e) {
    return Failure{"apart", e.what()};
  }
  return out;
}

}  // namespace cf
