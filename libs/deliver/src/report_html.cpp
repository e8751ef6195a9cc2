// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cf/deliver/deliver.h"
#include "cf/formats/atomic_file.h"
#include "escape.h"
#include "out_path.h"
#include "report_parts.h"

namespace cf {

extern const char* const kReportStyle;

namespace {

namespace fs = std::filesystem;

/// A snapshot within the page, at most so wide; empty where there is none.
std::string pictureHtml(const fs::path& file, int width_px, const std::string& caption) {
  cv::Mat picture = fs::exists(file) ? cv::imread(file.string()) : cv::Mat();
  if (picture.empty()) return {};
  if (picture.cols > width_px)
    cv::resize(picture, picture, {width_px, picture.rows * width_px / picture.cols}, 0, 0,
               cv::INTER_AREA);
  return figure("<img alt=\"" + markupEscaped(caption) + "\" src=\"" + jpegUri(picture) + "\">",
                caption);
}

/// All snapshots but the title's.
std::string galleryHtml(const fs::path& folder, const fs::path& title) {
  if (!fs::is_directory(folder)) return {};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".png" && entry.path() != title) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::string html;
  for (const fs::path& file : files) html += pictureHtml(file, 900, file.stem().string());
  return html.empty() ? html : heading("Snapshots") + "<div class=\"two\">\n" + html + "</div>\n";
}

}  // namespace

void writeReportHtml(const RunRecord& run, const fs::path& outdir) {
  const fs::path title = outdir / "snapshots" / "iso.png";
  const std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>ClusterFusion report</title>\n<style>\n" +
      std::string(kReportStyle) + "</style></head><body>\n" + summaryHtml(run) +
      pictureHtml(title, 1240, "The map, with the UAVs' paths; red: relative poses between UAVs.") +
      mapsHtml(run, outdir) + view3dHtml(run) + accuracyPlotsHtml(run) + tablesHtml(run) +
      costHtml(run) + galleryHtml(outdir / "snapshots", title) + "</body></html>\n";
  writeFileAtomically(outPath(outdir, "", "report.html"), html);
}

}  // namespace cf
