// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "cf/base/error.h"
#include "cf/base/time.h"
#include "cf/evaluate/trajectory.h"
#include "cf/formats/csv.h"
#include "cf/formats/tum.h"
#include "estimated_poses.h"
#include "pose_consistency.h"
#include "world_origin.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kSameTime = kNsPerSecond / 100;

/// An estimated pose is joined with one reference photo at most.
struct Candidate {
  EstimatedPose pose;
  bool used = false;
};
using Candidates = std::multimap<std::string, Candidate>;

/// The estimate of a reference photo, if there is one and no doubt about it.
Candidate* find(Candidates& estimated, const fs::path& photo, TimeNs time) {
  const auto [first, last] = estimated.equal_range(photo.filename().string());
  const std::string uav = photo.parent_path().filename().string();
  std::vector<Candidate*> candidates, same_uav, same_time;
  for (auto it = first; it != last; ++it) {
    if (it->second.used) continue;
    candidates.push_back(&it->second);
    if (it->second.pose.uav == uav) same_uav.push_back(&it->second);
    if (std::abs(it->second.pose.time - time) <= kSameTime) same_time.push_back(&it->second);
  }
  for (const auto* choice : {&same_uav, &same_time})
    if (choice->size() == 1) return choice->front();
  return std::distance(first, last) == 1 && candidates.size() == 1 ? candidates.front() : nullptr;
}

}  // namespace

PosePairs pairByName(const fs::path& out_dir, const fs::path& ref_dir) {
  Candidates estimated;
  for (const auto& [name, pose] : readEstimatedPoses(out_dir))
    estimated.emplace(name, Candidate{pose});
  const Eigen::Isometry3d T_ref_est =
      transformBetweenWorlds(out_dir, ref_dir).value_or(Eigen::Isometry3d::Identity());
  const std::vector<CsvRow> photos = readCsvRows(ref_dir / "images.tsv", '\t');
  const std::vector<TimedPose> poses = readTum(ref_dir / "poses.tum");
  if (photos.size() != poses.size())
    throw RunError(
        fmt::format("{}: images.tsv has {} photos, poses.tum {} poses; line k of both "
                    "must be the same photo",
                    ref_dir.string(), photos.size(), poses.size()));
  PosePairs joined;
  for (std::size_t k = 0; k < photos.size(); ++k) {
    Candidate* estimate = find(estimated, photos[k][0], poses[k].time);
    if (!estimate) {
      ++joined.missing;
      continue;
    }
    estimate->used = true;
    joined.pairs.push_back(
        {estimate->pose.uav, T_ref_est * estimate->pose.T_world_cam, poses[k].T_world_cam,
         turned(estimate->pose.covariance, T_ref_est.linear()), estimate->pose.component});
  }
  joined.unreferenced = static_cast<int>(estimated.size() - joined.pairs.size());
  return joined;
}

PosePairs pairByTime(const fs::path& estimate, const fs::path& reference) {
  std::multimap<TimeNs, Eigen::Isometry3d> left;
  for (const TimedPose& pose : readTum(estimate)) left.emplace(pose.time, pose.T_world_cam);
  PosePairs joined;
  for (const TimedPose& pose : readTum(reference)) {
    auto nearest = left.lower_bound(pose.time);
    if (nearest != left.begin() && (nearest == left.end() || pose.time - std::prev(nearest)->first <
                                                                 nearest->first - pose.time))
      --nearest;
    if (nearest == left.end() || std::abs(nearest->first - pose.time) > kSameTime) {
      ++joined.missing;
      continue;
    }
    joined.pairs.push_back({estimate.stem().string(), nearest->second, pose.T_world_cam, {}, 0});
    left.erase(nearest);
  }
  joined.unreferenced = static_cast<int>(left.size());
  return joined;
}

}  // namespace cf
