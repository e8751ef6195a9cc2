// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "architecture/house_rules.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

TEST(House, hasNoBreach) {
  ASSERT_TRUE(fs::exists(fs::path(CF_SOURCE_DIR) / "libs" / "base"));
  for (const auto& breach : houseBreaches(CF_SOURCE_DIR)) ADD_FAILURE() << breach;
}

/// Small trees with known breaches: what the inspection must find, and nothing else.
class HouseRules : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(::testing::TempDir()) /
            ("cf_house_" +
             std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  void write(const fs::path& file, const std::string& text) {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  void source(const fs::path& file, const std::string& text) {
    const std::string spdx =
        "// SPDX-FileCopyrightText: 2026 Somebody\n"
        "// SPDX-License-Identifier: BSD-3-Clause\n";
    write(file, spdx + (file.extension() == ".h" ? "#pragma once\n" : "") + text);
  }
  using Breaches = std::vector<std::string>;
  Breaches found() const { return houseBreaches(root_); }

  fs::path root_;
};

TEST_F(HouseRules, findNothingInARightTree) {
  source("libs/base/src/log.cpp", "#include <fmt/format.h>\n#include <spdlog/spdlog.h>\n");
  source("libs/types/include/cf/types/a.h",
         "#include <Eigen/Core>\n#include <vector>\n"
         "#include <opencv2/core/mat.hpp>\n");
  source("libs/geometry/src/a.cpp",
         "#include <opencv2/calib3d.hpp>\n#include <unistd.h>\n"
         "#include \"cf/geometry/a.h\"\n#include \"cf/base/log.h\"\n");
  write("libs/geometry/CMakeLists.txt",
        "cf_library(geometry SOURCES src/a.cpp PUBLIC cf::types PRIVATE cf_opencv Ceres::ceres)\n"
        "target_compile_definitions(cf_geometry PRIVATE X)  # cf::pipeline\n");
  source("apps/cf-run/main.cpp",
         "#include <CLI/CLI.hpp>\n#include \"cf/pipeline/run.h\"\n"
         "int main() {}\n");
  write("apps/cf-run/CMakeLists.txt",
        "cf_application(cf-run SOURCES main.cpp LINKS cf::pipeline CLI11::CLI11)\n");
  write("CMakeLists.txt", "# no -march here\n");
  EXPECT_EQ(found(), Breaches());
}

TEST_F(HouseRules, findIncludesThatGoUpOrSideways) {
  source("libs/types/src/up.cpp", "#include \"cf/geometry/a.h\"\n");
  source("libs/densify/src/side.cpp", "  #  include <cf/fuse/a.h>\n");
  source("libs/align/src/odd.cpp", "#include \"cf/nowhere/a.h\"\n");
  source("libs/align/src/path.cpp", "#include \"../../base/include/cf/base/log.h\"\n");
  EXPECT_EQ(found(),
            (Breaches{"libs/align/src/odd.cpp: includes cf/nowhere, which is not in the table of "
                      "floors",
                      "libs/align/src/path.cpp: includes by a path with ../",
                      "libs/densify/src/side.cpp: includes cf/fuse of floor 3 from floor 3",
                      "libs/types/src/up.cpp: includes cf/geometry of floor 2 from floor 1"}));
}

TEST_F(HouseRules, findOutsideLibrariesThatAreNotForTheLib) {
  source("libs/base/src/a.cpp", "#include <Eigen/Core>\n");
  source("libs/types/src/a.cpp", "#include <opencv2/imgproc.hpp>\n");
  source("libs/evaluate/src/a.cpp", "#include <gdal_priv.h>\n#include <nlohmann/json.hpp>\n");
  source("libs/evaluate/src/b.cpp", "#include <exiv2/exiv2.hpp>\n#include <zlib.h>\n");
  source("apps/cf-run/main.cpp", "#include <mrpt/config/CConfigFile.h>\n");
  EXPECT_EQ(found(),
            (Breaches{"apps/cf-run/main.cpp: includes mrpt/config/CConfigFile.h (mrpt), which is "
                      "not for it",
                      "libs/base/src/a.cpp: includes Eigen/Core (eigen), which is not for it",
                      "libs/evaluate/src/a.cpp: includes gdal_priv.h (gdal), which is not for it",
                      "libs/evaluate/src/b.cpp: includes exiv2/exiv2.hpp, which is not a known "
                      "library",
                      "libs/evaluate/src/b.cpp: includes zlib.h (zlib), which is not for it",
                      "libs/types/src/a.cpp: includes opencv2/imgproc.hpp (opencv), which is not "
                      "for it"}));
}

TEST_F(HouseRules, findHeavyIncludesInPublicHeaders) {
  source("libs/geometry/include/cf/geometry/a.h", "#include <ceres/ceres.h>\n");
  source("libs/geometry/src/own.h", "#include <ceres/ceres.h>\n");
  EXPECT_EQ(found(), (Breaches{"libs/geometry/include/cf/geometry/a.h: is a public header and "
                               "includes ceres/ceres.h"}));
}

TEST_F(HouseRules, findLinksThatGoUpOrSideways) {
  write("libs/align/CMakeLists.txt",
        "cf_library(align SOURCES a.cpp\n  PUBLIC cf::types cf::odometry\n  PRIVATE cf_pipeline)\n"
        "target_link_libraries(cf_align PRIVATE cf::fuse Boost::system GDAL::GDAL)\n");
  write("apps/cf-run/CMakeLists.txt", "cf_application(cf-run LINKS cf::nowhere mrpt::obs)\n");
  EXPECT_EQ(
      found(),
      (Breaches{"apps/cf-run/CMakeLists.txt: links cf/nowhere, which is not in the table of floors",
                "apps/cf-run/CMakeLists.txt: links mrpt::obs (mrpt), which is not for it",
                "libs/align/CMakeLists.txt: links Boost::system, which is not a known library",
                "libs/align/CMakeLists.txt: links GDAL::GDAL (gdal), which is not for it",
                "libs/align/CMakeLists.txt: links cf/fuse of floor 3 from floor 3",
                "libs/align/CMakeLists.txt: links cf/odometry of floor 3 from floor 3",
                "libs/align/CMakeLists.txt: links cf/pipeline of floor 4 from floor 3"}));
}

TEST_F(HouseRules, findALibThatIsNotInTheTable) {
  source("libs/utils/src/a.cpp", "");
  EXPECT_EQ(found(), (Breaches{"libs/utils: is not in the table of floors"}));
}

TEST_F(HouseRules, findAMainThatIsTooLong) {
  std::string body = "#include <vector>\n\nint main() {\n";
  for (int i = 0; i < 23; ++i) body += "  // why\n  step();\n\n";
  source("apps/cf-run/main.cpp", body + "}\n");
  EXPECT_EQ(found(), Breaches());
  source("apps/cf-run/main.cpp", body + "  step();\n}\n");
  EXPECT_EQ(found(), (Breaches{"apps/cf-run/main.cpp: has 26 lines of code, 25 are allowed"}));
}

TEST_F(HouseRules, findMissingHeaderLines) {
  write("libs/base/src/a.cpp", "int x;\n");
  write("tests/base/a_test.cpp",
        "// SPDX-FileCopyrightText: 2026 Somebody\n// SPDX-License-Identifier: GPL-3.0-only\n");
  write("apps/cf-run/a.h",
        "// SPDX-FileCopyrightText: 2026 Somebody\n// SPDX-License-Identifier: BSD-3-Clause\n");
  EXPECT_EQ(found(), (Breaches{"apps/cf-run/a.h: has no #pragma once",
                               "libs/base/src/a.cpp: does not begin with the two SPDX lines",
                               "tests/base/a_test.cpp: does not begin with the two SPDX lines"}));
}

TEST_F(HouseRules, findForbiddenFlags) {
  write("CMakeLists.txt", "add_compile_options(-march=native)\n");
  write("libs/densify/CMakeLists.txt", "set(F \"-O3 -ffast-math\")\n");
  write("cmake/Fast.cmake", "set(F -mavx2)\n");
  const std::string what = ": sets a flag of -march, -mavx or -ffast-math";
  EXPECT_EQ(found(), (Breaches{"CMakeLists.txt" + what, "cmake/Fast.cmake" + what,
                               "libs/densify/CMakeLists.txt" + what}));
}

}  // namespace
}  // namespace cf
