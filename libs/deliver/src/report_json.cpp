// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cf/deliver/deliver.h"
#include "cf/formats/atomic_file.h"
#include "ground_control_report.h"
#include "out_path.h"
#include "summary.h"

namespace cf {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN or infinity: unknown is null.
Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json triple(const Eigen::Vector3d& v) { return {finite(v.x()), finite(v.y()), finite(v.z())}; }

Json uavJson(const UavRecord& uav) {
  Json out;
  out["photos"] = uav.photos.size();
  out["posed"] = countOf(uav, PhotoStatus::kPosed);
  out["unposed"] = countOf(uav, PhotoStatus::kUnposed);
  out["unjoined"] = countOf(uav, PhotoStatus::kUnjoined);
  out["damaged"] = countOf(uav, PhotoStatus::kDamaged);
  out["segments"] = uav.segments;
  const bool scaled = !uav.scale_history.empty();
  out["scale"] = scaled ? finite(uav.scale_history.back().scale) : Json(nullptr);
  out["scale_sigma"] = scaled ? finite(uav.scale_history.back().sigma) : Json(nullptr);
  out["gnss_sigma_m"] = triple(uav.gnss.sigma_m);
  out["gnss_bias_m"] = triple(uav.gnss.bias_m);
  out["gnss_trusted"] = uav.gnss.trusted;
  out["gnss_fixes"] = uav.gnss.fixes;
  out["gnss_outliers"] = uav.gnss.outliers;
  return out;
}

Json checkJson(const SelfCheck& check) {
  Json out;
  out["name"] = check.name;
  out["value"] = check.value ? finite(*check.value) : Json(nullptr);
  out["unit"] = check.unit;
  out["grade"] = name(check.grade);
  out["limits"] = {{"green", finite(check.green)},
                   {"amber", finite(check.amber)},
                   {"more_is_better", check.more_is_better}};
  out["finding"] = check.finding;
  out["advice"] = check.advice;
  return out;
}

std::string text(const Json& json) {
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

int countOf(const UavRecord& uav, PhotoStatus status) {
  return static_cast<int>(
      std::count_if(uav.photos.begin(), uav.photos.end(),
                    [status](const PhotoRecord& p) { return p.status == status; }));
}

PhotoTotals totalsOf(const RunRecord& run) {
  PhotoTotals totals;
  for (const auto& uav : run.uavs) {
    totals.total += static_cast<int>(uav.photos.size());
    totals.posed += countOf(uav, PhotoStatus::kPosed);
  }
  return totals;
}

Latency latencyOf(const std::vector<PhotoLatency>& latencies) {
  std::vector<double> seconds;
  for (const PhotoLatency& of_photo : latencies) seconds.push_back(of_photo.latency_s);
  if (seconds.empty()) return {};
  std::sort(seconds.begin(), seconds.end());
  const auto rank = [&](double share) {  // nearest rank
    const auto k = static_cast<std::size_t>(std::ceil(share * static_cast<double>(seconds.size())));
    return seconds[std::max<std::size_t>(k, 1) - 1];
  };
  return {rank(0.5), rank(0.95), seconds.back()};
}

void writeReportJson(const RunRecord& run, const std::filesystem::path& outdir) {
  Json report;
  report["version"] = run.version;
  report["wall_s"] = finite(run.wall_s);
  report["peak_rss_mb"] = finite(run.peak_rss_mb);
  const PhotoTotals totals = totalsOf(run);
  report["photos"] = {{"total", totals.total}, {"posed", totals.posed}};
  report["components"] = run.components;
  report["bytes_over_seam"] = run.bytes_over_seam;
  report["stages"] = Json::object();
  for (const auto& [stage, s] : run.stages)
    report["stages"][stage] = {{"wall_s", finite(s.wall_s)}, {"cpu_s", finite(s.cpu_s)}};
  const Latency latency = latencyOf(run.latencies);
  report["latency_s"] = {{"p50", latency.p50}, {"p95", latency.p95}, {"max", latency.max}};
  if (run.real_time)
    report["real_time"] = {{"most_behind_s", run.real_time->most_behind_s},
                           {"left_out_live", run.real_time->left_out_live}};
  report["uavs"] = Json::object();
  for (const auto& uav : run.uavs) report["uavs"][uav.name] = uavJson(uav);
  report["relative_poses"] = run.relative_poses.size();
  if (run.ground_control) report["ground_control"] = groundControlJson(*run.ground_control);
  report["self_check"] = Json::array();
  for (const SelfCheck& check : run.self_check) report["self_check"].push_back(checkJson(check));
  report["warnings"] = Json::array();
  for (const Warning& warning : allWarnings(run)) report["warnings"].push_back(warning.text);
  writeFileAtomically(outPath(outdir, "", "report.json"), text(report));
}

void writeWorldJson(const RunRecord& run, const std::filesystem::path& outdir) {
  const WorldRecord& w = run.world;
  Json world;
  world["origin"] = nullptr;
  if (!w.relative)
    world["origin"] = {{"lat", w.latitude_deg}, {"lon", w.longitude_deg}, {"h", w.height_m}};
  world["h_datum"] = name(w.h_datum);
  world["frame"] = w.relative ? "local" : "ENU";
  world["utm"] = w.relative ? Json(nullptr) : Json(w.utm);
  world["center"] = w.center;
  writeFileAtomically(outPath(outdir, "", "world.json"), text(world));
}

}  // namespace cf
