// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "svg_plot.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cf {
namespace {

std::vector<std::string> textsOf(double low, double high) {
  std::vector<std::string> texts;
  const auto ticks = ticksOf(low, high, 5);
  for (const double tick : ticks) texts.push_back(tickText(tick, ticks[1] - ticks[0]));
  return texts;
}

TEST(SvgPlot, TicksAreRoundNumbers) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(textsOf(0, 10), (Texts{"0", "2", "4", "6", "8", "10"}));
  EXPECT_EQ(textsOf(-0.13, 0.11), (Texts{"-0.10", "-0.05", "0.00", "0.05", "0.10"}));
  EXPECT_EQ(textsOf(0.001, 0.0042), (Texts{"0.001", "0.002", "0.003", "0.004"}));
  EXPECT_EQ(textsOf(1000, 26000), (Texts{"5000", "10000", "15000", "20000", "25000"}));
}

TEST(SvgPlot, DrawsWhereTheNumbersAre) {
  SvgPlot plot("t [s]", "a < b [m]", 640);
  plot.limitY(0, 10);
  plot.line({{0, 0}, {5, 10}, {10, 25}}, "#123456", "<uav>");
  const std::string svg = plot.text();
  // Of 640 x 260 the frame is x 62 to 628 and y 218 to 26; what is outside is cut off.
  EXPECT_NE(svg.find("d=\"M62.0,218.0L345.0,26.0L628.0,26.0\""), std::string::npos) << svg;
  EXPECT_NE(svg.find("a &lt; b [m]"), std::string::npos);
  EXPECT_NE(svg.find("&lt;uav&gt;"), std::string::npos);
}

TEST(SvgPlot, NothingIsNoPlotAndWhatIsNotFiniteIsNoRange) {
  EXPECT_TRUE(SvgPlot("x", "y").text().empty());
  SvgPlot plot("x", "y");
  plot.dots({{0, 1}, {1, 2}, {2, INFINITY}, {3, NAN}}, "#000000", "");
  EXPECT_EQ(plot.text().find("inf"), std::string::npos);
  EXPECT_EQ(plot.text().find("nan"), std::string::npos);
}

}  // namespace
}  // namespace cf
