// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "ground_control_report.h"
#include "report_parts.h"
#include "summary.h"

namespace cf {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string axes(const Eigen::Vector3d& v) {
  return fmt::format("{:.2f} / {:.2f} / {:.2f}", v.x(), v.y(), v.z());
}

std::string uavTable(const RunRecord& run) {
  Rows rows;
  for (const UavRecord& uav : run.uavs) {
    const auto count = [&](PhotoStatus s) { return std::to_string(countOf(uav, s)); };
    const std::string scale = uav.scale_history.empty()
                                  ? "–"
                                  : fmt::format("{:.5g} ± {:.2g}", uav.scale_history.back().scale,
                                                uav.scale_history.back().sigma);
    rows.push_back({uav.name + (uav.name == run.world.center ? " (central)" : ""),
                    std::to_string(uav.photos.size()), count(PhotoStatus::kPosed),
                    count(PhotoStatus::kUnposed), count(PhotoStatus::kUnjoined),
                    count(PhotoStatus::kDamaged), std::to_string(uav.segments), scale,
                    axes(uav.gnss.sigma_m), axes(uav.gnss.bias_m),
                    std::to_string(uav.gnss.fixes) + " / " + std::to_string(uav.gnss.outliers),
                    uav.gnss.trusted ? "yes" : "no"});
  }
  return heading("UAVs") + tableHtml({"UAV", "photos", "posed", "unposed", "unjoined", "damaged",
                                      "segments", "metres per VO unit", "GNSS σ e/n/u [m]",
                                      "GNSS bias e/n/u [m]", "fixes / outliers", "GNSS trusted"},
                                     rows);
}

std::vector<std::string> cameraRow(const std::string& uav, const char* when, const CameraModel& c) {
  const auto sigma = [](double value) { return value > 0 ? fmt::format(" ± {:.2g}", value) : ""; };
  return {uav,
          when,
          fmt::format("{} × {}", c.width, c.height),
          fmt::format("{:.2f}{}", c.fx, sigma(c.focal_sigma)),
          fmt::format("{:.2f}", c.cx),
          fmt::format("{:.2f}", c.cy),
          fmt::format("{:.5f}{}", c.k1, sigma(c.k1_sigma)),
          fmt::format("{:.5f}{}", c.k2, sigma(c.k2_sigma)),
          fmt::format("{:.6f}", c.p1),
          fmt::format("{:.6f}", c.p2),
          fmt::format("{:.5f}", c.k3)};
}

std::string cameraTable(const RunRecord& run) {
  Rows rows;
  for (const UavRecord& uav : run.uavs) {
    rows.push_back(cameraRow(uav.name, "before", uav.camera_before));
    rows.push_back(cameraRow("", "after", uav.camera_after));
  }
  return heading("Cameras before and after") +
         tableHtml({"UAV", "", "size [px]", "focal length [px]", "cx [px]", "cy [px]", "k1", "k2",
                    "p1", "p2", "k3"},
                   rows);
}

/// Photos that have no pose, each with its reason.
std::string lostPhotos(const RunRecord& run) {
  Rows rows;
  for (const UavRecord& uav : run.uavs)
    for (const PhotoRecord& p : uav.photos)
      if (p.status != PhotoStatus::kPosed)
        rows.push_back({uav.name, p.name, name(p.status), p.reason});
  if (rows.empty()) return {};
  return heading("Photos without a pose") + tableHtml({"UAV", "photo", "status", "reason"}, rows);
}

}  // namespace

std::string tablesHtml(const RunRecord& run) {
  return uavTable(run) + cameraTable(run) +
         (run.ground_control ? groundControlHtml(*run.ground_control) : "") + lostPhotos(run);
}

}  // namespace cf
