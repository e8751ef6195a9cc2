// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ground_control_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "escape.h"

namespace cf {
namespace {

using Json = nlohmann::ordered_json;

Json triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Root mean squares of differences.
struct Rms {
  double all = 0, horizontal = 0, vertical = 0;

  explicit Rms(const std::vector<Eigen::Vector3d>& differences) {
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& d : differences)
      squares += d.cwiseAbs2() / static_cast<double>(differences.size());
    all = std::sqrt(squares.sum());
    horizontal = std::sqrt(squares.x() + squares.y());
    vertical = std::sqrt(squares.z());
  }
  Json json() const {
    return {{"rms", all}, {"horizontal_rms", horizontal}, {"vertical_rms", vertical}};
  }
};

std::vector<Eigen::Vector3d> differencesOf(const GroundControlRecord& record) {
  std::vector<Eigen::Vector3d> differences;
  for (const GroundPointRecord& p : record.points) differences.push_back(p.difference_m);
  return differences;
}

std::vector<Eigen::Vector3d> leftOutOf(const GroundControlRecord& record) {
  std::vector<Eigen::Vector3d> differences;
  for (const GroundPointRecord& p : record.points)
    if (p.left_out_m) differences.push_back(*p.left_out_m);
  return differences;
}

Json pointJson(const GroundPointRecord& p) {
  Json json = {{"name", p.name},
               {"marks", p.marks},
               {"uavs", p.uavs},
               {"rms_px", p.rms_px},
               {"max_px", p.max_px},
               {"surveyed_m", triple(p.surveyed_m)},
               {"difference_m", triple(p.difference_m)}};
  if (p.left_out_m) json["left_out_difference_m"] = triple(*p.left_out_m);
  return json;
}

std::string cells(const Eigen::Vector3d& v) {
  return fmt::format("<td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td>", v.x(), v.y(), v.z());
}

}  // namespace

Json groundControlJson(const GroundControlRecord& record) {
  Json json = {{"file", record.file},
               {"use", record.moved ? "control" : "check"},
               {"points", record.points.size() + record.missing.size()},
               {"triangulated", record.points.size()},
               {"difference_m", nullptr}};
  const auto differences = differencesOf(record), left_out = leftOutOf(record);
  if (!differences.empty()) {
    json["difference_m"] = Rms(differences).json();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& d : differences) mean += d;
    json["difference_m"]["mean"] = triple(mean / static_cast<double>(differences.size()));
  }
  if (!left_out.empty()) json["left_out_difference_m"] = Rms(left_out).json();
  if (record.moved)
    json["moved"] = {{"shift_m", triple(record.moved->shift_m)},
                     {"rotation_deg", record.moved->rotation_deg},
                     {"scale", record.moved->scale}};
  json["missing"] = record.missing;
  json["per_point"] = Json::array();
  for (const GroundPointRecord& p : record.points) json["per_point"].push_back(pointJson(p));
  return json;
}

std::string groundControlHtml(const GroundControlRecord& record) {
  const auto differences = differencesOf(record), left_out = leftOutOf(record);
  std::string html = fmt::format("<h2>Ground {} points</h2>\n<p>{} of {} triangulated",
                                 record.moved ? "control" : "check", differences.size(),
                                 differences.size() + record.missing.size());
  if (!differences.empty())
    html += fmt::format("; RMS {:.3f} m horizontally, {:.3f} m vertically",
                        Rms(differences).horizontal, Rms(differences).vertical);
  if (!left_out.empty())
    html += fmt::format("; each left out in turn: {:.3f} m, {:.3f} m", Rms(left_out).horizontal,
                        Rms(left_out).vertical);
  html += ".</p>\n";
  if (record.moved)
    html += fmt::format(
        "<p>They have moved the map by {:.2f} / {:.2f} / {:.2f} m (e/n/u) at their middle, turned "
        "it by {:.3f}° and scaled it by {:.6f}.</p>\n",
        record.moved->shift_m.x(), record.moved->shift_m.y(), record.moved->shift_m.z(),
        record.moved->rotation_deg, record.moved->scale);
  html +=
      "<table>\n<tr><th>point</th><th>marks</th><th>UAVs</th><th>RMS [px]</th><th>east [m]</th>"
      "<th>north [m]</th><th>up [m]</th></tr>\n";
  for (const GroundPointRecord& p : record.points)
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.2f}</td>{}</tr>\n",
                        markupEscaped(p.name), p.marks, p.uavs, p.rms_px, cells(p.difference_m));
  return html + "</table>\n";
}

}  // namespace cf
