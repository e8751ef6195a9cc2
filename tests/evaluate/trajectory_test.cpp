// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "cf/formats/csv.h"
#include "cf/formats/tum.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs kStart = 1466699519 * kNsPerSecond;

/// A climbing, turning path of nine photos.
Eigen::Isometry3d truth(int k) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Eigen::Vector3d(10 * (k % 3), 12 * (k / 3), 50 + 0.3 * k * k));
  T.rotate(Eigen::AngleAxisd(0.2 * k, Eigen::Vector3d(0.1, 0.3, 1).normalized()));
  return T;
}

Sim3 known(double scale) {
  Sim3 S;
  S.scale = scale;
  S.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  S.translation = {5, -6, 7};
  return S;
}

/// The truth seen in another frame, so that S maps it back.
PosePairs movedBy(const Sim3& S) {
  PosePairs pairs;
  for (int k = 0; k < 9; ++k)
    pairs.pairs.push_back({k < 5 ? "a" : "b", S.inverse().carry(truth(k)), truth(k), {}, 0});
  return pairs;
}

TEST(Trajectory, Se3RecoversARigidMotion) {
  const auto evaluation = evaluateTrajectory(movedBy(known(1)), AlignmentModel::kSe3);
  EXPECT_EQ(evaluation.all.matched, 9);
  EXPECT_NEAR(evaluation.all.max_m, 0, 1e-9);
  EXPECT_NEAR(evaluation.all.rotation_rmse_deg, 0, 1e-5);
  EXPECT_TRUE(evaluation.S_ref_est.rotation.isApprox(known(1).rotation, 1e-9));
  EXPECT_EQ(evaluation.S_ref_est.scale, 1);
  EXPECT_NEAR(evaluation.extent_m, Eigen::Vector3d(20, 24, 0.3 * 64).norm(), 1e-9);
}

TEST(Trajectory, OnlySim3RecoversScale) {
  const PosePairs pairs = movedBy(known(2.5));
  const auto sim3 = evaluateTrajectory(pairs, AlignmentModel::kSim3);
  EXPECT_NEAR(sim3.all.rmse_m, 0, 1e-9);
  EXPECT_NEAR(sim3.S_ref_est.scale, 2.5, 1e-9);
  EXPECT_GT(evaluateTrajectory(pairs, AlignmentModel::kSe3).all.rmse_m, 5);
}

TEST(Trajectory, Yaw4LeavesTiltAlone) {
  Sim3 tilt;
  tilt.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto evaluation = evaluateTrajectory(movedBy(tilt), AlignmentModel::kYaw4);
  EXPECT_GT(evaluation.all.rotation_median_deg, 5);
  EXPECT_TRUE(evaluation.S_ref_est.rotation.col(2).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
}

TEST(Trajectory, FiguresOfKnownErrorsWithoutAlignment) {
  PosePairs pairs = movedBy(Sim3{});
  pairs.missing = 2;
  pairs.pairs[0].estimate.pretranslate(Eigen::Vector3d(3, 0, 4));
  for (std::size_t k = 5; k < 9; ++k)
    pairs.pairs[k].estimate.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()));
  const auto evaluation = evaluateTrajectory(pairs, std::nullopt);
  EXPECT_NEAR(evaluation.all.max_m, 5, 1e-9);
  EXPECT_NEAR(evaluation.all.rmse_m, 5 / 3.0, 1e-9);
  EXPECT_NEAR(evaluation.all.median_m, 0, 1e-9);
  EXPECT_TRUE(evaluation.all.rmse_axis_m.isApprox(Eigen::Vector3d(1, 0, 4 / 3.0), 1e-9));
  EXPECT_NEAR(evaluation.per_uav.at("b").rotation_median_deg, 0.02 * 180 / M_PI, 1e-6);
  EXPECT_NEAR(evaluation.per_uav.at("b").max_m, 0, 1e-9);
  EXPECT_NEAR(evaluation.per_uav.at("a").rotation_rmse_deg, 0, 1e-5);
  EXPECT_EQ(evaluation.per_uav.at("a").matched, 5);
  const auto json = nlohmann::json::parse(toJson(evaluation, "none"));
  EXPECT_EQ(json["missing"], 2);
  EXPECT_NEAR(json["rmse_over_extent"].get<double>(), 5 / 3.0 / evaluation.extent_m, 1e-9);
  EXPECT_EQ(json["per_uav"]["b"]["matched"], 4);
}

TEST(Trajectory, NothingMatchedOrOneLineIsAnError) {
  EXPECT_THROW(evaluateTrajectory(PosePairs{}, std::nullopt), RunError);
  PosePairs line;
  for (int k = 0; k < 5; ++k) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translate(Eigen::Vector3d(k, 2 * k, 0));
    line.pairs.push_back({"a", T, T, {}, 0});
  }
  EXPECT_THROW(evaluateTrajectory(line, AlignmentModel::kSe3), RunError);
  EXPECT_NEAR(evaluateTrajectory(line, AlignmentModel::kYaw4).all.max_m, 0, 1e-9);
}

/// A run's folder and a reference's.
class Folders : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / "cf_evaluate_trajectory";
    fs::remove_all(root_);
    for (const char* name : {"out/images", "out/trajectories", "ref"})
      fs::create_directories(root_ / name);
  }
  struct Photo {
    std::string name;
    int truth;  ///< index of its pose
    bool posed = true;
  };
  void uav(const std::string& name, const std::vector<Photo>& photos) {
    CsvWriter csv(root_ / "out/images" / (name + ".csv"),
                  {"image", "t", "status", "segment", "keypoints", "matches", "inliers", "reason"});
    std::vector<TimedPose> poses;
    for (const Photo& p : photos) {
      const TimeNs t = kStart + p.truth * kNsPerSecond + 250'000'000;
      csv.row({p.name, timeText(t), p.posed ? "posed" : "unposed", "0", "9", "9", "9", ""});
      if (p.posed) poses.push_back({t, truth(p.truth)});
    }
    csv.close();
    writeTum(root_ / "out/trajectories" / (name + ".tum"), poses);
  }
  /// With times that differ from the run's, as another reading of EXIF gives.
  void reference(const std::vector<Photo>& photos, TimeNs time_shift) {
    std::string images;
    std::vector<TimedPose> poses;
    for (const Photo& p : photos) {
      const TimeNs t = kStart + p.truth * kNsPerSecond + 250'000'000 + time_shift;
      images += p.name + "\t" + timeText(t) + "\t0\t0\t0\n";
      poses.push_back({t, truth(p.truth)});
    }
    writeFileAtomically(root_ / "ref/images.tsv", images);
    writeTum(root_ / "ref/poses.tum", poses);
  }
  PosePairs join() const { return pairByName(root_ / "out", root_ / "ref"); }

  fs::path root_;
};

TEST_F(Folders, JoinByNameWhateverTheTimes) {
  uav("a", {{"1.jpg", 0}, {"2.jpg", 1}, {"3.jpg", 2, false}});
  uav("b", {{"4.jpg", 3}, {"5.jpg", 4}});
  reference({{"5.jpg", 4}, {"1.jpg", 0}, {"2.jpg", 1}, {"3.jpg", 2}, {"9.jpg", 8}},
            3600 * kNsPerSecond);
  const PosePairs joined = join();
  EXPECT_EQ(joined.pairs.size(), 3u);
  EXPECT_EQ(joined.missing, 2);       // 3.jpg unposed, 9.jpg unknown
  EXPECT_EQ(joined.unreferenced, 1);  // 4.jpg
  EXPECT_EQ(joined.pairs[0].uav, "b");
  EXPECT_NEAR(evaluateTrajectory(joined, std::nullopt).all.max_m, 0, 1e-5);
}

TEST_F(Folders, OneNameOfTwoUavsIsToldByUavOrTime) {
  uav("a", {{"1.jpg", 0}, {"2.jpg", 1}});
  uav("b", {{"1.jpg", 3}, {"2.jpg", 4}});
  reference({{"1.jpg", 3}, {"1.jpg", 0}, {"2.jpg", 4}}, 0);
  EXPECT_EQ(join().pairs.size(), 3u);
  EXPECT_NEAR(evaluateTrajectory(join(), std::nullopt).all.max_m, 0, 1e-5);
  reference({{"b/1.jpg", 3}, {"a/1.jpg", 0}, {"b/2.jpg", 4}}, kNsPerSecond * 3);
  EXPECT_EQ(join().pairs.size(), 3u);
  EXPECT_NEAR(evaluateTrajectory(join(), std::nullopt).all.max_m, 0, 1e-5);
  reference({{"1.jpg", 3}, {"1.jpg", 0}}, 100 * kNsPerSecond);  // nothing tells them apart
  EXPECT_EQ(join().pairs.size(), 0u);
  EXPECT_EQ(join().missing, 2);
}

TEST_F(Folders, DifferentOriginsAreBroughtTogether) {
  uav("a", {{"1.jpg", 0}, {"2.jpg", 1}, {"3.jpg", 5}});
  reference({{"1.jpg", 0}, {"2.jpg", 1}, {"3.jpg", 5}}, 0);
  writeFileAtomically(root_ / "out/world.json",
                      R"({"origin":{"lat":46.84,"lon":-91.99,"h":205},"frame":"ENU"})");
  writeFileAtomically(root_ / "ref/world.json",
                      R"({"origin":{"lat":46.84,"lon":-91.99,"h":200},"frame":"ENU"})");
  const auto evaluation = evaluateTrajectory(join(), std::nullopt);
  EXPECT_TRUE(evaluation.all.rmse_axis_m.isApprox(Eigen::Vector3d(0, 0, 5), 1e-6));
}

TEST_F(Folders, ContradictionsAreErrors) {
  uav("a", {{"1.jpg", 0}, {"2.jpg", 1}});
  reference({{"1.jpg", 0}}, 0);
  writeTum(root_ / "out/trajectories/a.tum", {{kStart + 250'000'000, truth(0)}});
  EXPECT_THROW(join(), RunError);
  fs::remove_all(root_ / "out/images");
  EXPECT_THROW(join(), RunError);
}

TEST_F(Folders, JoinByTime) {
  std::vector<TimedPose> est, ref;
  for (int k = 0; k < 6; ++k) est.push_back({kStart + k * kNsPerSecond, truth(k)});
  for (int k = 2; k < 9; ++k) ref.push_back({kStart + k * kNsPerSecond + 400'000, truth(k)});
  writeTum(root_ / "est.tum", est);
  writeTum(root_ / "ref.tum", ref);
  const PosePairs joined = pairByTime(root_ / "est.tum", root_ / "ref.tum");
  EXPECT_EQ(joined.pairs.size(), 4u);
  EXPECT_EQ(joined.missing, 3);
  EXPECT_EQ(joined.unreferenced, 2);
  EXPECT_NEAR(evaluateTrajectory(joined, std::nullopt).all.max_m, 0, 1e-5);
}

}  // namespace
}  // namespace cf
