// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>

#include "cf/deliver/deliver.h"
#include "escape.h"
#include "report_parts.h"
#include "reprojection.h"
#include "summary.h"

namespace cf {
namespace {

std::string number(double value, const std::string& unit) {
  if (unit == "share") return fmt::format("{:.0f} %", 100 * value);
  const int digits = value < 0.1 ? 3 : value < 10 ? 2 : 1;
  return fmt::format("{:.{}f} {}", value, digits, unit);
}

std::string checkHtml(const SelfCheck& check) {
  std::string html = fmt::format(
      "<div class=\"check {0}\"><span class=\"grade\">{0}</span><b>{1}{2}</b><p>{3}.</p>",
      name(check.grade), markupEscaped(check.title),
      check.value ? ": " + markupEscaped(number(*check.value, check.unit)) : "",
      markupEscaped(check.finding));
  if (!check.advice.empty())
    html += "<p class=\"advice\">→ " + markupEscaped(check.advice) + ".</p>";
  if (check.value)
    html += fmt::format("<p class=\"limits\">green {0} {1}, amber {0} {2}</p>",
                        check.more_is_better ? "from" : "up to",
                        markupEscaped(number(check.green, check.unit)),
                        markupEscaped(number(check.amber, check.unit)));
  return html + "</div>\n";
}

/// The sentence that answers first.
std::string verdictHtml(const std::vector<SelfCheck>& checks) {
  Grade worst = Grade::kGreen;
  std::vector<std::string> doubtful;
  for (const SelfCheck& check : checks) {
    if (check.grade != Grade::kAmber && check.grade != Grade::kRed) continue;
    worst = std::max(worst, check.grade);
    doubtful.push_back(check.title);
  }
  std::string sentence = "Nothing doubtful: all that the run can test about itself is green.";
  if (!doubtful.empty())
    sentence = fmt::format("{} {}. What it means and what to do is told below.",
                           worst == Grade::kRed ? "Do not trust this map before you have looked at:"
                                                : "Usable; look at:",
                           fmt::join(doubtful, ", "));
  return fmt::format("<p class=\"verdict {}\">{}</p>\n", name(worst), markupEscaped(sentence));
}

std::string fact(const std::string& value, const std::string& what) {
  return "<div><b>" + markupEscaped(value) + "</b><span>" + markupEscaped(what) + "</span></div>\n";
}

std::string factsHtml(const RunRecord& run) {
  const PhotoTotals totals = totalsOf(run);
  std::string html = "<div class=\"facts\">\n";
  html += fact(std::to_string(run.uavs.size()), run.uavs.size() == 1 ? "UAV" : "UAVs");
  html += fact(fmt::format("{} / {}", totals.posed, totals.total), "photos placed");
  if (const double pixel_m = groundPixel(run); pixel_m > 0)
    html += fact(fmt::format("{:.1f} cm", 100 * pixel_m), "pixel of the photos on the ground");
  if (run.cloud.total() > 0)
    html += fact(fmt::format("{:.1f} million", 1e-6 * static_cast<double>(run.cloud.total())),
                 "points in the cloud");
  html += fact(fmt::format("{:.0f} s", run.wall_s),
               fmt::format("run, {:.2f} s a photo", run.wall_s / std::max(1, totals.total)));
  html += fact(fmt::format("{:.0f} MB", run.peak_rss_mb), "memory at most");
  return html + "</div>\n";
}

std::string placeHtml(const RunRecord& run) {
  if (run.world.relative)
    return "<p class=\"dim\">A relative map: place, heading and scale are arbitrary.</p>\n";
  const std::string datum = run.world.h_datum == HeightDatum::kEllipsoid ? "the ellipsoid"
                            : run.world.h_datum == HeightDatum::kMsl     ? "mean sea level"
                                                                         : "an unknown datum";
  return fmt::format(
      "<p class=\"dim\">Origin {:.7f}°, {:.7f}° (WGS84), {:.2f} m above {}; UTM zone {}; central "
      "UAV "
      "{}; ClusterFusion {}.</p>\n",
      run.world.latitude_deg, run.world.longitude_deg, run.world.height_m, datum,
      markupEscaped(run.world.utm), markupEscaped(run.world.center), markupEscaped(run.version));
}

}  // namespace

std::string summaryHtml(const RunRecord& run) {
  std::string html = "<h1>Map of the flight</h1>\n" + placeHtml(run);
  if (!run.self_check.empty()) {
    html += verdictHtml(run.self_check);
    html += factsHtml(run) + "<div class=\"checks\">\n";
    for (const SelfCheck& check : run.self_check) html += checkHtml(check);
    html += "</div>\n";
  } else {
    html += factsHtml(run);
  }
  const std::vector<Warning> warnings = allWarnings(run);
  if (!warnings.empty()) html += heading("Warnings");
  for (const Warning& warning : warnings) {
    html += "<div class=\"warning\">" + markupEscaped(warning.text);
    if (!warning.advice.empty()) html += "<p>→ " + markupEscaped(warning.advice) + "</p>";
    html += "</div>\n";
  }
  return html;
}

}  // namespace cf
