// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scale_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "escape.h"

namespace cf {
namespace {

constexpr double kWidth = 1200, kHeight = 280, kLeft = 60, kBottom = 250, kTop = 20;
constexpr double kMostPercent = 20;
const char* const kStrokes[] = {"#444444", "#c79a00", "#0089b3", "#c23bc2", "#4a9d00", "#d97000"};

// Each row of the history in percent off the last value of its segment.
std::vector<double> offPercent(const UavRecord& uav) {
  std::map<int, double> last;
  for (const auto& row : uav.scale_history) last[row.segment] = row.scale;
  std::vector<double> percent;
  for (const auto& row : uav.scale_history) {
    const double end = last[row.segment];
    percent.push_back(end > 0 ? 100 * (row.scale / end - 1) : 0);
  }
  return percent;
}

}  // namespace

std::string scalePlot(const RunRecord& run) {
  double most = 1;
  TimeNs first = std::numeric_limits<TimeNs>::max(), last = std::numeric_limits<TimeNs>::min();
  for (const auto& uav : run.uavs) {
    for (const double percent : offPercent(uav)) most = std::max(most, std::abs(percent));
    for (const auto& row : uav.scale_history) {
      first = std::min(first, row.t);
      last = std::max(last, row.t);
    }
  }
  if (first >= last) return {};
  most = std::min(most, kMostPercent);
  const auto x = [&](TimeNs t) {
    return kLeft + (kWidth - kLeft) * seconds(t - first) / seconds(last - first);
  };
  const auto y = [&](double percent) {
    const double share = std::clamp(percent / most, -1.0, 1.0);
    return (kTop + kBottom) / 2 - share * (kBottom - kTop) / 2;
  };
  std::string svg = fmt::format(
      "<h2>Scale over time, off its last value [%]</h2>\n<svg viewBox=\"0 0 {} {}\" "
      "style=\"width:100%\" font-size=\"13\">\n",
      kWidth, kHeight);
  for (const double tick : {-most, 0.0, most})
    svg += fmt::format(
        "<line x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#ddd\"/>"
        "<text x=\"0\" y=\"{3:.1f}\">{4:+.1f}</text>\n",
        kLeft, kWidth, y(tick), y(tick) + 4, tick);
  std::size_t index = 0;
  for (const auto& uav : run.uavs) {
    const char* stroke = kStrokes[index % std::size(kStrokes)];
    std::string path;
    int segment = -1;
    const std::vector<double> percent = offPercent(uav);
    for (std::size_t i = 0; i < percent.size(); ++i) {
      const ScaleRow& row = uav.scale_history[i];
      path += fmt::format("{}{:.1f},{:.1f} ", row.segment == segment ? "L" : "M", x(row.t),
                          y(percent[i]));
      segment = row.segment;
    }
    svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>", path,
                       stroke);
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{}\" fill=\"{}\">{}</text>\n",
                       kLeft + 150.0 * static_cast<double>(index), kHeight - 6, stroke,
                       markupEscaped(uav.name));
    ++index;
  }
  return svg + "</svg>\n";
}

}  // namespace cf
