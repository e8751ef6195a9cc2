// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "judgement.h"

#include <fmt/format.h>

#include <algorithm>

#include "cf/base/log.h"
#include "gnss_disagreement.h"
#include "unjoined_parts.h"

namespace cf {
namespace {

void settle(UavRecord& uav, FrameId id, const Alignment& alignment) {
  PhotoRecord& photo = uav.photos[id.index];
  const bool was_processed = photo.segment >= 0;
  if (photo.status == PhotoStatus::kDamaged || !was_processed) return;
  const auto entry = alignment.table.poses.find(id);
  if (entry != alignment.table.poses.end()) {
    photo.status = PhotoStatus::kPosed;
    uav.final_trajectory.push_back({id.index, entry->second.T_world_cam});
    if (!entry->second.covariance.in_world.isZero(0))
      uav.covariances[id.index] = {entry->second.component, entry->second.covariance};
    return;
  }
  const auto alone = std::count_if(uav.photos.begin(), uav.photos.end(),
                                   [&](const auto& p) { return p.segment == photo.segment; });
  photo.status = alone > 1 ? PhotoStatus::kUnjoined : PhotoStatus::kUnposed;
  photo.reason = alone > 1
                     ? "its part of the flight is not tied to the map by matches or GNSS"
                     : fmt::format("{} matches to other photos, too few that agree", photo.matches);
}

}  // namespace

void warn(RunRecord& record, const std::string& line, const std::string& advice) {
  logWarning(line);
  record.warnings.emplace_back(line, advice);
}

void judge(const Alignment& alignment, RunRecord& record) {
  record.components = alignment.components;
  record.relative_poses = alignment.relative_poses;
  record.sparse_points = alignment.points;
  record.seam_points = alignment.seam_points;
  for (std::size_t u = 0; u < record.uavs.size(); ++u) {
    UavRecord& uav = record.uavs[u];
    for (std::uint32_t i = 0; i < uav.photos.size(); ++i)
      settle(uav, {static_cast<std::uint16_t>(u), i}, alignment);
    uav.camera_after = alignment.table.cameras[u];
    const auto bias = alignment.gnss_bias_m.find(static_cast<std::uint16_t>(u));
    if (bias != alignment.gnss_bias_m.end()) uav.gnss.bias_m = bias->second;
    if (!record.world.relative && uav.gnss.fixes > 0 && !uav.gnss.trusted)
      warn(record,
           fmt::format("{}: its GNSS is not trusted: residuals of {:.1f} m horizontally and "
                       "{:.1f} m vertically against the photos",
                       uav.name, uav.gnss.sigma_m.head<2>().norm(), uav.gnss.sigma_m.z()));
  }
  for (const std::string& line : gnssDisagreements(record.uavs)) warn(record, line);
  if (alignment.components > 1)
    warn(record,
         fmt::format("the photos form {} parts that no match joins: only GNSS ties them together",
                     alignment.components));
  for (const std::string& line : unjoinedParts(record.uavs, alignment.table)) warn(record, line);
}

}  // namespace cf
