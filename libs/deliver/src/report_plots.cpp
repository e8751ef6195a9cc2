// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "escape.h"
#include "gnss_residuals.h"
#include "report_parts.h"
#include "reprojection.h"
#include "robust.h"
#include "summary.h"
#include "svg_plot.h"

namespace cf {
namespace {

constexpr double kMinute_s = 60;

TimeNs startOf(const RunRecord& run) {
  TimeNs start = std::numeric_limits<TimeNs>::max();
  for (const UavRecord& uav : run.uavs)
    for (const PhotoRecord& photo : uav.photos) start = std::min(start, photo.time);
  return start;
}

double minutes(TimeNs time, TimeNs start) { return seconds(time - start) / kMinute_s; }

/// Scale of one UAV in percent of the last of its segment, with its σ.
std::string scaleFigure(const UavRecord& uav, const std::string& colour, TimeNs start) {
  constexpr double kMostPercent = 30;
  std::map<int, std::vector<const ScaleRow*>> segments;
  for (const ScaleRow& row : uav.scale_history) segments[row.segment].push_back(&row);
  SvgPlot plot("minutes since the first photo", "scale, off its last value [%]", 480);
  double most = 1;
  for (const auto& [segment, rows] : segments) {
    const double end = rows.back()->scale;
    if (!(end > 0) || rows.size() < 2) continue;
    std::vector<double> x, low, high;
    std::vector<PlotPoint> line;
    for (const ScaleRow* row : rows) {
      const double percent = 100 * (row->scale / end - 1), sigma = 100 * row->sigma / end;
      x.push_back(minutes(row->t, start));
      low.push_back(percent - sigma);
      high.push_back(percent + sigma);
      line.emplace_back(x.back(), percent);
      most = std::max(most, std::max(std::abs(low.back()), std::abs(high.back())));
    }
    plot.band(x, low, high, colour);
    plot.line(std::move(line), colour, "");
  }
  if (segments.empty()) return {};
  most = std::min(most, kMostPercent);
  plot.limitY(-most, most);
  const ScaleRow& last = uav.scale_history.back();
  return figure(plot.text(), fmt::format("{}: scale over time, band ± 1 σ; at the end {:.5g} ± "
                                         "{:.2g} m per unit of odometry.",
                                         uav.name, last.scale, last.sigma));
}

std::string scaleHtml(const RunRecord& run) {
  std::string html;
  for (std::size_t u = 0; u < run.uavs.size(); ++u)
    html += scaleFigure(run.uavs[u], uavColour(u), startOf(run));
  return html.empty() ? html
                      : heading("Scale over time") + "<div class=\"two\">\n" + html + "</div>\n";
}

std::string gnssHtml(const RunRecord& run) {
  constexpr std::array<const char*, 3> kAxes = {"east", "north", "up"};
  const TimeNs start = startOf(run);
  std::array<SvgPlot, 3> plots = {
      SvgPlot("minutes since the first photo", "east: fix − map [m]", 420),
      SvgPlot("minutes since the first photo", "north: fix − map [m]", 420),
      SvgPlot("minutes since the first photo", "up: fix − map [m]", 420)};
  std::vector<std::vector<std::string>> rows;
  for (std::size_t u = 0; u < run.uavs.size(); ++u) {
    const UavRecord& uav = run.uavs[u];
    const auto residuals = gnssResiduals(uav);
    if (residuals.empty()) continue;
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      std::vector<PlotPoint> dots;
      for (const GnssResidual& r : residuals)
        dots.emplace_back(minutes(uav.photos[r.photo].time, start),
                          r.residual_m[static_cast<Eigen::Index>(axis)]);
      plots.at(axis).dots(std::move(dots), uavColour(u), uav.name);
    }
    const Eigen::Vector3d offset = gnssOffset(residuals);
    rows.push_back({uav.name, std::to_string(residuals.size()),
                    fmt::format("{:.2f} / {:.2f} / {:.2f}", offset.x(), offset.y(), offset.z()),
                    fmt::format("{:.2f} / {:.2f} / {:.2f}", uav.gnss.sigma_m.x(),
                                uav.gnss.sigma_m.y(), uav.gnss.sigma_m.z()),
                    fmt::format("{:.1f}", gnssNoiseRatio(residuals))});
  }
  if (rows.empty()) return {};
  std::string html = heading("GNSS against the map") + "<div class=\"three\">\n";
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    plots.at(axis).includeY(0);
    html += figure(plots.at(axis).text(), "");
  }
  return html + "</div>\n" +
         tableHtml({"UAV", "fixes", "median offset e/n/u [m]", "σ e/n/u [m]", "σ over tagged σ"},
                   rows) +
         "<p class=\"dim\">What a receiver is off as a whole is its bias; the map is laid so that "
         "the biases of all UAVs are least.</p>\n";
}

/// What all photos of a UAV have in common, drawn on its picture.
std::string lensFigure(const UavRecord& uav, const Reprojection& r, const std::string& colour) {
  const CameraModel& camera = uav.camera_after;
  double longest = 0.05;
  for (const auto& zone : r.zones) longest = std::max(longest, zone.mean_px.norm());
  const double unit = camera.width / 100.0, scale = 9 * unit / longest;
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\"><rect width=\"{0}\" height=\"{1}\" fill=\"#f6f7f9\" "
      "stroke=\"#dfe3e8\" stroke-width=\"{2:.1f}\"/>\n",
      camera.width, camera.height, 0.3 * unit);
  for (const auto& zone : r.zones) {
    if (zone.count == 0) continue;
    const Eigen::Vector2d end = zone.middle_px + scale * zone.mean_px;
    svg += fmt::format(
        "<circle cx=\"{0:.0f}\" cy=\"{1:.0f}\" r=\"{2:.1f}\" fill=\"{3}\"/><path "
        "d=\"M{0:.0f},{1:.0f}L{4:.0f},{5:.0f}\" stroke=\"{3}\" stroke-width=\"{6:.1f}\"/>\n",
        zone.middle_px.x(), zone.middle_px.y(), 0.7 * unit, colour, end.x(), end.y(), 0.5 * unit);
  }
  return figure(svg + "</svg>",
                fmt::format("{}: mean error by part of the picture, longest arrow {:.2f} px; "
                            "systematic {:.2f} px (RMS).",
                            uav.name, longest, r.systematic_px));
}

std::string reprojectionHtml(const RunRecord& run) {
  constexpr int kBins = 40;
  const auto all = reprojectionsOf(run);
  double most = 0;
  for (const Reprojection& r : all) most = std::max(most, r.p95_px);
  if (!(most > 0)) return {};
  most *= 1.3;
  SvgPlot histogram("distance between a point's projection and where it was seen [px of the photo]",
                    "share of sights [%]");
  SvgPlot by_photo("photo number", "RMS of a photo [px]");
  std::string lenses;
  std::vector<std::vector<std::string>> rows;
  for (std::size_t u = 0; u < all.size(); ++u) {
    const Reprojection& r = all[u];
    if (r.errors_px.empty()) continue;
    std::array<int, kBins> counts{};
    for (const float e : r.errors_px)
      ++counts.at(static_cast<std::size_t>(std::min<double>(kBins - 1, kBins * e / most)));
    std::vector<PlotPoint> line, dots;
    for (std::size_t i = 0; i + 1 < kBins; ++i)
      line.emplace_back((static_cast<double>(i) + 0.5) * most / kBins,
                        100.0 * counts.at(i) / static_cast<double>(r.errors_px.size()));
    for (const auto& [photo, rms] : r.rms_px) dots.emplace_back(photo, rms);
    const std::string colour = uavColour(u), &uav = run.uavs[u].name;
    histogram.line(std::move(line), colour, uav);
    by_photo.dots(std::move(dots), colour, uav);
    lenses += lensFigure(run.uavs[u], r, colour);
    rows.push_back({uav, std::to_string(r.errors_px.size()), fmt::format("{:.2f}", r.median_px),
                    fmt::format("{:.2f}", r.p95_px), fmt::format("{:.2f}", r.systematic_px)});
  }
  histogram.includeY(0);
  by_photo.includeY(0);
  return heading("Reprojection errors") + "<div class=\"two\">\n" +
         figure(histogram.text(), "All sights of all points of the sparse map.") +
         figure(by_photo.text(), "Photos that stand out are blurred or badly placed.") +
         "</div>\n" +
         tableHtml({"UAV", "sights", "median [px]", "95 % within [px]", "systematic [px]"}, rows) +
         "<div class=\"three\">\n" + lenses + "</div>\n";
}

std::string relativeHtml(const RunRecord& run) {
  if (run.relative_poses.empty()) return {};
  std::vector<PlotPoint> before, after;
  std::vector<double> all_before, all_after;
  for (const RelativePose& r : run.relative_poses) {
    const auto n = static_cast<double>(before.size() + 1);
    before.emplace_back(n, r.residual_before);
    after.emplace_back(n, r.residual_after);
    all_before.push_back(r.residual_before);
    all_after.push_back(r.residual_after);
  }
  SvgPlot first("relative pose", "before alignment [m]"), second("relative pose", "after [m]");
  const double width = 0.8;
  first.columns(std::move(before), width, "#9aa0a6", "");
  second.columns(std::move(after), width, "#0081a7", "");
  return heading("Relative poses between UAVs") + "<div class=\"two\">\n" +
         figure(first.text(),
                fmt::format("Of each pair's observed translation against where GNSS alone puts the "
                            "two photos: median {:.2f} m.",
                            medianOf(all_before))) +
         figure(second.text(), fmt::format("Against the final map: median {:.3f} m; {} pairs.",
                                           medianOf(all_after), all_after.size())) +
         "</div>\n";
}

std::string stageTable(const RunRecord& run) {
  const double photos = std::max(1, totalsOf(run).total);
  std::vector<std::pair<std::string, StageSeconds>> stages(run.stages.begin(), run.stages.end());
  std::sort(stages.begin(), stages.end(),
            [](const auto& a, const auto& b) { return a.second.cpu_s > b.second.cpu_s; });
  const double most = stages.empty() ? 1 : std::max(1e-9, stages.front().second.cpu_s);
  std::string html =
      "<div class=\"scroll\"><table>\n<tr><th>stage</th><th>CPU [s]</th><th>wall [s]</th><th>CPU a "
      "photo [s]</th><th></th></tr>\n";
  for (const auto& [stage, s] : stages)
    html += fmt::format(
        "<tr><td>{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.3f}</td><td class=\"wide\"><span "
        "class=\"bar\" style=\"width:{:.1f}%\"></span></td></tr>\n",
        markupEscaped(stage), s.cpu_s, s.wall_s, s.cpu_s / photos, 100 * s.cpu_s / most);
  return html + fmt::format(
                    "<tr><td>whole run</td><td></td><td>{:.2f}</td><td>{:.3f} wall</td><td></td>"
                    "</tr>\n</table></div>\n",
                    run.wall_s, run.wall_s / photos);
}

}  // namespace

std::string accuracyPlotsHtml(const RunRecord& run) {
  return gnssHtml(run) + scaleHtml(run) + relativeHtml(run) + reprojectionHtml(run);
}

std::string costHtml(const RunRecord& run) {
  std::string html = heading("Time and memory") + stageTable(run) + "<div class=\"two\">\n";
  SvgPlot latency("seconds since the run began", "latency of a photo [s]");
  std::map<std::uint16_t, std::vector<PlotPoint>> dots;
  for (const PhotoLatency& l : run.latencies)
    dots[l.photo.uav].emplace_back(l.taken_s, l.latency_s);
  for (auto& [uav, points] : dots)
    latency.dots(std::move(points), uavColour(uav), run.uavs[uav].name);
  latency.includeY(0);
  const Latency summary = latencyOf(run.latencies);
  html +=
      figure(latency.text(),
             fmt::format("From a photo's taking up to something of it in the map: median {:.2f} "
                         "s, 95 % within {:.2f} s, longest {:.2f} s.",
                         summary.p50, summary.p95, summary.max));
  SvgPlot memory("seconds since the run began", "memory [MB]");
  std::vector<PlotPoint> line;
  for (const MemorySample& m : run.memory) line.emplace_back(m.time_s, m.rss_mb);
  memory.line(std::move(line), "#0081a7", "");
  memory.includeY(0);
  html += figure(memory.text(),
                 fmt::format("Memory in use; at most {:.0f} MB. {:.1f} MB crossed the "
                             "seam to the central node.",
                             run.peak_rss_mb, 1e-6 * static_cast<double>(run.bytes_over_seam)));
  return html + "</div>\n";
}

}  // namespace cf
