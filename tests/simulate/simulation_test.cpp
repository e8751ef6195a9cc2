// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/evaluate/trajectory.h"
#include "cf/formats/camera_ini.h"
#include "cf/formats/csv.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/ply.h"
#include "cf/formats/tum.h"
#include "cf/geodesy/local_frame.h"
#include "cf/rawlog/rawlog_reader.h"
#include "cf/simulate/simulation_options.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::fileText;
using support::writeText;

/// Two UAVs that share an area, with small photos of a bent lens.
constexpr const char* kSmall = R"(
[simulation]
seed = 5
uavs = 2
depth_megapixels = 0.01
reference_spacing = 0.5
[scene]
building_density = 6
tree_density = 0
[camera]
photo_width = 160
photo_height = 120
k1 = -0.08
p1 = 0.001
cx_offset = 4
told_focal_error = 2
[flight]
length = 40
width = 50
height = 40
attitude_tags = true
[gnss]
bias_limit_v = 8
)";

class Simulation : public ::testing::Test {
 protected:
  void SetUp() override { setLogQuiet(true); }
  void TearDown() override { setLogQuiet(false); }

  SimulationSummary run(const std::string& out, const std::string& ini = kSmall,
                        const std::vector<std::string>& overrides = {}, bool overwrite = false) {
    writeText(folder_ / "sim.ini", ini);
    Config config = Config::fromFile(folder_ / "sim.ini");
    for (const std::string& assignment : overrides) config.override(assignment);
    return simulate(config, {folder_ / out, overwrite});
  }
  std::map<std::string, std::string> filesIn(const std::string& out) const {
    std::map<std::string, std::string> files;
    for (const auto& item : fs::recursive_directory_iterator(folder_ / out))
      if (item.is_regular_file())
        files[fs::relative(item.path(), folder_ / out).string()] = fileText(item.path());
    return files;
  }

  support::TempFolder folder_;
};

TEST_F(Simulation, givesTheSameBytesAgain) {
  run("a");
  run("b");
  const auto a = filesIn("a"), b = filesIn("b");
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, content] : a) EXPECT_TRUE(b.at(name) == content) << name;
  EXPECT_EQ(a.count("truth/dsm.tif"), 1U);
  EXPECT_EQ(a.count("uav2.rawlog"), 1U);
}

TEST_F(Simulation, changesNoPhotoWithTheNoiseOfGnss) {
  run("a");
  run("b", kSmall, {"gnss.sigma_h=9", "gnss.outlier_share=0.3"});
  const auto a = filesIn("a"), b = filesIn("b");
  EXPECT_EQ(a.at("uav1_Images/uav1_0002.jpg"), b.at("uav1_Images/uav1_0002.jpg"));
  EXPECT_EQ(a.at("truth/poses.tum"), b.at("truth/poses.tum"));
  EXPECT_NE(a.at("uav1.rawlog"), b.at("uav1.rawlog"));
}

TEST_F(Simulation, recordsWhatTheTruthSays) {
  const SimulationSummary summary = run("out");
  const fs::path out = folder_ / "out", truth = out / "truth";
  ASSERT_EQ(summary.uavs.size(), 2U);
  const auto gnss = nlohmann::json::parse(fileText(truth / "gnss.json"));
  const LocalFrame world(46.95, 7.44, 540);
  for (const SimulatedUavSummary& uav : summary.uavs) {
    const UavRecording recording = readRecording(out / (uav.name + ".rawlog"));
    EXPECT_TRUE(recording.warnings.empty());
    const auto poses = readTum(truth / "trajectories" / (uav.name + ".tum"));
    const CsvTable fixes(truth / "gnss" / (uav.name + ".csv"));
    ASSERT_EQ(recording.photos.size(), uav.photos);
    ASSERT_EQ(poses.size(), uav.photos);
    ASSERT_EQ(recording.fixes.size(), fixes.rows().size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const ImageFrame& photo = recording.photos[i];
      EXPECT_EQ(photo.time, poses[i].time);
      EXPECT_EQ(cv::imread(photo.file.string()).size(), cv::Size(160, 120));
      ASSERT_TRUE(photo.attitude.has_value());
      const Eigen::AngleAxisd off(Eigen::Matrix3d(rotationWorldCam(*photo.attitude).transpose() *
                                                  poses[i].T_world_cam.linear()));
      EXPECT_LT(off.angle(), 0.1);
      const GnssFix& fix = recording.fixes[i];
      const auto enu = world.toEnu(fix.latitude_deg, fix.longitude_deg, fix.height_m);
      EXPECT_NEAR(enu.x(), std::stod(fixes.rows()[i][fixes.column("e")]), 1e-4);
      EXPECT_NEAR(enu.z(), std::stod(fixes.rows()[i][fixes.column("u")]), 1e-4);
      const Eigen::Vector3d error = enu - poses[i].T_world_cam.translation();
      EXPECT_LT(std::abs(error.z() - gnss[uav.name]["bias_m"][2].get<double>()), 5 * 3);
    }
    const CameraModel camera = readCameraIni(truth / "cameras" / (uav.name + ".ini"));
    EXPECT_NEAR(recording.photos[0].camera.fx / camera.fx, 1.02, 1e-9);
    EXPECT_EQ(recording.photos[0].camera.k1, 0);
    EXPECT_EQ(camera.k1, -0.08);
    EXPECT_NEAR(camera.cx, 79.5 + 4, 1e-9);
  }
}

/// Depths and poses lead to the surface model and the cloud, by the estimator's own camera.
TEST_F(Simulation, hasDepthsThatMeetTheReferenceSurface) {
  run("out");
  const fs::path truth = folder_ / "out" / "truth";
  const CameraModel camera = readCameraIni(truth / "cameras" / "uav1.ini");
  const auto poses = readTum(truth / "trajectories" / "uav1.tum");
  const FloatRaster depth = readFloatRaster(truth / "depth" / "uav1" / "uav1_0001.tif");
  const FloatRaster dsm = readFloatRaster(truth / "dsm.tif");
  const double west = std::stod(dsm.metadata.at("ORIGIN_E")),
               north = std::stod(dsm.metadata.at("ORIGIN_N")),
               spacing = std::stod(dsm.metadata.at("SPACING"));
  const int step = std::stoi(depth.metadata.at("STEP"));
  ASSERT_GT(step, 1);
  std::vector<double> errors;
  for (int row = 0; row < depth.values.rows; ++row)
    for (int column = 0; column < depth.values.cols; ++column) {
      const double d = depth.values.at<float>(row, column);
      if (d == 0) continue;
      const Eigen::Vector2d n = camera.undistort(Eigen::Vector2d(column, row) * step);
      const Eigen::Vector3d p = poses[0].T_world_cam * Eigen::Vector3d(n.x() * d, n.y() * d, d);
      const int i = static_cast<int>((p.x() - west) / spacing),
                j = static_cast<int>((north - p.y()) / spacing);
      if (i < 0 || j < 0 || i >= dsm.values.cols || j >= dsm.values.rows) continue;
      const double z = dsm.values.at<float>(j, i);
      if (!std::isnan(z)) errors.push_back(std::abs(p.z() - z));
    }
  ASSERT_GT(errors.size(), 1000U);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.05);

  std::size_t cells = 0;
  for (int row = 0; row < dsm.values.rows; ++row)
    for (int column = 0; column < dsm.values.cols; ++column)
      cells += std::isnan(dsm.values.at<float>(row, column)) ? 0 : 1;
  EXPECT_EQ(readPly(truth / "cloud.ply").size(), cells);
  EXPECT_GT(cells, 5000U);
}

/// A run that has found the truth has no error.
TEST_F(Simulation, isAReferenceForTrajectories) {
  run("out");
  const fs::path truth = folder_ / "out" / "truth", run = folder_ / "run";
  fs::create_directories(run / "images");
  fs::copy(truth / "trajectories", run / "trajectories");
  fs::copy(truth / "world.json", run / "world.json");
  std::map<std::string, std::string> tables;
  for (const CsvRow& row : readCsvRows(truth / "images.tsv", '\t')) {
    const std::size_t slash = row[0].find('/');
    tables[row[0].substr(0, slash)] += row[0].substr(slash + 1) + "," + row[1] + ",posed\n";
  }
  for (const auto& [uav, rows] : tables)
    writeText(run / "images" / (uav + ".csv"), "image,t,status\n" + rows);
  const TrajectoryEvaluation evaluation = evaluateTrajectory(pairByName(run, truth), std::nullopt);
  EXPECT_EQ(evaluation.missing + evaluation.unreferenced, 0);
  EXPECT_LT(evaluation.all.max_m, 1e-5);
}

TEST_F(Simulation, letsASectionChangeOneUav) {
  const SimulationSummary summary =
      run("out", std::string(kSmall) + "[uav.uav2]\nheight = 55\n[uav.wing]\nmount = fixed\n",
          {"simulation.depth_megapixels=0", "simulation.reference_spacing=0"});
  ASSERT_EQ(summary.uavs.size(), 3U);
  EXPECT_EQ(summary.uavs[0].height_m, 40);
  EXPECT_EQ(summary.uavs[1].height_m, 55);
  EXPECT_EQ(summary.uavs[2].name, "wing");
  EXPECT_FALSE(fs::exists(folder_ / "out" / "truth" / "depth"));
  EXPECT_FALSE(fs::exists(folder_ / "out" / "truth" / "cloud.ply"));
}

TEST_F(Simulation, refusesWhatMakesNoSense) {
  const std::map<std::string, std::string> faults = {
      {"[simulation]\nuavs = 1\nsed = 3\n", "did you mean 'seed'"},
      {"[simulation]\nseed = 3\n", "no UAV"},
      {"[simulation]\nuavs = 1\norigin = here\n", "origin"},
      {"[simulation]\nuavs = 1\nstart = noon\n", "start"},
      {"[simulation]\nuavs = 1\n[scene]\narea = -inf, -inf, inf, inf\n", "area"},
      {"[simulation]\nuavs = 1\n[scene]\narea = -1, -1, 1, 1\n", "which it must hold"},
      {"[simulation]\nuavs = 1\n[flight]\nlength = 5\nwidth = 5\n", "[uav.uav1] 1 photo on"},
      {"[simulation]\nuavs = 1\n[flight]\nheight = 1\n", "height"},
      {"[uav.a/b]\nheight = 50\n", "file name"},
      {"[uav.a]\ngaps = x\n", "[uav.a] gaps"},
  };
  for (const auto& [ini, word] : faults) {
    try {
      run("faulty", ini);
      ADD_FAILURE() << ini;
    } catch (const UsageError& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
    }
  }
  EXPECT_FALSE(fs::exists(folder_ / "faulty"));
  writeText(folder_ / "file", "");
  EXPECT_THROW(run("file/below"), RunError);
}

TEST_F(Simulation, overwritesAnEarlierOneOnlyIfAsked) {
  const std::vector<std::string> small = {"simulation.depth_megapixels=0",
                                          "simulation.reference_spacing=0"};
  // A flight that somebody recorded is in the way too.
  writeText(folder_ / "out/uav2.rawlog", "recorded");
  EXPECT_THROW(run("out", kSmall, small), UsageError);
  EXPECT_EQ(filesIn("out").at("uav2.rawlog"), "recorded");
  fs::remove(folder_ / "out/uav2.rawlog");
  run("out", kSmall, small);
  EXPECT_THROW(run("out", kSmall, small), UsageError);
  const std::size_t before = filesIn("out").size();
  run("out", std::string(kSmall), {small[0], small[1], "flight.forward_overlap=0.5"}, true);
  EXPECT_LT(filesIn("out").size(), before);
}

/// docs/simulate.md tells the options as they are. CF_WRITE_REFERENCE=1 writes it.
TEST_F(Simulation, isDocumentedAsItIs) {
  writeText(folder_ / "sim.ini", "[uav.NAME]\n");
  Config config = Config::fromFile(folder_ / "sim.ini");
  loadSimulation(config);
  std::string reference = config.referenceMarkdown();
  // A section [uav.NAME] takes what three sections above describe.
  reference.resize(reference.find("## [uav.NAME]"));

  const fs::path page = fs::path(CF_SOURCE_DIR) / "docs" / "simulate.md";
  const std::string mark = "## [simulation]";
  const std::string text = fileText(page);
  ASSERT_NE(text.find(mark), std::string::npos);
  const std::string expected = text.substr(0, text.find(mark)) + reference;
  if (std::getenv("CF_WRITE_REFERENCE") != nullptr) writeText(page, expected);
  EXPECT_EQ(fileText(page), expected)
      << "write docs/simulate.md anew: CF_WRITE_REFERENCE=1 build/tests/test_simulate_simulation";
}

}  // namespace
}  // namespace cf
