// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// report.html of a run, opened from its file in a browser without a display or network.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <regex>

#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/pipeline/flight_run.h"
#include "support/process.h"
#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

class ReportPage : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    setLogQuiet(true);
    folder_ = std::make_unique<support::TempFolder>();
    Config config = Config::fromFile(support::writeSyntheticFlight(*folder_ / "in"));
    config.override("view.size=320x240");
    config.override("densify.megapixels=0.1");
    record_ = runFlight(config, {*folder_ / "out", false, "1.2.3"});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string html() { return support::fileText(*folder_ / "out/report.html"); }

  static std::unique_ptr<support::TempFolder> folder_;
  static RunRecord record_;
};
std::unique_ptr<support::TempFolder> ReportPage::folder_;
RunRecord ReportPage::record_;

TEST_F(ReportPage, HasAllSectionsAndNeedsNothingElse) {
  for (const char* text :
       {"Photos placed", "Seam between UAVs", "Bending of the map", "GNSS against the map",
        "Consistent depth", "Trajectories over the orthophoto", "Surface model", "Overlap",
        "The map in 3D", "Scale over time", "Relative poses between UAVs", "Reprojection errors",
        "Cameras before and after", "Time and memory"})
    EXPECT_NE(html().find(text), std::string::npos) << text;
  EXPECT_LT(html().size(), 15u << 20);
  const std::string page = html();
  const std::regex outside("(src|href)=\"(?!data:)");
  EXPECT_FALSE(std::regex_search(page.substr(0, page.find("id=\"scene\"")), outside));
  EXPECT_EQ(page.find("nan</"), std::string::npos);
}

TEST_F(ReportPage, TheRunHasRecordedWhatItShows) {
  EXPECT_EQ(record_.self_check.size(), 6u);
  EXPECT_GT(record_.seam_points.size(), 100u);
  EXPECT_GT(record_.memory.size(), 1u);
  EXPECT_GT(record_.cloud.points().size(), 1000u);
  EXPECT_EQ(record_.latencies.size(), 15u);
  EXPECT_EQ(record_.uavs[0].fixes.size(), 5u);
  for (const SelfCheck& check : record_.self_check) {
    if (check.name != "photos" && check.name != "seam") continue;
    EXPECT_EQ(check.grade, Grade::kGreen) << check.finding;
  }
}

TEST_F(ReportPage, OpensInABrowserWithoutAnErrorAndDrawsIn3D) {
  const char* const chromium = "/usr/bin/chromium";
  if (!fs::exists(chromium)) GTEST_SKIP() << "Debian's package chromium is not installed";
  const fs::path out = *folder_ / "page.txt", profile = *folder_ / "profile";
  support::Process browser(
      {chromium, "--headless", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle",
       "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-logging=stderr",
       "--user-data-dir=" + profile.string(), "--window-size=1000,900",
       "--virtual-time-budget=20000", "--dump-dom",
       "file://" + (*folder_ / "out/report.html").string()},
      out);
  ASSERT_EQ(browser.wait(), 0) << support::fileText(out);
  const std::string page = support::fileText(out);
  const std::size_t said = page.find(":CONSOLE");
  EXPECT_EQ(said, std::string::npos) << page.substr(std::min(said, page.size()), 300);
  const std::string drawn = "data-drawn=\"";
  const std::size_t at = page.find(drawn);
  ASSERT_NE(at, std::string::npos) << "the 3D view has not been drawn";
  EXPECT_GT(std::stod(page.substr(at + drawn.size(), 12)), 0.02)
      << "share of the view that something is drawn in";
}

}  // namespace
}  // namespace cf
