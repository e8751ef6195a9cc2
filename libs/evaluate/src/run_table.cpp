// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "cf/evaluate/run.h"
#include "figures.h"

namespace cf {
namespace {

/// A line: what it says, where the figure stands in the JSON, its unit and factor to it.
struct Line {
  const char* text;
  const char* pointer;
  const char* unit;
  double factor = 1;
};

constexpr Line kCluster[] = {
    {"camera centres, se3, RMSE", "/trajectory/se3/rmse_m", "m"},
    {"camera centres, sim3, RMSE", "/trajectory/sim3/rmse_m", "m"},
    {"camera centres, not aligned, RMSE", "/trajectory/none/rmse_m", "m"},
    {"rotation, sim3, RMS", "/trajectory/sim3/rotation_rmse_deg", "deg"},
    {"NEES of poses in the world, of 6", "/consistency/world/nees", ""},
    {"NEES of poses in the map, of 6", "/consistency/map/nees", ""},
    {"scale of the map, sim3", "/trajectory/sim3/scale", ""},
    {"scale of segments at the end, median", "/scale/error_end_pct/median", "%"},
    {"scale of segments at the end, worst", "/scale/error_end_pct/max", "%"},
    {"scale within 1 sigma (68 if honest)", "/scale/consistency/within_1_sigma", "%", 100},
    {"scale within 2 sigma (95 if honest)", "/scale/consistency/within_2_sigma", "%", 100},
    {"UAV to UAV, translation, RMS", "/uav_pairs/translation_rms_m", "m"},
    {"UAV to UAV, rotation, RMS", "/uav_pairs/rotation_rms_deg", "deg"},
    {"observed relative poses, rotation, RMS", "/relative_poses/rotation_deg/rms", "deg"},
    {"observed relative poses, direction, RMS", "/relative_poses/direction_deg/rms", "deg"},
    {"seam, horizontal, median", "/seam/all/horizontal_gsd/median", "ground pixels"},
    {"seam, horizontal, 95 %", "/seam/all/horizontal_gsd/p95", "ground pixels"},
    {"seam, vertical, median", "/seam/all/vertical_gsd/median", "ground pixels"},
    {"seam, vertical, 95 %", "/seam/all/vertical_gsd/p95", "ground pixels"},
    {"seam, vertical, 95 %", "/seam/all/vertical_m/p95", "m"},
    {"ground, horizontal, median", "/ground/all/horizontal_m/median", "m"},
    {"ground, vertical, median", "/ground/all/vertical_m/median", "m"},
    {"doming, span", "/doming/span_m", "m"},
    {"doming, RMS", "/doming/rms_m", "m"},
    {"depth, scaled, bias", "/depth/scaled/matched_pixels/bias", "matched pixels"},
    {"depth, scaled, NMAD", "/depth/scaled/matched_pixels/nmad", "matched pixels"},
    {"depth, scaled, 95 %", "/depth/scaled/matched_pixels/p95", "matched pixels"},
    {"depth, completeness", "/depth/completeness", "%", 100},
    {"cloud, size of a matched pixel", "/cloud/matched_pixel_m", "m"},
    {"cloud, height, bias", "/cloud/height/m/bias", "m"},
    {"cloud, height, NMAD", "/cloud/height/matched_pixels/nmad", "matched pixels"},
    {"cloud, height, NMAD without bend", "/cloud/height/without_bend_matched_pixels/nmad",
     "matched pixels"},
    {"cloud, height, 95 %", "/cloud/height/matched_pixels/p95", "matched pixels"},
    {"cloud, within 1 matched pixel", "/cloud/height/within_1_matched_pixel", "%", 100},
    {"cloud, completeness", "/cloud/completeness", "%", 100},
    {"cloud, coverage seen from above", "/cloud/coverage", "%", 100},
    {"cloud, flying points", "/cloud/flying/share", "%", 100},
    {"focal length, RMS error", "/camera/focal_rms_pct", "%"},
    {"relative GNSS bias, horizontal, RMS error", "/gnss/relative_bias_rms_m/horizontal", "m"},
    {"relative GNSS bias, vertical, RMS error", "/gnss/relative_bias_rms_m/vertical", "m"},
};

Json valueAt(const Json& json, const std::string& pointer) {
  const Json::json_pointer where(pointer);
  return json.contains(where) ? json.at(where) : Json(nullptr);
}

std::string cell(const Json& value, double factor = 1) {
  return value.is_number() ? fmt::format("{:.4g}", factor * value.get<double>()) : "-";
}

std::string scaleCell(const Json& figures) {
  if (!figures.is_object()) return "-";
  const Json& within = figures["within_limit"];
  return fmt::format("{} of {}{}", cell(figures["error_pct"]), cell(figures["limit_pct"]),
                     within.is_boolean() && !within.get<bool>() ? " !" : "");
}

/// Errors of scale beside their limits.
std::string scaleLines(const Json& json) {
  if (!json["scale"].is_object()) return "";
  std::string out = fmt::format("\n{:<16}{:>22}{:>22}{:>22}\n", "scale, segment",
                                "after 15 %, limit", "end %, limit", "UAV's map %, limit");
  for (const auto& [uav, segments] : json["scale"]["segments"].items())
    for (const auto& [segment, figures] : segments.items())
      out += fmt::format("{:<16}{:>22}{:>22}{:>22}\n", uav + "/" + segment,
                         scaleCell(figures["after_15"]), scaleCell(figures["end"]),
                         scaleCell(json["scale"]["map"][uav]));
  return out;
}

std::string uavLines(const Json& json) {
  std::string out =
      fmt::format("\n{:<16}{:>12}{:>12}{:>12}{:>14}{:>14}{:>16}\n", "UAV", "posed", "own se3 m",
                  "cluster m", "focal told %", "focal found %", "ground 95 % m");
  for (const auto& [name, photos] : json["photos"]["per_uav"].items()) {
    // A name may hold what a pointer takes for a separator.
    std::string key;
    for (const char c : name) key += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    const auto at = [&](const std::string& before, const std::string& after) {
      return cell(valueAt(json, before + "/per_uav/" + key + after));
    };
    out +=
        fmt::format("{:<16}{:>12}{:>12}{:>12}{:>14}{:>14}{:>16}\n", name,
                    fmt::format("{}/{}", photos["posed"].dump(), photos["total"].dump()),
                    at("/trajectory", "/own_se3/rmse_m"), at("/trajectory", "/cluster_se3/rmse_m"),
                    at("/camera", "/before/focal_error_pct"),
                    at("/camera", "/after/focal_error_pct"), at("/ground", "/vertical_m/p95"));
  }
  return out;
}

}  // namespace

std::string runTable(const std::string& text) {
  const Json json = Json::parse(text);
  std::string out = fmt::format("{:<44}{:>10} of {}\n", "photos with a pose",
                                json["photos"]["posed"].dump(), json["photos"]["total"].dump());
  for (const Line& line : kCluster)
    out += fmt::format("{:<44}{:>10} {}\n", line.text,
                       cell(valueAt(json, line.pointer), line.factor), line.unit);
  out += uavLines(json) + scaleLines(json);
  for (const auto& [name, reason] : json["missing"].items())
    out += fmt::format("\nno {}: {}", name, reason.get<std::string>());
  return out;
}

}  // namespace cf
