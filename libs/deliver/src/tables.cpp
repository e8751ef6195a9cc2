// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "cf/deliver/deliver.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/csv.h"
#include "cf/formats/ply.h"
#include "out_path.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

std::string number(double value) { return fmt::format("{:.9g}", value); }

std::string cameraSection(const char* section, const CameraModel& c) {
  std::string text = fmt::format("[{}]\nwidth = {}\nheight = {}\n", section, c.width, c.height);
  const std::pair<const char*, double> values[] = {{"fx", c.fx},
                                                   {"fy", c.fy},
                                                   {"cx", c.cx},
                                                   {"cy", c.cy},
                                                   {"k1", c.k1},
                                                   {"k2", c.k2},
                                                   {"p1", c.p1},
                                                   {"p2", c.p2},
                                                   {"k3", c.k3},
                                                   {"focal_sigma", c.focal_sigma},
                                                   {"k1_sigma", c.k1_sigma},
                                                   {"k2_sigma", c.k2_sigma}};
  for (const auto& [key, value] : values) text += fmt::format("{} = {:.12g}\n", key, value);
  return text;
}

}  // namespace

void writeImagesCsv(const RunRecord& run, const fs::path& outdir) {
  for (const auto& uav : run.uavs) {
    CsvWriter csv(outPath(outdir, "images", uav.name + ".csv"),
                  {"image", "t", "status", "segment", "keypoints", "matches", "inliers", "reason"});
    for (const auto& p : uav.photos)
      csv.row({p.name, timeText(p.time), name(p.status),
               p.segment < 0 ? "" : std::to_string(p.segment), std::to_string(p.keypoints),
               std::to_string(p.matches), std::to_string(p.inliers), p.reason});
    csv.close();
  }
}

void writeScale(const RunRecord& run, const fs::path& outdir) {
  for (const auto& uav : run.uavs) {
    CsvWriter csv(outPath(outdir, "scale", uav.name + ".csv"), {"t", "segment", "scale", "sigma"});
    for (const auto& row : uav.scale_history)
      csv.row({timeText(row.t), std::to_string(row.segment), number(row.scale), number(row.sigma)});
    csv.close();
  }
}

void writeGraphs(const RunRecord& run, const fs::path& outdir) {
  for (const auto& uav : run.uavs)
    writeFileAtomically(outPath(outdir, "graphs", uav.name + ".graph"), uav.pose_graph);
}

void writeRelativePoses(const RunRecord& run, const fs::path& outdir) {
  CsvWriter csv(outPath(outdir, "", "relative_poses.csv"), {"uav_a",
                                                            "uav_b",
                                                            "image_a",
                                                            "image_b",
                                                            "inliers",
                                                            "tx",
                                                            "ty",
                                                            "tz",
                                                            "qx",
                                                            "qy",
                                                            "qz",
                                                            "qw",
                                                            "sigma_tx",
                                                            "sigma_ty",
                                                            "sigma_tz",
                                                            "sigma_rx",
                                                            "sigma_ry",
                                                            "sigma_rz",
                                                            "residual_before",
                                                            "residual_after"});
  for (const auto& r : run.relative_poses) {
    const Eigen::Vector3d t = r.T_a_b.translation();
    Eigen::Quaterniond q(r.T_a_b.linear());
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    CsvRow row = {uavOf(run, r.a).name, uavOf(run, r.b).name, photoOf(run, r.a).name,
                  photoOf(run, r.b).name, std::to_string(r.inliers)};
    for (const double v : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
      row.push_back(number(v));
    for (int i = 0; i < 6; ++i) row.push_back(number(r.sigma[i]));
    row.push_back(number(r.residual_before));
    row.push_back(number(r.residual_after));
    csv.row(row);
  }
  csv.close();
}

void writeCameras(const RunRecord& run, const fs::path& outdir) {
  for (const auto& uav : run.uavs) {
    const std::string text =
        "# Calibration [px] of the original photo; OpenCV's plumb bob; sigma 0 = held fixed.\n"
        "# [camera] is the result: cf-import --camera takes this file.\n" +
        cameraSection("camera", uav.camera_after) + "\n" +
        cameraSection("before", uav.camera_before);
    writeFileAtomically(outPath(outdir, "cameras", uav.name + ".ini"), text);
  }
}

void writeSparsePly(const RunRecord& run, const fs::path& outdir) {
  PlyWriter ply(outPath(outdir, "cloud", "sparse.ply"));
  for (const auto& p : run.sparse_points)
    ply.add(p.position_m.cast<float>(), {p.bgr[2], p.bgr[1], p.bgr[0]});
  ply.close();
}

}  // namespace cf
