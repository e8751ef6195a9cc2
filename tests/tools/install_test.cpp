// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// What `cmake --install` puts into a prefix works from there: programs, demo, and libraries for a
// project of somebody else's.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

class Installed : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<support::TempFolder>();
    done("cmake --install " + quoted(fs::path(CF_BIN_DIR).parent_path()) + " --prefix " +
         quoted(prefix()));
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static fs::path prefix() { return *folder_ / "prefix"; }
  static std::string quoted(const fs::path& path) { return "'" + path.string() + "'"; }
  /// Runs it away from the source tree.
  static std::string done(const std::string& command) {
    const auto r = support::runCommand("cd " + quoted(folder_->path()) + " && " + command);
    EXPECT_EQ(r.status, 0) << command << "\n" << r.output;
    return r.output;
  }

  static std::unique_ptr<support::TempFolder> folder_;
};
std::unique_ptr<support::TempFolder> Installed::folder_;

TEST_F(Installed, ProgramsFindTheDemo) {
  const fs::path bin = prefix() / "bin", share = prefix() / "share" / "clusterfusion";
  for (const char* program : {"cf-import", "cf-simulate", "cf-run", "cf-eval", "cf-snapshot"}) {
    EXPECT_NE(done(quoted(bin / program) + " --version"), "");
    EXPECT_NE(done(quoted(bin / program) + " --help").find(program), std::string::npos);
  }
  done(quoted(bin / "cf-run") + " " + quoted(share / "config.ini") +
       " -o demo -s densify.megapixels=0.05 -s deliver.orthophoto=0 -s view.snapshots=0");
  const std::string figures = done(quoted(bin / "cf-eval") + " trajectory demo " +
                                   quoted(share / "rawlogs" / "demo" / "truth"));
  EXPECT_NE(figures.find("\"matched\": 36"), std::string::npos) << figures;
  EXPECT_TRUE(fs::exists(share / "scenes" / "town_12mp.ini"));
  EXPECT_TRUE(fs::exists(prefix() / "share" / "doc" / "clusterfusion" / "README.md"));
}

TEST_F(Installed, AnotherProjectBuildsWithTheLibraries) {
  done("cmake -S " CF_SOURCE_DIR "/tests/tools/consumer -B consumer -DCMAKE_PREFIX_PATH=" +
       quoted(prefix()));
  done("cmake --build consumer");
  support::writeText(*folder_ / "empty.ini", "[world]\n");
  const std::string said = done("consumer/consumer empty.ini");
  EXPECT_NE(said.find("32N"), std::string::npos) << said;
  EXPECT_NE(said.find("uav"), std::string::npos) << said;
}

TEST_F(Installed, AnotherVersionIsNotTaken) {
  support::writeText(*folder_ / "other" / "CMakeLists.txt",
                     "cmake_minimum_required(VERSION 3.18)\nproject(other LANGUAGES C CXX)\n"
                     "find_package(clusterfusion 99 REQUIRED)\n");
  const auto r = support::runCommand("cmake -S " + quoted(*folder_ / "other") + " -B " +
                                     quoted(*folder_ / "other" / "build") +
                                     " -DCMAKE_PREFIX_PATH=" + quoted(prefix()));
  EXPECT_NE(r.status, 0);
  EXPECT_NE(r.output.find("requested version"), std::string::npos) << r.output;
}

}  // namespace
}  // namespace cf
