// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "estimated_poses.h"

#include <fmt/format.h>

#include <set>
#include <tuple>

#include "cf/base/error.h"
#include "cf/formats/csv.h"
#include "cf/formats/pose_covariance_csv.h"
#include "cf/formats/tum.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

/// Rows of the TUM file belong to the posed photos of the csv in order; the time confirms it.
void addUav(const fs::path& csv, const fs::path& tum, EstimatedPoses& estimated) {
  const CsvTable table(csv);
  const std::size_t image = table.column("image"), t = table.column("t"),
                    status = table.column("status");
  std::multimap<TimeNs, Eigen::Isometry3d> poses;
  for (const TimedPose& pose : readTum(tum)) poses.emplace(pose.time, pose.T_world_cam);
  const PoseCovariances covariances = readCovariances(tum);
  for (const CsvRow& row : table.rows()) {
    if (row[status] != "posed") continue;
    const TimeNs time = timeFromText(row[t]);
    const auto pose = poses.lower_bound(time);
    if (pose == poses.end() || pose->first != time)
      throw RunError(fmt::format("{}: has no row for {} at t = {}, which {} calls posed",
                                 tum.string(), row[image], row[t], csv.string()));
    EstimatedPose estimate{csv.stem().string(), time, pose->second, {}, 0};
    const auto covariance = covariances.find({row[image], time});
    if (covariance != covariances.end())
      std::tie(estimate.component, estimate.covariance) = covariance->second;
    estimated.emplace(row[image], estimate);
    poses.erase(pose);
  }
  if (!poses.empty())
    throw RunError(fmt::format("{}: {} rows belong to no posed photo of {}", tum.string(),
                               poses.size(), csv.string()));
}

}  // namespace

PoseCovariances readCovariances(fs::path tum) {
  PoseCovariances covariances;
  const fs::path file = tum.replace_extension(".covariance.csv");
  if (fs::exists(file))
    for (const PoseCovarianceRow& row : readPoseCovariances(file))
      covariances[{row.image, row.time}] = {row.component, row.covariance};
  return covariances;
}

EstimatedPoses readEstimatedPoses(const fs::path& out_dir) {
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

}  // namespace cf
