// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "cf/formats/reduced_raster.h"
#include "cf/geodesy/grid_frame.h"
#include "geographic.h"
#include "report_parts.h"
#include "svg_plot.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr int kMost_px = 1400;

std::vector<Eigen::Vector3d> placesOf(const RunRecord& run) {
  std::vector<Eigen::Vector3d> places;
  for (const UavRecord& uav : run.uavs)
    for (const PhotoPose& pose : uav.final_trajectory)
      places.emplace_back(pose.T_world_cam.translation());
  return places;
}

Eigen::Affine3d gridOf(const RunRecord& run, const std::vector<Eigen::Vector3d>& places) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : places) middle += p / static_cast<double>(places.size());
  const GridFrame grid =
      run.world.relative ? GridFrame() : GridFrame(frameOf(run.world), run.world.h_datum);
  return grid.T_grid_world(middle);
}

void place(const GeoTiffGrid& grid, MapFrame& frame) {
  frame.left_m = grid.left_m;
  frame.top_m = grid.top_m;
  frame.cell_m = grid.cell_m;
  frame.width = grid.width;
  frame.height = grid.height;
}

cv::Mat onWhite(const cv::Mat& bgra) {
  cv::Mat bgr, mask;
  cv::cvtColor(bgra, bgr, cv::COLOR_BGRA2BGR);
  cv::extractChannel(bgra, mask, 3);
  bgr.setTo(cv::Scalar::all(255), mask == 0);
  return bgr;
}

void placeAround(const std::vector<Eigen::Vector3d>& places, MapFrame& frame) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& p : places)
    box.extend(Eigen::Vector2d((frame.T_grid_world * p).head<2>()));
  const double margin = std::max(1.0, 0.15 * box.sizes().maxCoeff());
  frame.left_m = box.min().x() - margin;
  frame.top_m = box.max().y() + margin;
  frame.cell_m = (box.sizes().maxCoeff() + 2 * margin) / 1000;
  frame.width = static_cast<int>((box.sizes().x() + 2 * margin) / frame.cell_m);
  frame.height = static_cast<int>((box.sizes().y() + 2 * margin) / frame.cell_m);
}

/// A round length of about a fifth of the picture, and north.
std::string scaleBar(const MapFrame& frame) {
  const double wanted_m = frame.width * frame.cell_m / 5;
  const double power = std::pow(10, std::floor(std::log10(wanted_m)));
  const double length_m = (wanted_m >= 5 * power ? 5 : wanted_m >= 2 * power ? 2 : 1) * power;
  const double unit = frame.width / 100.0, x = 2.5 * unit, y = frame.height - 3 * unit;
  const std::string text =
      length_m >= 1 ? fmt::format("{:.0f} m", length_m) : fmt::format("{:.0f} cm", 100 * length_m);
  const double bar = length_m / frame.cell_m;
  return fmt::format(
      "<g fill=\"#111\"><rect x=\"{0:.1f}\" y=\"{1:.1f}\" width=\"{2:.1f}\" height=\"{3:.1f}\" "
      "fill=\"#fff\" opacity=\".8\"/><rect x=\"{4:.1f}\" y=\"{5:.1f}\" width=\"{6:.1f}\" "
      "height=\"{7:.1f}\"/><text x=\"{4:.1f}\" y=\"{8:.1f}\" font-size=\"{9:.1f}\">{10}</text>"
      "<text x=\"{11:.1f}\" y=\"{8:.1f}\" font-size=\"{9:.1f}\" text-anchor=\"end\">N "
      "↑</text></g>\n",
      x - unit, y - 3.2 * unit, std::max(bar, 12 * unit) + 2 * unit, 5 * unit, x, y + 0.2 * unit,
      bar, 0.7 * unit, y - 0.7 * unit, 2 * unit, text, x + std::max(bar, 12 * unit));
}

}  // namespace

Eigen::Vector2d MapFrame::pixelOf(const Eigen::Vector3d& p_world) const {
  const Eigen::Vector3d p = T_grid_world * p_world;
  return {(p.x() - left_m) / cell_m, (top_m - p.y()) / cell_m};
}

Eigen::Vector3d MapFrame::worldOf(double column, double row, double height_m) const {
  return T_grid_world.inverse() *
         Eigen::Vector3d(left_m + (column + 0.5) * cell_m, top_m - (row + 0.5) * cell_m, height_m);
}

MapFrame mapFrameOf(const RunRecord& run, const fs::path& outdir) {
  MapFrame frame;
  const std::vector<Eigen::Vector3d> places = placesOf(run);
  if (places.empty()) return frame;
  frame.T_grid_world = gridOf(run, places);
  if (fs::exists(outdir / "dsm.tif")) {
    const ReducedRaster dsm = readReduced(outdir / "dsm.tif", kMost_px);
    frame.heights = dsm.values;
    place(dsm.grid, frame);
  }
  if (fs::exists(outdir / "orthophoto.tif")) {
    const ReducedRaster picture = readReduced(outdir / "orthophoto.tif", kMost_px);
    frame.orthophoto = onWhite(picture.values);
    place(picture.grid, frame);
    if (!frame.heights.empty())  // both cover the same ground
      cv::resize(frame.heights, frame.heights, picture.values.size(), 0, 0, cv::INTER_NEAREST);
  }
  if (frame.width == 0) placeAround(places, frame);
  return frame;
}

std::string mapHtml(const MapFrame& frame, const cv::Mat& picture, const std::string& svg) {
  std::string html = "<div class=\"map\">";
  if (!picture.empty()) html += "<img alt=\"map\" src=\"" + jpegUri(picture, 82) + "\">";
  return html +
         fmt::format("<svg viewBox=\"0 0 {} {}\"{}>\n", frame.width, frame.height,
                     picture.empty() ? " style=\"position:static\"" : "") +
         svg + scaleBar(frame) + "</svg></div>\n";
}

std::string trajectoriesSvg(const RunRecord& run, const MapFrame& frame, bool links) {
  const double unit = frame.width / 100.0;
  std::map<FrameId, Eigen::Vector2d> places;
  std::string svg;
  for (std::size_t u = 0; u < run.uavs.size(); ++u) {
    const UavRecord& uav = run.uavs[u];
    std::string path;
    int segment = -1;
    Eigen::Vector2d last(0, 0), before(0, 0);
    for (const PhotoPose& pose : uav.final_trajectory) {
      const Eigen::Vector2d p = frame.pixelOf(pose.T_world_cam.translation());
      places[{static_cast<std::uint16_t>(u), pose.photo}] = p;
      const int of_photo = uav.photos[pose.photo].segment;
      path += fmt::format("{}{:.1f},{:.1f}", of_photo == segment ? "L" : "M", p.x(), p.y());
      segment = of_photo;
      before = last;
      last = p;
    }
    if (path.empty()) continue;
    const std::string colour = uavColour(u);
    for (const auto& [stroke, width] :
         {std::pair<std::string, double>("#fff", 0.75), {colour, 0.4}})
      svg += fmt::format(
          "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:.2f}\" "
          "stroke-linejoin=\"round\"/>\n",
          path, stroke, width * unit);
    const double angle = std::atan2(last.y() - before.y(), last.x() - before.x()) * 180 / M_PI;
    svg += fmt::format(
        "<path d=\"M1.6,0L-1,1.1V-1.1Z\" fill=\"{}\" stroke=\"#fff\" stroke-width=\".25\" "
        "transform=\"translate({:.1f} {:.1f}) rotate({:.0f}) scale({:.2f})\"/>\n",
        colour, last.x(), last.y(), angle, unit);
  }
  std::string red;
  for (const RelativePose& r : run.relative_poses) {
    const auto a = places.find(r.a), b = places.find(r.b);
    if (!links || a == places.end() || b == places.end()) continue;
    red += fmt::format("M{:.1f},{:.1f}L{:.1f},{:.1f}", a->second.x(), a->second.y(), b->second.x(),
                       b->second.y());
  }
  if (!red.empty())
    svg += fmt::format("<path d=\"{}\" stroke=\"#e00000\" stroke-width=\"{:.2f}\"/>\n", red,
                       0.2 * unit);
  return svg;
}

cv::Vec3b heightColour(double share) {
  static const std::array<cv::Vec3d, 5> kStops = {
      cv::Vec3d(149, 54, 49), {209, 173, 116}, {164, 221, 171}, {139, 224, 254}, {39, 48, 215}};
  const double x = std::clamp(share, 0.0, 1.0) * 4;
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(x), 3);
  const cv::Vec3d mixed =
      kStops.at(i) + (x - static_cast<double>(i)) * (kStops.at(i + 1) - kStops.at(i));
  return {cv::saturate_cast<uchar>(mixed[0]), cv::saturate_cast<uchar>(mixed[1]),
          cv::saturate_cast<uchar>(mixed[2])};
}

}  // namespace cf
