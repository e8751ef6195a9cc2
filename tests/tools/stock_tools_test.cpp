// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// MRPT's and OctoMap's own tools read what a run has written.
#include <gtest/gtest.h>

#include <memory>
#include <sstream>

#include "support/synthetic_flight.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::CommandResult;

class StockToolsOnARun : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<support::TempFolder>();
    const fs::path ini = support::writeSyntheticFlight(*folder_ / "in");
    const CommandResult r =
        support::runCommand(std::string(CF_BIN_DIR) + "/cf-run " + quoted(ini) + " -o " +
                            quoted(out("")) + " -s view.snapshots=false");
    ASSERT_EQ(r.status, 0) << r.output;
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static fs::path out(const std::string& file) { return *folder_ / "out" / file; }
  static std::string quoted(const fs::path& path) { return "'" + path.string() + "'"; }
  static bool has(const std::string& tool) {
    return support::runCommand("command -v " + tool).status == 0;
  }
  static CommandResult done(const std::string& command) {
    const CommandResult r = support::runCommand(command);
    EXPECT_EQ(r.status, 0) << command << "\n" << r.output;
    return r;
  }

  static std::unique_ptr<support::TempFolder> folder_;
};
std::unique_ptr<support::TempFolder> StockToolsOnARun::folder_;

int linesWith(const std::string& text, const std::string& start) {
  std::istringstream in(text);
  int count = 0;
  for (std::string line; std::getline(in, line);)
    if (line.compare(0, start.size(), start) == 0) ++count;
  return count;
}

TEST_F(StockToolsOnARun, GraphSlamOptimisesEveryGraph) {
  if (!has("graph-slam")) GTEST_SKIP() << "graph-slam (Debian: mrpt-apps) is not installed";
  for (const auto& uav : support::syntheticFlight().uavs) {
    const fs::path graph = out("graphs/" + uav.name + ".graph");
    const fs::path optimised = *folder_ / (uav.name + ".optimised.graph");
    done("graph-slam --3d --levmarq --no-span --max-iters 20 -i " + quoted(graph) + " -o " +
         quoted(optimised));
    const std::string before = support::fileText(graph), after = support::fileText(optimised);
    EXPECT_GE(linesWith(before, "VERTEX"), static_cast<int>(uav.photos.size()));
    EXPECT_EQ(linesWith(after, "VERTEX"), linesWith(before, "VERTEX"));
    EXPECT_EQ(linesWith(after, "EDGE"), linesWith(before, "EDGE"));
    EXPECT_EQ(after.find("nan"), std::string::npos) << after;
  }
}

TEST_F(StockToolsOnARun, OctomapToolsConvertAndCompare) {
  if (!has("convert_octree") || !has("compare_octrees"))
    GTEST_SKIP() << "convert_octree, compare_octrees (Debian: octomap-tools) are not installed";
  const fs::path colour_bt = *folder_ / "colour.bt", ours_ot = *folder_ / "ours.ot";
  const fs::path colour_ot = *folder_ / "colour.ot";
  done("convert_octree " + quoted(out("octomap.ot")) + " " + quoted(colour_bt));
  // compare_octrees reads only .ot and breaks down on colour trees, OctoMap's own included: both
  // sides go through .bt, which holds occupancy alone.
  done("convert_octree " + quoted(colour_bt) + " " + quoted(colour_ot));
  done("convert_octree " + quoted(out("octomap.bt")) + " " + quoted(ours_ot));
  const CommandResult r = done("compare_octrees " + quoted(colour_ot) + " " + quoted(ours_ot));
  EXPECT_NE(r.output.find("KLD: 0\n"), std::string::npos) << r.output;
}

}  // namespace
}  // namespace cf
