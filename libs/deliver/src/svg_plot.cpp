// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "escape.h"

namespace cf {
namespace {

constexpr double kHeight = 260, kLeft = 62, kRight = 12, kTop = 26, kBottom = 42;
constexpr std::array<const char*, 8> kColours = {"#3b4252", "#c98a00", "#0081a7", "#b5179e",
                                                 "#3a8a2e", "#d1495b", "#6d597a", "#7a5c2e"};

}  // namespace

std::string uavColour(std::size_t n) { return kColours.at(n % kColours.size()); }

std::vector<double> ticksOf(double low, double high, int wanted) {
  const double raw = std::max(high - low, 1e-12) / wanted,
               power = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= raw * 0.999) {
      step = factor * power;
      break;
    }
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
    ticks.push_back(k * step);
  return ticks;
}

std::string tickText(double value, double step) {
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  return fmt::format("{:.{}f}", std::abs(value) < 1e-9 * step ? 0.0 : value, digits);
}

SvgPlot::SvgPlot(std::string x_label, std::string y_label, double width)
    : x_label_(std::move(x_label)), y_label_(std::move(y_label)), width_(width) {}

void SvgPlot::Axis::include(double value) {
  if (fixed) return;
  low = std::min(low, value);
  high = std::max(high, value);
}

void SvgPlot::line(std::vector<PlotPoint> points, const std::string& colour,
                   const std::string& legend) {
  points.erase(std::remove_if(points.begin(), points.end(),
                              [](const PlotPoint& p) {
                                return !std::isfinite(p.first) || !std::isfinite(p.second);
                              }),
               points.end());
  for (const auto& [px, py] : points) {
    x_.include(px);
    y_.include(py);
  }
  shapes_.push_back({Shape::Kind::kLine, std::move(points), colour, legend, 0});
}

void SvgPlot::dots(std::vector<PlotPoint> points, const std::string& colour,
                   const std::string& legend) {
  line(std::move(points), colour, legend);
  shapes_.back().kind = Shape::Kind::kDots;
}

void SvgPlot::band(const std::vector<double>& x, const std::vector<double>& low,
                   const std::vector<double>& high, const std::string& colour) {
  std::vector<PlotPoint> outline;
  for (std::size_t i = 0; i < x.size(); ++i) outline.emplace_back(x[i], high[i]);
  for (std::size_t i = x.size(); i-- > 0;) outline.emplace_back(x[i], low[i]);
  line(std::move(outline), colour, "");
  shapes_.back().kind = Shape::Kind::kBand;
}

void SvgPlot::columns(std::vector<PlotPoint> points, double width, const std::string& colour,
                      const std::string& legend) {
  y_.include(0);
  if (!points.empty()) {
    x_.include(points.front().first - width / 2);
    x_.include(points.back().first + width / 2);
  }
  line(std::move(points), colour, legend);
  shapes_.back().kind = Shape::Kind::kColumns;
  shapes_.back().width = width;
}

void SvgPlot::level(double y, const std::string& label) {
  y_.include(y);
  levels_.emplace_back(y, label);
}

void SvgPlot::includeY(double y) { y_.include(y); }

void SvgPlot::limitY(double low, double high) { y_ = {low, high, true}; }

double SvgPlot::x(double value) const {
  const double span = std::max(x_.high - x_.low, 1e-12);
  return kLeft + (width_ - kLeft - kRight) * (value - x_.low) / span;
}

double SvgPlot::y(double value) const {
  const double span = std::max(y_.high - y_.low, 1e-12);
  const double share = std::clamp((value - y_.low) / span, 0.0, 1.0);
  return kHeight - kBottom - (kHeight - kTop - kBottom) * share;
}

std::string SvgPlot::shapeText(const Shape& shape) const {
  std::string path;
  switch (shape.kind) {
    case Shape::Kind::kLine:
    case Shape::Kind::kBand:
      for (const auto& [px, py] : shape.points)
        path += fmt::format("{}{:.1f},{:.1f}", path.empty() ? "M" : "L", x(px), y(py));
      if (shape.kind == Shape::Kind::kBand)
        return fmt::format("<path d=\"{}Z\" fill=\"{}\" opacity=\".16\"/>\n", path, shape.colour);
      return fmt::format(
          "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\" "
          "stroke-linejoin=\"round\"/>\n",
          path, shape.colour);
    case Shape::Kind::kDots:
      for (const auto& [px, py] : shape.points)
        path += fmt::format("M{:.1f},{:.1f}h0", x(px), y(py));
      return fmt::format(
          "<path d=\"{}\" stroke=\"{}\" stroke-width=\"4\" stroke-linecap=\"round\" "
          "opacity=\".75\"/>\n",
          path, shape.colour);
    case Shape::Kind::kColumns:
      for (const auto& [px, py] : shape.points)
        path += fmt::format("M{:.1f},{:.1f}V{:.1f}H{:.1f}V{:.1f}Z", x(px - shape.width / 2), y(0),
                            y(py), x(px + shape.width / 2), y(0));
      return fmt::format("<path d=\"{}\" fill=\"{}\"/>\n", path, shape.colour);
  }
  return {};
}

std::string SvgPlot::axesText() const {
  std::string svg;
  const auto horizontal = ticksOf(y_.low, y_.high, 5),
             vertical = ticksOf(x_.low, x_.high, static_cast<int>(width_ / 80));
  const auto stepOf = [](const std::vector<double>& t) { return t.size() > 1 ? t[1] - t[0] : 1.0; };
  for (const double tick : horizontal)
    svg += fmt::format(
        "<path d=\"M{0},{1:.1f}H{2}\" stroke=\"#e3e5e8\"/><text x=\"{3}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5}</text>\n",
        kLeft, y(tick), width_ - kRight, kLeft - 6, y(tick) + 4,
        tickText(tick, stepOf(horizontal)));
  for (const double tick : vertical)
    svg += fmt::format(
        "<path d=\"M{0:.1f},{1}v4\" stroke=\"#9aa0a6\"/><text x=\"{0:.1f}\" y=\"{2}\" "
        "text-anchor=\"middle\">{3}</text>\n",
        x(tick), kHeight - kBottom, kHeight - kBottom + 17, tickText(tick, stepOf(vertical)));
  svg += fmt::format("<path d=\"M{},{}H{}\" stroke=\"#9aa0a6\"/>\n", kLeft, kHeight - kBottom,
                     width_ - kRight);
  svg += fmt::format(
      "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text><text x=\"0\" y=\"12\">{}</text>\n",
      (kLeft + width_ - kRight) / 2, kHeight - 6, markupEscaped(x_label_), markupEscaped(y_label_));
  return svg;
}

std::string SvgPlot::text() const {
  if (x_.low > x_.high) return {};
  SvgPlot room = *this;  // a little above and below
  const double margin = room.y_.high > room.y_.low ? 0.04 * (room.y_.high - room.y_.low) : 0.5;
  if (!room.y_.fixed) {
    room.y_.high += margin;
    if (room.y_.low != 0) room.y_.low -= margin;
  }
  std::string svg =
      fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\">\n", width_, kHeight) + room.axesText();
  for (const auto& [value, label] : levels_)
    svg += fmt::format(
        "<path d=\"M{0},{1:.1f}H{2}\" stroke=\"#777\" stroke-dasharray=\"4 3\"/><text x=\"{3}\" "
        "y=\"{4:.1f}\" text-anchor=\"end\">{5}</text>\n",
        kLeft, room.y(value), width_ - kRight, width_ - kRight - 2, room.y(value) - 4,
        markupEscaped(label));
  std::string legend;
  for (const Shape& shape : shapes_) {
    svg += room.shapeText(shape);
    if (!shape.legend.empty())
      legend += fmt::format("<span><i style=\"background:{}\"></i>{}</span>", shape.colour,
                            markupEscaped(shape.legend));
  }
  return svg + "</svg>\n" + (legend.empty() ? "" : "<div class=\"legend\">" + legend + "</div>\n");
}

}  // namespace cf
