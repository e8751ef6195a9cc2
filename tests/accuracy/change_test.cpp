// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Two flights over one simulated town that has changed in between, and one over the unchanged one:
// what cf-eval change finds, against the truth.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "cf/formats/float_raster.h"
#include "cf/geodesy/local_frame.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using Json = nlohmann::json;

constexpr double kRateBeyond3Sigma = 0.0027;  ///< of Gaussian errors: what the limit lets through

std::string run(const std::string& command) {
  const auto done = support::runCommand(command);
  EXPECT_EQ(done.status, 0) << command << "\n" << done.output;
  return done.output;
}

const LocalFrame& world() {
  static const LocalFrame frame(46.95, 7.44, 540);
  return frame;
}

/// Flies tests/accuracy/change.ini and maps it, in a world of another origin where `origin` says
/// so.
void fly(const std::string& folder, const std::string& simulation, const std::string& origin) {
  const std::string bin = CF_BIN_DIR;
  run(bin + "/cf-simulate '" CF_SOURCE_DIR "/tests/accuracy/change.ini' -o '" + folder + "' " +
      simulation);
  run(bin + "/cf-run '" + folder + "/config.ini' -o '" + folder +
      "/out' -s deliver.html=false -s deliver.orthophoto=false -s view.snapshots=false " + origin);
}

Json compare(const std::string& a, const std::string& b) {
  const std::string text = run(std::string(CF_BIN_DIR) + "/cf-eval change '" + a + "/out' '" + b +
                               "/out' -o '" + b + "/change'");
  fmt::print("{}\n", text);
  return Json::parse(text, nullptr, false);
}

struct Truth {
  double area_m2 = 0, volume_m3 = 0;
};

/// What differs between the true surfaces around a place.
Truth truthAround(const FloatRaster& a, const FloatRaster& b, double east, double north) {
  constexpr double kReach_m = 9, kSpacing_m = 0.25;
  Truth truth;
  for (int y = 0; y < a.values.rows; ++y)
    for (int x = 0; x < a.values.cols; ++x) {
      const double e = std::stod(a.metadata.at("ORIGIN_E")) + (x + 0.5) * kSpacing_m,
                   n = std::stod(a.metadata.at("ORIGIN_N")) - (y + 0.5) * kSpacing_m;
      if (std::hypot(e - east, n - north) > kReach_m) continue;
      const double d = static_cast<double>(b.values.at<float>(y, x)) -
                       static_cast<double>(a.values.at<float>(y, x));
      if (!(std::abs(d) > 0.1)) continue;
      truth.area_m2 += kSpacing_m * kSpacing_m;
      truth.volume_m3 += d * kSpacing_m * kSpacing_m;
    }
  return truth;
}

TEST(Change, IsFoundWhereItIsAndNowhereElse) {
  const support::TempFolder temp;
  const std::string before = (temp / "before").string(), after = (temp / "after").string(),
                    same = (temp / "same").string();
  const std::map<std::string, Eigen::Vector2d> places = {
      {"razed", {-4.25, 2.5}}, {"raised", {5.75, -17.5}}, {"built", {20, 12.5}}};
  fly(before, "", "");
  fly(same, "-s simulation.seed=22", "");
  fly(after,
      "-s simulation.seed=23 -s scene.sun_azimuth_deg=150 -s 'scene.changes=raze -4.25 2.5, "
      "raise 5.75 -17.5 2, build 20 12.5 8 6 4'",
      "-s 'world.origin=46.9503, 7.4404, 520'");
  if (HasFailure()) return;

  const Json unchanged = compare(before, same);
  const double false_m2 =
      unchanged["gain"]["area_m2"].get<double>() + unchanged["loss"]["area_m2"].get<double>();
  const double compared_m2 = unchanged["compared_m2"].get<double>();
  EXPECT_GT(compared_m2, 3000);
  EXPECT_LT(false_m2, kRateBeyond3Sigma * compared_m2);
  for (const Json& change : unchanged["changes"])
    EXPECT_LT(std::abs(change["mean_height_m"].get<double>()), 0.2) << change;
  EXPECT_LT(unchanged["stable_ground"]["beyond_3_sigma"].get<double>(), 0.01);

  const Json changed = compare(before, after);
  const FloatRaster a = readFloatRaster(before + "/truth/dsm.tif"),
                    b = readFloatRaster(after + "/truth/dsm.tif");
  double false_change_m2 = 0;
  std::map<std::string, int> found;
  for (const Json& change : changed["changes"]) {
    const Eigen::Vector3d p = world().toEnu(change["lat"], change["lon"], 540);
    const auto place = std::find_if(places.begin(), places.end(), [&](const auto& known) {
      return (p.head<2>() - known.second).norm() < 7;
    });
    const double area = change["area_m2"];
    if (place == places.end() || area < 10) {
      false_change_m2 += area;
      continue;
    }
    ++found[place->first];
    const Truth truth = truthAround(a, b, place->second.x(), place->second.y());
    const double volume = change["volume_m3"], sigma = change["volume_sigma_m3"];
    fmt::print("{:<8} area {:6.1f} of {:6.1f} m2, volume {:7.1f} +- {:.1f} of {:7.1f} m3\n",
               place->first, area, truth.area_m2, volume, sigma, truth.volume_m3);
    EXPECT_NEAR(area, truth.area_m2, 0.2 * truth.area_m2);
    EXPECT_NEAR(volume, truth.volume_m3, 3 * sigma);
    EXPECT_NEAR(volume, truth.volume_m3, 0.15 * std::abs(truth.volume_m3));
    EXPECT_EQ(change["kind"], truth.volume_m3 > 0 ? "gain" : "loss");
    if (place->first == "raised") {
      EXPECT_NEAR(change["mean_height_m"].get<double>(), 2, 0.1);
    }
  }
  EXPECT_EQ(found, (std::map<std::string, int>{{"razed", 1}, {"raised", 1}, {"built", 1}}));
  EXPECT_LT(false_change_m2, kRateBeyond3Sigma * compared_m2);
}

}  // namespace
}  // namespace cf
