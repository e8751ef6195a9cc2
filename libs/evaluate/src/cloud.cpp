// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/cloud.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "cf/base/error.h"
#include "cf/formats/ply.h"
#include "kd_tree.h"
#include "local_plane.h"
#include "statistics.h"
#include "voxel_means.h"
#include "world_origin.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSamples = 2'000'000;
constexpr std::size_t kPlaneNeighbours = 10;
constexpr float kHorizontalReach_m = 0.5F;

fs::path cloudFile(const fs::path& given) {
  if (!fs::is_directory(given)) return given;
  for (const fs::path& name : {fs::path("cloud") / "cloud.ply", fs::path("cloud.ply")})
    if (fs::exists(given / name)) return given / name;
  throw RunError(given.string() + ": has neither cloud/cloud.ply nor cloud.ply");
}

/// The folder whose world.json speaks for a cloud.
fs::path worldFolder(const fs::path& cloud) {
  const fs::path folder = fs::absolute(cloud).parent_path();
  return fs::exists(folder / "world.json") ? folder : folder.parent_path();
}

/// T * points - offset.
std::vector<Eigen::Vector3f> readPoints(const fs::path& file, const Eigen::Isometry3d& T,
                                        const Eigen::Vector3d& offset) {
  PlyReader reader(file);
  std::vector<Eigen::Vector3f> points;
  points.reserve(std::min<std::uint64_t>(reader.count(), 1 << 24));
  PlyPoint point;
  while (reader.next(point))
    if (point.position_m.allFinite())
      points.push_back((T * point.position_m - offset).cast<float>());
  if (points.empty()) throw RunError(file.string() + ": has no points");
  return points;
}

/// One estimated point against the reference.
struct Distances {
  bool compared = false;
  double plane_m = 0, nearest_m = 0;  ///< signed; unsigned
};

std::vector<Distances> distancesOf(const std::vector<Eigen::Vector3f>& samples,
                                   const std::vector<Eigen::Vector3f>& reference) {
  std::vector<Eigen::Vector2f> ground;
  ground.reserve(reference.size());
  for (const Eigen::Vector3f& p : reference) ground.push_back(p.head<2>());
  const KdTree<2> ground_tree(std::move(ground));
  const KdTree<3> tree(reference);
  std::vector<Distances> distances(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    const Eigen::Vector3f& p = samples[i];
    constexpr float kReach2 = kHorizontalReach_m * kHorizontalReach_m;
    if (ground_tree.nearestDistance2(p.head<2>(), kReach2) >= kReach2) return;
    Distances& d = distances[i];
    d.compared = true;
    d.nearest_m = std::sqrt(static_cast<double>(tree.nearestDistance2(p)));
    const LocalPlane plane = localPlane(tree, p, kPlaneNeighbours);
    d.plane_m = plane.determined ? plane.normal.dot(p.cast<double>() - plane.centre) : d.nearest_m;
  });
  return distances;
}

DistanceFigures figuresOf(const std::vector<double>& distances) {
  DistanceFigures figures;
  std::vector<double> magnitude;
  for (const double d : distances) magnitude.push_back(std::abs(d));
  for (std::size_t k = 0; k < kDistanceLimits_m.size(); ++k)
    figures.share_within[k] =
        static_cast<double>(std::count_if(magnitude.begin(), magnitude.end(),
                                          [&](double d) { return d <= kDistanceLimits_m[k]; })) /
        static_cast<double>(magnitude.size());
  figures.rms_m = rms(distances);
  figures.nmad_m = nmad(distances);
  figures.p95_m = quantile(magnitude, 0.95);
  figures.median_m = median(std::move(magnitude));
  return figures;
}

void completenessOf(const std::vector<Eigen::Vector3f>& reference,
                    std::vector<Eigen::Vector3f> estimate, CloudEvaluation& evaluation) {
  const KdTree<3> tree(std::move(estimate));
  const std::vector<Eigen::Vector3f> samples = everyNth(reference, kMaxSamples);
  std::vector<float> distance2(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    distance2[i] = tree.nearestDistance2(samples[i], 1.01F);
  });
  const auto shareWithin = [&](float limit) {
    return static_cast<double>(std::count_if(distance2.begin(), distance2.end(),
                                             [&](float d2) { return d2 <= limit * limit; })) /
           static_cast<double>(samples.size());
  };
  evaluation.completeness_050 = shareWithin(0.5F);
  evaluation.completeness_100 = shareWithin(1.0F);
}

}  // namespace

CloudPair readClouds(const fs::path& estimate, const fs::path& reference) {
  const fs::path est = cloudFile(estimate), ref = cloudFile(reference);
  PlyPoint first;
  if (!PlyReader(ref).next(first)) throw RunError(ref.string() + ": has no points");
  const Eigen::Vector3d offset =
      first.position_m.allFinite() ? first.position_m : Eigen::Vector3d::Zero().eval();
  const auto T_ref_est = transformBetweenWorlds(worldFolder(est), worldFolder(ref));
  CloudPair clouds;
  clouds.common_world = T_ref_est.has_value();
  clouds.reference = readPoints(ref, Eigen::Isometry3d::Identity(), offset);
  clouds.estimate = readPoints(est, T_ref_est.value_or(Eigen::Isometry3d::Identity()), offset);
  return clouds;
}

CloudEvaluation evaluateCloud(CloudPair clouds, bool icp) {
  CloudEvaluation evaluation;
  evaluation.common_world = clouds.common_world;
  evaluation.estimate_points = clouds.estimate.size();
  evaluation.reference_points = clouds.reference.size();
  if (icp) {
    const auto registration = registerClouds(clouds.estimate, clouds.reference);
    if (!registration)
      throw RunError("the clouds cannot be registered: " + registration.failure().detail);
    for (Eigen::Vector3f& p : clouds.estimate)
      p = (registration->T_ref_est * p.cast<double>()).cast<float>();
    evaluation.icp = *registration;
  }
  const std::vector<Eigen::Vector3f> samples = everyNth(clouds.estimate, kMaxSamples);
  evaluation.sampled = samples.size();
  std::vector<double> plane, nearest;
  for (const Distances& d : distancesOf(samples, clouds.reference)) {
    if (!d.compared) continue;
    plane.push_back(d.plane_m);
    nearest.push_back(d.nearest_m);
  }
  if (plane.empty())
    throw RunError(
        "no point of the estimate has a reference point within 0.5 m horizontally: "
        "check that both clouds are of one place and in one frame");
  evaluation.compared = plane.size();
  evaluation.nearest = figuresOf(nearest);
  evaluation.plane = figuresOf(plane);
  evaluation.plane_bias_m = median(std::move(plane));
  completenessOf(clouds.reference, std::move(clouds.estimate), evaluation);
  return evaluation;
}

}  // namespace cf
