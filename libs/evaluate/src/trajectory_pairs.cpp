// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "cf/base/error.h"
#include "cf/base/time.h"
#include "cf/evaluate/trajectory.h"
#include "cf/formats/csv.h"
#include "cf/formats/tum.h"
#include "world_origin.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kSameTime = kNsPerSecond / 100;

struct EstimatedPose {
  std::string uav;
  TimeNs time = 0;
  Eigen::Isometry3d T_world_cam;
  bool used = false;
};
/// By photo name.
using EstimatedPoses = std::multimap<std::string, EstimatedPose>;

/// Rows of the TUM file belong to the posed photos of the csv in order; the time confirms it.
void addUav(const fs::path& csv, const fs::path& tum, EstimatedPoses& estimated) {
  const CsvTable table(csv);
  const std::size_t image = table.column("image"), t = table.column("t"),
                    status = table.column("status");
  std::multimap<TimeNs, Eigen::Isometry3d> poses;
  for (const TimedPose& pose : readTum(tum)) poses.emplace(pose.time, pose.T_world_cam);
  for (const CsvRow& row : table.rows()) {
    if (row[status] != "posed") continue;
    const TimeNs time = timeFromText(row[t]);
    const auto pose = poses.lower_bound(time);
    if (pose == poses.end() || pose->first != time)
      throw RunError(fmt::format("{}: has no row for {} at t = {}, which {} calls posed",
                                 tum.string(), row[image], row[t], csv.string()));
    estimated.emplace(row[image], EstimatedPose{csv.stem().string(), time, pose->second});
    poses.erase(pose);
  }
  if (!poses.empty())
    throw RunError(fmt::format("{}: {} rows belong to no posed photo of {}", tum.string(),
                               poses.size(), csv.string()));
}

EstimatedPoses readEstimate(const fs::path& out_dir) {
  const fs::path images = out_dir / "images";
  std::set<fs::path> tables;
  if (fs::is_directory(images))
    for (const auto& entry : fs::directory_iterator(images))
      if (entry.path().extension() == ".csv") tables.insert(entry.path());
  if (tables.empty())
    throw RunError(images.string() + ": has no <uav>.csv; give the output folder of a run");
  EstimatedPoses estimated;
  for (const fs::path& csv : tables)
    addUav(csv, out_dir / "trajectories" / (csv.stem().string() + ".tum"), estimated);
  return estimated;
}

/// The estimate of a reference photo, if there is one and no doubt about it.
EstimatedPose* find(EstimatedPoses& estimated, const fs::path& photo, TimeNs time) {
  const auto [first, last] = estimated.equal_range(photo.filename().string());
  const std::string uav = photo.parent_path().filename().string();
  std::vector<EstimatedPose*> candidates, same_uav, same_time;
  for (auto it = first; it != last; ++it) {
    if (it->second.used) continue;
    candidates.push_back(&it->second);
    if (it->second.uav == uav) same_uav.push_back(&it->second);
    if (std::abs(it->second.time - time) <= kSameTime) same_time.push_back(&it->second);
  }
  for (const auto* choice : {&same_uav, &same_time})
    if (choice->size() == 1) return choice->front();
  return std::distance(first, last) == 1 && candidates.size() == 1 ? candidates.front() : nullptr;
}

}  // namespace

PosePairs pairByName(const fs::path& out_dir, const fs::path& ref_dir) {
  EstimatedPoses estimated = readEstimate(out_dir);
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
    EstimatedPose* estimate = find(estimated, photos[k][0], poses[k].time);
    if (!estimate) {
      ++joined.missing;
      continue;
    }
    estimate->used = true;
    joined.pairs.push_back(
        {estimate->uav, T_ref_est * estimate->T_world_cam, poses[k].T_world_cam});
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
    joined.pairs.push_back({estimate.stem().string(), nearest->second, pose.T_world_cam});
    left.erase(nearest);
  }
  joined.unreferenced = static_cast<int>(left.size());
  return joined;
}

}  // namespace cf
