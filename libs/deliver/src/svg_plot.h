// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace cf {

using PlotPoint = std::pair<double, double>;

/// Colour of the n-th UAV on white, as "#rrggbb"; close to those of the snapshots.
std::string uavColour(std::size_t n);

/// An inline SVG chart with labelled axes. Give all that it shows, then take text(). Points that are
/// not finite are left out.
class SvgPlot {
 public:
  /// Labels with their units; letters are 12 where the whole is `width` wide.
  SvgPlot(std::string x_label, std::string y_label, double width = 640);

  void line(std::vector<PlotPoint> points, const std::string& colour, const std::string& legend);
  void dots(std::vector<PlotPoint> points, const std::string& colour, const std::string& legend);
  /// Between low and high at each x.
  void band(const std::vector<double>& x, const std::vector<double>& low,
            const std::vector<double>& high, const std::string& colour);
  /// A column for each, from 0; `width` in units of x.
  void columns(std::vector<PlotPoint> points, double width, const std::string& colour,
               const std::string& legend);
  /// A horizontal line of note.
  void level(double y, const std::string& label);
  void includeY(double y);
  /// What lies outside is cut off.
  void limitY(double low, double high);

  std::string text() const;

 private:
  struct Shape {
    enum class Kind { kLine, kDots, kBand, kColumns } kind;
    std::vector<PlotPoint> points;
    std::string colour, legend;
    double width = 0;
  };
  struct Axis {
    double low = 1e300, high = -1e300;
    bool fixed = false;
    void include(double value);
  };

  std::string shapeText(const Shape& shape) const;
  std::string axesText() const;
  double x(double value) const;
  double y(double value) const;

  std::string x_label_, y_label_;
  double width_;
  std::vector<Shape> shapes_;
  std::vector<std::pair<double, std::string>> levels_;
  Axis x_, y_;
};

/// Round numbers that divide low to high into about `wanted` parts.
std::vector<double> ticksOf(double low, double high, int wanted);

/// A number as short as its step allows.
std::string tickText(double value, double step);

}  // namespace cf
