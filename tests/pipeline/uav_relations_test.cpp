// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// How the UAVs of a cluster may stand to each other, each case a simulated flight from end to end.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/evaluate/run.h"
#include "cf/pipeline/flight_run.h"
#include "cf/simulate/simulation.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

using nlohmann::json;
using UavPair = std::pair<std::string, std::string>;

class UavRelations : public ::testing::Test {
 protected:
  /// Flies the UAVs of these sections over the town of uav_relations.ini, maps and evaluates it.
  void fly(int seed, const std::string& uav_sections, int unposed = 0) {
    setLogQuiet(true);
    const auto scene = std::filesystem::path(CF_SOURCE_DIR) / "tests/pipeline/uav_relations.ini";
    support::writeText(folder_ / "sim.ini", support::fileText(scene) + uav_sections);
    Config simulation = Config::fromFile(folder_ / "sim.ini");
    simulation.override("simulation.seed=" + std::to_string(seed));
    simulate(simulation, {folder_ / "in"});
    Config config = Config::fromFile(folder_ / "in" / "config.ini");
    for (const char* setting :
         {"densify.megapixels=0.05", "view.snapshots=false", "deliver.html=false"})
      config.override(setting);
    run_ = runFlight(config, {folder_ / "out", false, "test"});
    figures_ = json::parse(evaluateRun(folder_ / "out", folder_ / "in" / "truth"));
    EXPECT_EQ(figures_["photos"]["posed"].get<int>() + unposed,
              figures_["photos"]["total"].get<int>());
  }

  double at(const char* pointer) const {
    const json::json_pointer where(pointer);
    const json value = figures_.contains(where) ? figures_.at(where) : json();
    return value.is_number() ? value.get<double>() : std::nan("");
  }

  /// UAVs of the relative poses, in order of their names.
  std::set<UavPair> related() const {
    std::set<UavPair> pairs;
    for (const RelativePose& pose : run_.relative_poses) {
      UavPair pair{run_.uavs[pose.a.uav].name, run_.uavs[pose.b.uav].name};
      if (pair.first == pair.second) continue;
      if (pair.second < pair.first) std::swap(pair.first, pair.second);
      pairs.insert(pair);
    }
    return pairs;
  }

  bool warned(const std::string& text) const {
    return std::any_of(run_.warnings.begin(), run_.warnings.end(), [&](const Warning& line) {
      return line.text.find(text) != std::string::npos;
    });
  }

  /// One map, whose parts agree on the ground to a fraction of a pixel, and have its shape.
  void expectOneMap() {
    EXPECT_EQ(run_.components, 1);
    EXPECT_FALSE(warned("only GNSS ties them"));
    EXPECT_LT(at("/seam/all/horizontal_gsd/median"), 0.15);
    EXPECT_LT(at("/seam/all/vertical_gsd/median"), 0.25);
    EXPECT_LT(at("/trajectory/sim3/rmse_m"), 0.2);
    EXPECT_LT(at("/uav_pairs/rotation_rms_deg"), 0.6);
    EXPECT_LT(at("/relative_poses/rotation_deg/rms"), 3);  // none of them false
    EXPECT_LT(at("/relative_poses/direction_deg/rms"), 5);
    EXPECT_EQ(figures_["scale"]["within_limits"]["map"], true);
  }

  support::TempFolder folder_;
  RunRecord run_;
  json figures_;
};

TEST_F(UavRelations, OverlappingDirectly) {
  fly(21, "[uav.west]\ncenter_e = -30\n[uav.east]\ncenter_e = 30\n");
  expectOneMap();
  EXPECT_EQ(related(), (std::set<UavPair>{{"east", "west"}}));
  EXPECT_FALSE(warned("disagree"));
}

TEST_F(UavRelations, OnlyThroughAThirdThatComesLast) {
  fly(22,
      "[uav.west]\ncenter_e = -75\n[uav.east]\ncenter_e = 75\n"
      "[uav.middle]\nheading = 90\nlength = 130\nstart_delay = 300\n");
  expectOneMap();
  EXPECT_EQ(related(), (std::set<UavPair>{{"east", "middle"}, {"middle", "west"}}));
}

TEST_F(UavRelations, NotAtAll) {
  fly(23, "[uav.west]\ncenter_e = -150\n[uav.east]\ncenter_e = 150\n");
  EXPECT_EQ(run_.components, 2);
  EXPECT_TRUE(warned("2 parts that no match joins"));
  EXPECT_NE(warned("west: no match joins its"), warned("east: no match joins its"));
  EXPECT_TRUE(run_.relative_poses.empty());
  // Both are in the world, as well as GNSS of 1 and 2 m with biases of 2 and 5 m can tell.
  EXPECT_LT(at("/trajectory/none/rmse_m"), 8);
  EXPECT_LT(std::hypot(figures_["trajectory"]["none"]["rmse_axis_m"][0].get<double>(),
                       figures_["trajectory"]["none"]["rmse_axis_m"][1].get<double>()),
            3.5);
  for (const char* uav : {"west", "east"}) {
    EXPECT_LT(figures_["trajectory"]["per_uav"][uav]["own_se3"]["rmse_m"].get<double>(), 0.6);
    EXPECT_EQ(figures_["scale"]["map"][uav]["within_limit"], true);
  }
}

// Roofs and fields that look alike match in hundreds of photo pairs, where nothing is shared.
TEST_F(UavRelations, NotAtAllAndOneWithoutGnss) {
  fly(23, "[uav.west]\ncenter_e = -150\n[uav.east]\ncenter_e = 150\noutages = 0:100000\n", 16);
  EXPECT_EQ(run_.components, 1);
  EXPECT_TRUE(run_.relative_poses.empty());
  EXPECT_TRUE(warned("east: no match joins its"));
  EXPECT_TRUE(warned("left out of the map"));
  EXPECT_LT(at("/trajectory/sim3/rmse_m"), 0.4);
}

TEST_F(UavRelations, DifferentCamerasAndHeights) {
  fly(24,
      "[uav.low]\ncenter_e = -10\n"
      "[uav.high]\ncenter_e = 15\nheading = 90\nheight = 100\nphoto_width = 1000\n"
      "photo_height = 750\nfov = 60\nk1 = 0.02\nk2 = 0\ntold_focal_error = -2\n");
  expectOneMap();
  EXPECT_EQ(related(), (std::set<UavPair>{{"high", "low"}}));
  EXPECT_LT(std::abs(at("/camera/per_uav/high/after/focal_error_pct")), 2);
}

TEST_F(UavRelations, ALateJoiner) {
  fly(25, "[uav.first]\ncenter_e = -30\n[uav.late]\ncenter_e = 30\nstart_delay = 600\n");
  expectOneMap();
  EXPECT_EQ(related(), (std::set<UavPair>{{"first", "late"}}));
}

TEST_F(UavRelations, GpsAltitude40MetresOff) {
  fly(26,
      "[uav.west]\ncenter_e = -30\n[uav.east]\ncenter_e = 30\n"
      "[uav.across]\nheading = 90\nbias_u = 40\n");
  expectOneMap();
  EXPECT_EQ(related().size(), 3u);
  EXPECT_LT(at("/gnss/relative_bias_rms_m/vertical"), 2);
  EXPECT_LT(at("/doming/span_m"), 0.6);
  EXPECT_TRUE(warned("across: its GPS altitude disagrees by"));
  EXPECT_EQ(run_.warnings.size(), 1u);
}

// Different heights and a wrong altitude together: what a photo shows is where GPS says it is not.
TEST_F(UavRelations, GpsAltitude40MetresOffOfTheHigherOfTwo) {
  fly(24,
      "[uav.low]\ncenter_e = -10\n"
      "[uav.high]\ncenter_e = 15\nheading = 90\nheight = 100\nphoto_width = 1000\n"
      "photo_height = 750\nfov = 60\nk1 = 0.02\nk2 = 0\ntold_focal_error = -2\nbias_u = 40\n");
  expectOneMap();
  EXPECT_LT(at("/gnss/relative_bias_rms_m/vertical"), 2);
  EXPECT_TRUE(warned("low and high: their GPS altitude disagrees by"));
}

}  // namespace
}  // namespace cf
