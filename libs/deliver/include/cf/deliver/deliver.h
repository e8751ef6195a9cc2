// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cf/deliver/deliver_options.h"
#include "cf/deliver/run_record.h"

namespace cf {

/// Each writes one product of the output contract (DESIGN section 5) into OUTDIR, which is made if
/// need be; every file appears whole or not at all. RunError names a file that cannot be written.

void writeReportJson(const RunRecord& run, const std::filesystem::path& outdir);
/// One self-contained page; the pictures are those of OUTDIR/snapshots, if any.
void writeReportHtml(const RunRecord& run, const std::filesystem::path& outdir);
/// A relative map has "origin": null, "frame": "local", "utm": null.
void writeWorldJson(const RunRecord& run, const std::filesystem::path& outdir);
void writeImagesCsv(const RunRecord& run, const std::filesystem::path& outdir);
/// <uav>.tum, <uav>.online.tum and, unless the map is relative, <uav>.ecef.csv.
void writeTrajectories(const RunRecord& run, const std::filesystem::path& outdir);
/// <uav>.covariance.csv of the final poses whose covariance is known.
void writeCovariances(const RunRecord& run, const std::filesystem::path& outdir);
/// odometry/<uav>.tum: T_local_cam as odometry gave it, VO units; images/<uav>.csv tells each
/// photo's segment, and every segment has a local frame and a scale of its own.
void writeOdometry(const RunRecord& run, const std::filesystem::path& outdir);
/// trajectories/all.geojson (RFC 7946: a line for each UAV, a point for each photo). Nothing is
/// written for a relative map; the same holds for all.kml.
void writeGeojson(const RunRecord& run, const std::filesystem::path& outdir);
void writeKml(const RunRecord& run, const std::filesystem::path& outdir);
/// cameras/<uav>.ini: [camera] after the run, which cf-import --camera takes, and [before].
void writeCameras(const RunRecord& run, const std::filesystem::path& outdir);
void writeScale(const RunRecord& run, const std::filesystem::path& outdir);
void writeGraphs(const RunRecord& run, const std::filesystem::path& outdir);
/// T_a_b: translation [m] and quaternion, σ of translation [m] and rotation vector [rad], axes of
/// a.
void writeRelativePoses(const RunRecord& run, const std::filesystem::path& outdir);
void writeSparsePly(const RunRecord& run, const std::filesystem::path& outdir);

/// The run's warnings and those about its products: what was left out and what heights count from.
std::vector<Warning> allWarnings(const RunRecord& run);

/// All of them that the options do not leave out, the report last. Call it after the snapshots have
/// been rendered, or write report.html again then.
void deliver(const RunRecord& run, const std::filesystem::path& outdir,
             const DeliverOptions& options = {});

}  // namespace cf
