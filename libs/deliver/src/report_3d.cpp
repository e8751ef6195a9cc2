// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "escape.h"
#include "report_parts.h"
#include "robust.h"
#include "svg_plot.h"

namespace cf {

extern const char* const kReportViewer;

namespace {

using Json = nlohmann::ordered_json;

/// Of all points in the view: middle half and bounds.
struct Extent {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double reach_m = 1;            ///< from the middle, horizontally, of most of them
  double low_m = 0, high_m = 1;  ///< heights of most of them
};

Extent extentOf(const CloudSketch& cloud) {
  std::vector<double> axis[3];
  for (const CloudSketch::Point& p : cloud.points())
    for (int a = 0; a < 3; ++a) axis[a].push_back(p.position_m[a]);
  Extent e;
  for (int a = 0; a < 3; ++a) {
    const auto [low, high] = std::minmax_element(axis[a].begin(), axis[a].end());
    e.low[a] = *low;
    e.high[a] = *high;
    e.middle[a] = (quantileOf(axis[a], 0.02) + quantileOf(axis[a], 0.98)) / 2;
  }
  e.reach_m = std::max(1e-3, std::max(quantileOf(axis[0], 0.98) - quantileOf(axis[0], 0.02),
                                      quantileOf(axis[1], 0.98) - quantileOf(axis[1], 0.02)) /
                                 2);
  e.low_m = quantileOf(axis[2], 0.01);
  e.high_m = std::max(e.low_m + 1e-3, quantileOf(axis[2], 0.99));
  return e;
}

double rounded(double value) { return std::round(value * 100) / 100; }

void append(const Eigen::Vector3d& p, Json& numbers) {
  for (Eigen::Index a = 0; a < 3; ++a) numbers.push_back(rounded(p[a]));
}

void addPoints(const CloudSketch& cloud, const Extent& extent, Json& scene) {
  const double step = std::max(1e-6, (extent.high - extent.low).maxCoeff() / 65535);
  std::vector<unsigned char> positions, colours;
  for (const CloudSketch::Point& p : cloud.points()) {
    for (int a = 0; a < 3; ++a) {
      const auto value =
          static_cast<unsigned>(std::lround((p.position_m[a] - extent.low[a]) / step));
      positions.push_back(static_cast<unsigned char>(value & 255U));
      positions.push_back(static_cast<unsigned char>(value >> 8 & 255U));
    }
    colours.insert(colours.end(), p.rgb.begin(), p.rgb.end());
  }
  scene["points"] = cloud.points().size();
  scene["low"] = {extent.low.x(), extent.low.y(), extent.low.z()};
  scene["step"] = step;
  scene["positions"] = base64(positions.data(), positions.size());
  scene["colours"] = base64(colours.data(), colours.size());
  // About the distance of neighbours, if they lie on one surface.
  scene["size"] = 5.0 * extent.reach_m / std::sqrt(static_cast<double>(cloud.points().size()));
}

/// A path for each segment of the flight.
Json pathsOf(const UavRecord& uav, const Eigen::Vector3d& offset) {
  std::map<int, Json> paths;
  for (const PhotoPose& pose : uav.final_trajectory)
    append(pose.T_world_cam.translation() - offset, paths[uav.photos[pose.photo].segment]);
  Json all = Json::array();
  for (auto& [segment, path] : paths) all.push_back(std::move(path));
  return all;
}

Json linksOf(const RunRecord& run, const Eigen::Vector3d& offset) {
  std::map<FrameId, Eigen::Vector3d> places;
  for (std::size_t u = 0; u < run.uavs.size(); ++u)
    for (const PhotoPose& pose : run.uavs[u].final_trajectory)
      places[{static_cast<std::uint16_t>(u), pose.photo}] = pose.T_world_cam.translation() - offset;
  Json links = Json::array();
  for (const RelativePose& r : run.relative_poses) {
    const auto a = places.find(r.a), b = places.find(r.b);
    if (a == places.end() || b == places.end()) continue;
    append(a->second, links);
    append(b->second, links);
  }
  return links;
}

constexpr const char* kControls = R"(<div class="controls">
<button id="view-aslant" type="button">aslant</button><button id="view-above" type="button">from above</button>
<label><input type="checkbox" id="view-height"> colour by height</label>
<label><input type="checkbox" id="view-tracks" checked> trajectories</label>
<label><input type="checkbox" id="view-links" checked> relative poses</label>
<label>points <input type="range" id="view-size" min="-2" max="2" step="0.25" value="0"></label>
</div>
)";

}  // namespace

std::string view3dHtml(const RunRecord& run) {
  if (run.cloud.points().empty()) return {};
  const Extent extent = extentOf(run.cloud);
  Json scene;
  addPoints(run.cloud, extent, scene);
  scene["middle"] = {extent.middle.x(), extent.middle.y(), extent.middle.z()};
  scene["reach"] = extent.reach_m;
  scene["heights"] = {extent.low_m, extent.high_m};
  scene["uavs"] = Json::array();
  std::string legend;
  for (std::size_t u = 0; u < run.uavs.size(); ++u) {
    const std::string colour = uavColour(u);
    scene["uavs"].push_back(
        {{"colour", colour}, {"paths", pathsOf(run.uavs[u], run.cloud.offset())}});
    legend += fmt::format("<span><i style=\"background:{}\"></i>{}</span>", colour,
                          markupEscaped(run.uavs[u].name));
  }
  double top = extent.high_m;
  for (const UavRecord& uav : run.uavs)
    for (const PhotoPose& pose : uav.final_trajectory)
      top = std::max(top, pose.T_world_cam.translation().z() - run.cloud.offset().z());
  scene["top"] = top;
  scene["links"] = linksOf(run, run.cloud.offset());
  // Numbers and base64 alone: nothing in it could end the script element.
  return heading("The map in 3D") + kControls + "<div id=\"view\"></div>\n<div class=\"legend\">" +
         legend + "<span><i style=\"background:#f00\"></i>relative poses</span></div>\n" +
         fmt::format(
             "<p class=\"dim\">{} of {} points. Turn: drag or one finger; move: right button "
             "or two fingers; zoom: wheel or pinch.</p>\n",
             run.cloud.points().size(), run.cloud.total()) +
         "<script type=\"application/json\" id=\"scene\">" + scene.dump() + "</script>\n<script>" +
         kReportViewer + "</script>\n";
}

}  // namespace cf
