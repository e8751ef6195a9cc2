// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cf/deliver/deliver.h"
#include "cf/formats/atomic_file.h"
#include "escape.h"
#include "ground_control_report.h"
#include "out_path.h"
#include "scale_plot.h"
#include "summary.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>ClusterFusion report</title>
<style>
body{font:15px/1.5 system-ui,sans-serif;max-width:1280px;margin:2em auto;padding:0 1em;color:#222}
h1{font-size:1.6em;margin-bottom:.2em}h2{font-size:1.2em;margin-top:2em}
table{border-collapse:collapse;margin:.5em 0}
th,td{padding:.3em .8em;border-bottom:1px solid #ddd;text-align:right}
th:first-child,td:first-child{text-align:left}th{background:#f4f4f4}
figure{margin:1em 0}figcaption{color:#666}img{width:100%;border-radius:4px}
.warn{background:#fff4d6;border-left:4px solid #e0a800;padding:.4em 1em;margin:.4em 0}
.pictures{display:grid;grid-template-columns:1fr 1fr;gap:1em}
.pictures figure:first-child{grid-column:1/3}
</style></head><body>
)";

std::string row(const char* cell, const std::vector<std::string>& cells) {
  std::string out = "<tr>";
  for (const auto& c : cells) out += fmt::format("<{0}>{1}</{0}>", cell, markupEscaped(c));
  return out + "</tr>\n";
}

std::string plusMinus(const Eigen::Vector3d& v) {
  return fmt::format("{:.2f} / {:.2f} / {:.2f}", v.x(), v.y(), v.z());
}

std::string uavTable(const RunRecord& run) {
  std::string out = "<h2>UAVs</h2>\n<table>\n" +
                    row("th", {"UAV", "photos", "posed", "unposed", "unjoined", "damaged",
                               "segments", "metres per VO unit", "focal length [px]",
                               "GNSS σ e/n/u [m]", "GNSS bias e/n/u [m]", "GNSS trusted"});
  for (const auto& uav : run.uavs) {
    const std::string scale = uav.scale_history.empty()
                                  ? "–"
                                  : fmt::format("{:.5g} ± {:.2g}", uav.scale_history.back().scale,
                                                uav.scale_history.back().sigma);
    const auto count = [&](PhotoStatus s) { return std::to_string(countOf(uav, s)); };
    out += row("td", {uav.name + (uav.name == run.world.center ? " (central)" : ""),
                      std::to_string(uav.photos.size()), count(PhotoStatus::kPosed),
                      count(PhotoStatus::kUnposed), count(PhotoStatus::kUnjoined),
                      count(PhotoStatus::kDamaged), std::to_string(uav.segments), scale,
                      fmt::format("{:.1f} → {:.1f} ± {:.1f}", uav.camera_before.fx,
                                  uav.camera_after.fx, uav.camera_after.focal_sigma),
                      plusMinus(uav.gnss.sigma_m), plusMinus(uav.gnss.bias_m),
                      uav.gnss.trusted ? "yes" : "no"});
  }
  return out + "</table>\n";
}

std::string stageTable(const RunRecord& run) {
  const double photos = std::max(1, totalsOf(run).total);
  std::string out =
      "<h2>Time</h2>\n<table>\n" +
      row("th", {"stage", "wall [s]", "CPU [s]", "wall per photo [s]", "CPU per photo [s]"});
  for (const auto& [stage, s] : run.stages)
    out += row("td",
               {stage, fmt::format("{:.2f}", s.wall_s), fmt::format("{:.2f}", s.cpu_s),
                fmt::format("{:.3f}", s.wall_s / photos), fmt::format("{:.3f}", s.cpu_s / photos)});
  out += row("td", {"whole run", fmt::format("{:.2f}", run.wall_s), "",
                    fmt::format("{:.3f}", run.wall_s / photos), ""});
  const Latency latency = latencyOf(run.latencies);
  return out + fmt::format(
                   "</table>\n<p>From a photo's arrival to its last product: median {:.2f} "
                   "s, 95 % within {:.2f} s, longest {:.2f} s.</p>\n",
                   latency.p50, latency.p95, latency.max);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string relativePosesText(const RunRecord& run) {
  std::vector<double> before, after;
  for (const auto& r : run.relative_poses) {
    before.push_back(r.residual_before);
    after.push_back(r.residual_after);
  }
  std::string out = fmt::format("<h2>Relative poses</h2>\n<p>{} observed", before.size());
  if (!before.empty())
    out += fmt::format("; median residual {:.2f} m before and {:.2f} m after alignment",
                       median(before), median(after));
  return out + ".</p>\n";
}

// Photos that have no pose, each with its reason.
std::string lostPhotos(const RunRecord& run) {
  std::string rows;
  for (const auto& uav : run.uavs)
    for (const auto& p : uav.photos)
      if (p.status != PhotoStatus::kPosed)
        rows += row("td", {uav.name, p.name, name(p.status), p.reason});
  if (rows.empty()) return {};
  return "<h2>Photos without a pose</h2>\n<table>\n" +
         row("th", {"UAV", "photo", "status", "reason"}) + rows + "</table>\n";
}

// The snapshots, top view first, as JPEGs within the page.
std::string pictures(const fs::path& folder) {
  constexpr int kWidth_px = 1280;
  if (!fs::is_directory(folder)) return {};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    const bool a_top = a.stem() == "top", b_top = b.stem() == "top";
    return a_top != b_top ? a_top : a < b;
  });
  std::string out;
  for (const auto& file : files) {
    cv::Mat picture = cv::imread(file.string());
    if (picture.empty()) continue;
    if (picture.cols > kWidth_px)
      cv::resize(picture, picture, {kWidth_px, picture.rows * kWidth_px / picture.cols}, 0, 0,
                 cv::INTER_AREA);
    std::vector<unsigned char> jpeg;
    cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 88});
    const std::string caption = markupEscaped(file.stem().string());
    out += fmt::format(
        "<figure><img alt=\"{0}\" src=\"data:image/jpeg;base64,{1}\"><figcaption>{0}</figcaption>"
        "</figure>\n",
        caption, base64(jpeg.data(), jpeg.size()));
  }
  return out.empty() ? out : "<div class=\"pictures\">\n" + out + "</div>\n";
}

}  // namespace

void writeReportHtml(const RunRecord& run, const fs::path& outdir) {
  const PhotoTotals totals = totalsOf(run);
  std::string html = kHead;
  html += fmt::format(
      "<h1>ClusterFusion report</h1>\n<p>{} UAVs, {} of {} photos posed, {} connected part{}; "
      "{:.1f} s, peak memory {:.0f} MB, {:.1f} MB over the seam; version {}.</p>\n",
      run.uavs.size(), totals.posed, totals.total, run.components, run.components == 1 ? "" : "s",
      run.wall_s, run.peak_rss_mb, static_cast<double>(run.bytes_over_seam) / 1e6,
      markupEscaped(run.version));
  if (!run.world.relative)
    html += fmt::format("<p>Origin {:.8f}°, {:.8f}°, {:.2f} m ({}); UTM zone {}.</p>\n",
                        run.world.latitude_deg, run.world.longitude_deg, run.world.height_m,
                        name(run.world.h_datum), markupEscaped(run.world.utm));
  for (const auto& warning : allWarnings(run))
    html += "<div class=\"warn\">" + markupEscaped(warning.text) + "</div>\n";
  html += pictures(outdir / "snapshots") + uavTable(run) + scalePlot(run) + relativePosesText(run) +
          (run.ground_control ? groundControlHtml(*run.ground_control) : "") + stageTable(run) +
          lostPhotos(run) + "</body></html>\n";
  writeFileAtomically(outPath(outdir, "", "report.html"), html);
}

}  // namespace cf
