// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "escape.h"
#include "map_frame.h"
#include "report_parts.h"
#include "reprojection.h"
#include "robust.h"
#include "seam_cells.h"
#include "svg_plot.h"

namespace cf {
namespace {

std::string legendEntry(const std::string& colour, const std::string& text) {
  return fmt::format("<span><i style=\"background:{}\"></i>{}</span>", colour, markupEscaped(text));
}

std::string uavLegend(const RunRecord& run) {
  std::string html = "<div class=\"legend\">";
  for (std::size_t u = 0; u < run.uavs.size(); ++u)
    html += legendEntry(uavColour(u), run.uavs[u].name);
  return html + legendEntry("#e00000", "relative poses between UAVs") + "</div>\n";
}

std::string css(const cv::Vec3b& bgr) {
  return fmt::format("#{:02x}{:02x}{:02x}", bgr[2], bgr[1], bgr[0]);
}

// Height, coloured and lit from the north-west.

struct HeightRange {
  double low = 0, high = 1;
};

HeightRange rangeOf(const cv::Mat& heights) {
  std::vector<double> values;
  for (int row = 0; row < heights.rows; row += 2)
    for (int column = 0; column < heights.cols; column += 2)
      if (const float z = heights.at<float>(row, column); std::isfinite(z)) values.push_back(z);
  const double low = quantileOf(values, 0.01), high = quantileOf(values, 0.99);
  return {low, std::max(high, low + 0.01)};
}

cv::Mat hillshade(const cv::Mat& heights, const HeightRange& range, double cell_m) {
  cv::Mat picture(heights.size(), CV_8UC3, cv::Scalar::all(255));
  const Eigen::Vector3d light = Eigen::Vector3d(-1, 1, 1.6).normalized();
  for (int row = 1; row + 1 < heights.rows; ++row)
    for (int column = 1; column + 1 < heights.cols; ++column) {
      const float z = heights.at<float>(row, column);
      if (!std::isfinite(z)) continue;
      const double east = heights.at<float>(row, column + 1) - heights.at<float>(row, column - 1);
      const double north = heights.at<float>(row - 1, column) - heights.at<float>(row + 1, column);
      double shade = 0.78;
      if (std::isfinite(east) && std::isfinite(north))
        shade = std::max(0.0, Eigen::Vector3d(-east, -north, 2 * cell_m).normalized().dot(light));
      const cv::Vec3b colour = heightColour((z - range.low) / (range.high - range.low));
      for (int c = 0; c < 3; ++c)
        picture.at<cv::Vec3b>(row, column)[c] =
            cv::saturate_cast<uchar>((0.30 + 0.85 * shade) * colour[c]);
    }
  return picture;
}

std::string heightBar(const HeightRange& range) {
  std::string stops;
  for (int i = 0; i <= 8; ++i)
    stops +=
        fmt::format("<stop offset=\"{}\" stop-color=\"{}\"/>", i / 8.0, css(heightColour(i / 8.0)));
  const auto ticks = ticksOf(range.low, range.high, 6);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 640 34\"><defs><linearGradient id=\"heights\">{}</linearGradient></defs>"
      "<rect x=\"20\" y=\"2\" width=\"600\" height=\"12\" fill=\"url(#heights)\"/>",
      stops);
  for (const double tick : ticks)
    svg +=
        fmt::format("<text x=\"{:.1f}\" y=\"30\" text-anchor=\"middle\">{} m</text>",
                    20 + 600 * (tick - range.low) / (range.high - range.low), tickText(tick, step));
  return svg + "</svg>\n";
}

// How many photos see each place.

constexpr int kOverlapCells = 180;

struct OverlapClass {
  int from;
  cv::Vec3b bgr;
  const char* text;
};
const std::array<OverlapClass, 6> kOverlap = {{{0, {255, 255, 255}, "none"},
                                               {1, {60, 60, 200}, "1: no height"},
                                               {2, {60, 150, 245}, "2"},
                                               {3, {120, 220, 250}, "3–4"},
                                               {5, {140, 210, 150}, "5–8"},
                                               {9, {110, 150, 60}, "9 and more"}}};

cv::Mat overlapPicture(const RunRecord& run, const MapFrame& frame) {
  const double step = std::max(1.0, std::max(frame.width, frame.height) / double{kOverlapCells});
  const cv::Size cells(std::max(1, static_cast<int>(frame.width / step)),
                       std::max(1, static_cast<int>(frame.height / step)));
  std::vector<double> ground;  // where the surface is not known
  for (const SparsePoint& p : run.sparse_points) ground.push_back(p.position_m.z());
  const double plane = medianOf(std::move(ground));
  cv::Mat counts = cv::Mat::zeros(cells, CV_32SC1);
  struct View {
    Eigen::Isometry3d T_cam_world;
    const CameraModel* camera;
  };
  std::vector<View> views;
  for (const UavRecord& uav : run.uavs)
    for (const PhotoPose& pose : uav.final_trajectory)
      views.push_back({pose.T_world_cam.inverse(), &uav.camera_after});
  for (int row = 0; row < cells.height; ++row)
    for (int column = 0; column < cells.width; ++column) {
      const double x = (column + 0.5) * step, y = (row + 0.5) * step;
      Eigen::Vector3d p = frame.worldOf(x, y, 0);
      p.z() = plane;
      if (!frame.heights.empty()) {
        const float z = frame.heights.at<float>(std::min(static_cast<int>(y), frame.height - 1),
                                                std::min(static_cast<int>(x), frame.width - 1));
        if (std::isfinite(z)) p = frame.worldOf(x, y, z);
      }
      for (const View& view : views) {
        const Eigen::Vector3d q = view.T_cam_world * p;
        // Outside twice the picture the lens model need not hold.
        if (q.z() <= 0 || std::abs(q.x() / q.z()) * view.camera->fx > view.camera->width ||
            std::abs(q.y() / q.z()) * view.camera->fy > view.camera->height)
          continue;
        if (view.camera->contains(view.camera->project(q))) ++counts.at<int>(row, column);
      }
    }
  cv::Mat picture(cells, CV_8UC3);
  for (int row = 0; row < cells.height; ++row)
    for (int column = 0; column < cells.width; ++column)
      for (const OverlapClass& c : kOverlap)
        if (counts.at<int>(row, column) >= c.from) picture.at<cv::Vec3b>(row, column) = c.bgr;
  cv::resize(picture, picture, {cells.width * 4, cells.height * 4}, 0, 0, cv::INTER_NEAREST);
  return picture;
}

std::string overlapHtml(const RunRecord& run, const MapFrame& frame) {
  std::string legend = "<div class=\"legend\">";
  for (const OverlapClass& c : kOverlap) legend += legendEntry(css(c.bgr), c.text);
  return figure(mapHtml(frame, overlapPicture(run, frame), trajectoriesSvg(run, frame, false)) +
                    legend + "</div>\n",
                "Overlap: how many photos see each place (hidden places not considered). Heights "
                "need two, and are good from three to five on.");
}

// Where UAVs disagree.

cv::Vec3b seamColour(double pixels) {
  return pixels <= 1   ? cv::Vec3b(110, 170, 60)
         : pixels <= 2 ? cv::Vec3b(140, 215, 170)
         : pixels <= 4 ? cv::Vec3b(110, 215, 250)
         : pixels <= 6 ? cv::Vec3b(60, 150, 245)
                       : cv::Vec3b(50, 50, 200);
}

std::string seamHtml(const RunRecord& run, const MapFrame& frame) {
  const auto seam = seamOf(run.seam_points);
  const double pixel_m = groundPixel(run);
  if (!seam || !(pixel_m > 0)) return {};
  cv::Mat pale;
  if (!frame.orthophoto.empty()) {
    cv::resize(frame.orthophoto, pale, {}, 0.5, 0.5, cv::INTER_AREA);
    pale = 0.35 * pale + cv::Scalar::all(165);
  }
  std::vector<SeamCell> cells = seam->cells;  // the worst pair of a place on top
  std::stable_sort(cells.begin(), cells.end(), [](const SeamCell& a, const SeamCell& b) {
    return a.difference_m.norm() < b.difference_m.norm();
  });
  std::string svg;
  const double side = 0.94 * seam->cell_m / frame.cell_m;
  for (const SeamCell& cell : cells) {
    const Eigen::Vector2d p = frame.pixelOf({cell.middle_m.x(), cell.middle_m.y(), 0});
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" "
        "opacity=\".85\"><title>{} and {}: east {:.3f}, north {:.3f}, up {:.3f} m ± {:.3f} m, {} "
        "points</title></rect>\n",
        p.x() - side / 2, p.y() - side / 2, side, side,
        css(seamColour(cell.difference_m.norm() / pixel_m)),
        markupEscaped(run.uavs[cell.uav_a].name), markupEscaped(run.uavs[cell.uav_b].name),
        cell.difference_m.x(), cell.difference_m.y(), cell.difference_m.z(), cell.sigma_m,
        cell.points);
  }
  std::string legend = "<div class=\"legend\">";
  const std::array<std::pair<double, const char*>, 5> kLegend = {
      {{1, "≤ 1"}, {2, "≤ 2"}, {4, "≤ 4"}, {6, "≤ 6"}, {9, "> 6 pixels on the ground"}}};
  for (const auto& [pixels, text] : kLegend) legend += legendEntry(css(seamColour(pixels)), text);
  return figure(
      mapHtml(frame, pale, svg) + legend + "</div>\n",
      fmt::format("Seam: how far apart two UAVs see the same ground, each by itself ({} matched "
                  "points; a pixel is {:.3f} m; where more than two meet, the worst pair).",
                  seam->points, pixel_m));
}

}  // namespace

std::string mapsHtml(const RunRecord& run, const std::filesystem::path& outdir) {
  const MapFrame frame = mapFrameOf(run, outdir);
  if (frame.width == 0) return {};
  std::string html =
      heading("Map") +
      figure(mapHtml(frame, frame.orthophoto, trajectoriesSvg(run, frame, true)) + uavLegend(run),
             frame.orthophoto.empty() ? "Trajectories; north is up."
                                      : "Trajectories over the orthophoto; north is up, the "
                                        "triangle is the end of the flight.") +
      "<div class=\"two\">\n";
  if (!frame.heights.empty()) {
    const HeightRange range = rangeOf(frame.heights);
    html +=
        figure(mapHtml(frame, hillshade(frame.heights, range, frame.cell_m), "") + heightBar(range),
               "Surface model (dsm.tif), coloured by height and lit from the north-west; white: "
               "no data.");
  }
  return html + overlapHtml(run, frame) + seamHtml(run, frame) + "</div>\n";
}

}  // namespace cf
