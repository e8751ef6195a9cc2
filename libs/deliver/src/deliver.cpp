// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/deliver.h"

#include "cf/base/log.h"
#include "cf/deliver/hand_over.h"

namespace cf {

const char* name(PhotoStatus status) {
  switch (status) {
    case PhotoStatus::kPosed:
      return "posed";
    case PhotoStatus::kUnposed:
      return "unposed";
    case PhotoStatus::kUnjoined:
      return "unjoined";
    case PhotoStatus::kDamaged:
      return "damaged";
  }
  return "unposed";
}

std::vector<Warning> allWarnings(const RunRecord& run) {
  std::vector<Warning> warnings = run.warnings;
  if (run.world.relative) {
    warnings.emplace_back(
        "no GNSS position at all: the map is relative (arbitrary origin and heading); "
        "all.geojson, all.kml, *.ecef.csv, shots.geojson and map.kml are left out, cloud.las and "
        "the rasters have no "
        "reference system",
        "give the photos positions (cf-import --geo geo.txt), or the map its place by surveyed "
        "points ([gcp] use = control)");
  } else if (run.world.h_datum != HeightDatum::kEllipsoid) {
    warnings.emplace_back(run.world.h_datum == HeightDatum::kMsl
                              ? "heights count from mean sea level; *.ecef.csv takes them as "
                                "ellipsoidal"
                              : "what the heights count from is unknown; *.ecef.csv takes them as "
                                "ellipsoidal",
                          "do not use the ECEF files for heights; everything else has heights as "
                          "the receivers gave them");
  }
  return warnings;
}

void handOver(const RunRecord& run, const std::filesystem::path& outdir) {
  writeColmapModel(run, outdir);
  writeShotsGeojson(run, outdir);
  writeMapKml(run, outdir);
}

void deliver(const RunRecord& run, const std::filesystem::path& outdir,
             const DeliverOptions& options) {
  writeWorldJson(run, outdir);
  writeImagesCsv(run, outdir);
  writeTrajectories(run, outdir);
  writeCovariances(run, outdir);
  writeOdometry(run, outdir);
  writeGeojson(run, outdir);
  writeKml(run, outdir);
  writeCameras(run, outdir);
  writeScale(run, outdir);
  writeGraphs(run, outdir);
  writeRelativePoses(run, outdir);
  writeSparsePly(run, outdir);
  if (options.handover) handOver(run, outdir);
  if (run.world.relative) logWarning(allWarnings(run).back().text);
  writeReportJson(run, outdir);
  if (options.html) writeReportHtml(run, outdir);
}

}  // namespace cf
