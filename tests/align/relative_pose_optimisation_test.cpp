// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/relative_pose_optimisation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace cf {
namespace {

constexpr double kDegree = M_PI / 180;

struct ClusterOptions {
  int uavs = 4;
  double rotation_noise_deg = 0;
  double across_noise_m = 0;
  double length_noise = 0;  ///< relative
  double outliers = 0;      ///< share of the observations
  bool fixes = true;
  int lone_uav = -1;       ///< no observations
  int unlocated_uav = -1;  ///< no georeference: poses in a local frame of its own
};

Sim3 similarity(double scale, const Eigen::Vector3d& w, const Eigen::Vector3d& shift,
                const Eigen::Vector3d& pivot) {
  Sim3 S;
  S.scale = scale;
  S.rotation = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  S.translation = pivot + shift - scale * (S.rotation * pivot);
  return S;
}

/// UAVs over neighbouring fields, each flying a lawnmower of 5 x 4 photos that overlaps the next
/// UAV's. All but UAV 0 are georeferenced wrongly: 3 m, 2 degrees, 3 % of scale.
struct Cluster {
  std::vector<SegmentInput> segments;
  std::vector<PairObservation> observations;
  std::vector<char> outlier;
  std::vector<std::vector<Eigen::Isometry3d>> truth;
  std::vector<Sim3> S_before_true;

  Cluster(const ClusterOptions& o, unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> gauss;
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto vector = [&](double size) {
      return Eigen::Vector3d(size * gauss(rng), size * gauss(rng), size * gauss(rng));
    };
    Eigen::Matrix3d nadir;
    nadir << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    for (int u = 0; u < o.uavs; ++u) {
      SegmentInput input;
      input.segment.id = {static_cast<std::uint16_t>(u), 0};
      input.segment.georeferenced = u != o.unlocated_uav;
      truth.emplace_back();
      Eigen::Vector3d centre(100 * u + 50, 45, 100);
      Sim3 S = similarity(1.03, 2 * kDegree * vector(1).normalized(), 3 * vector(1).normalized(),
                          centre);
      if (u == 0) S = Sim3{};
      if (u == o.unlocated_uav) {
        S = similarity(1 / 40., Eigen::Vector3d(0.5, 1, -2), Eigen::Vector3d(-40, 3, -99), centre);
      }
      S_before_true.push_back(S);
      const Eigen::Vector3d bias = u == 0 ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(2, -1.5, 6);
      for (int i = 0; i < 20; ++i) {
        const int strip = i / 5, step = strip % 2 == 0 ? i % 5 : 4 - i % 5;
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.translation() = Eigen::Vector3d(100 * u + 25 * step, 30 * strip, 100 + 3 * gauss(rng));
        const Eigen::Vector3d sway = 0.05 * vector(1);
        T.linear() =
            Eigen::AngleAxisd(90. * u * kDegree + M_PI * (strip % 2), Eigen::Vector3d::UnitZ()) *
            nadir * Eigen::AngleAxisd(sway.norm(), sway.normalized());
        truth.back().push_back(T);
        GeoSegment::Pose pose;
        pose.frame = {static_cast<std::uint16_t>(u), static_cast<std::uint32_t>(i)};
        pose.T_world_cam = S.carry(T);
        input.segment.poses.push_back(pose);
        if (o.fixes && input.segment.georeferenced) {
          input.fixes.push_back(GnssPosition{T.translation() + bias, Eigen::Vector3d(1.5, 1.5, 3)});
        }
      }
      segments.push_back(input);
    }
    for (int u = 0; u < o.uavs; ++u) {
      for (int v = u + 1; v < o.uavs; ++v) {
        if (u == o.lone_uav || v == o.lone_uav) continue;
        for (std::uint32_t i = 0; i < 20; ++i) {
          for (std::uint32_t j = 0; j < 20; ++j) {
            const auto &T_a = truth[std::size_t(u)][i], &T_b = truth[std::size_t(v)][j];
            const double apart = (T_a.translation() - T_b.translation()).norm();
            if (apart > 45 || apart < 5) continue;
            PairObservation p;
            p.pose.a = {static_cast<std::uint16_t>(u), i};
            p.pose.b = {static_cast<std::uint16_t>(v), j};
            Eigen::Isometry3d T_a_b = T_a.inverse() * T_b;
            const double length = T_a_b.translation().norm();
            const bool wrong = uniform(rng) < o.outliers;
            outlier.push_back(wrong);
            const Eigen::Vector3d w =
                wrong ? Eigen::Vector3d(vector(0.2)) : vector(o.rotation_noise_deg * kDegree);
            if (w.norm() > 0) T_a_b.rotate(Eigen::AngleAxisd(w.norm(), w.normalized()));
            T_a_b.translation() += wrong ? vector(10) : vector(o.across_noise_m);
            p.pose.T_a_b = T_a_b;
            p.direction_a = T_a_b.translation().normalized();
            p.rotation_sigma_rad = std::max(o.rotation_noise_deg * kDegree, 1e-4);
            p.across_sigma_m = std::max(o.across_noise_m, 0.01);
            const double sigma = std::max(o.length_noise * length, 0.01);
            const auto measured = [&](int uav) {
              const double scale = S_before_true[std::size_t(uav)].scale;
              return DepthLength{scale * (length + o.length_noise * length * gauss(rng)),
                                 scale * sigma};
            };
            p.by_depth_a = measured(u);
            p.by_depth_b = measured(v);
            observations.push_back(p);
          }
        }
      }
    }
  }

  /// Largest error of a segment's corrected poses against the truth, metres and degrees.
  std::pair<double, double> worst(const RelativePoseSolution& solution, std::size_t s) const {
    double metres = 0, degrees = 0;
    for (std::size_t i = 0; i < truth[s].size(); ++i) {
      const Eigen::Isometry3d T =
          solution.corrections[s].S_world_before.carry(segments[s].segment.poses[i].T_world_cam);
      metres = std::max(metres, (T.translation() - truth[s][i].translation()).norm());
      const Eigen::AngleAxisd apart(Eigen::Matrix3d(T.linear().transpose() * truth[s][i].linear()));
      degrees = std::max(degrees, apart.angle() / kDegree);
    }
    return {metres, degrees};
  }
};

TEST(RelativePoseOptimisation, RecoversKnownOffsetsExactly) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Cluster cluster({}, seed);
    ASSERT_GT(cluster.observations.size(), 60u);
    const auto solution = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
    for (std::size_t s = 0; s < 4; ++s) {
      const auto [metres, degrees] = cluster.worst(solution, s);
      EXPECT_LT(metres, 0.02) << s;
      EXPECT_LT(degrees, 0.01) << s;
      EXPECT_EQ(solution.corrections[s].component, 0);
      EXPECT_TRUE(solution.corrections[s].connected);
      if (s > 0) {
        EXPECT_NEAR(solution.corrections[s].S_world_before.scale, 1 / 1.03, 1e-3);
        EXPECT_LT((solution.bias_m.at(std::uint16_t(s)) - Eigen::Vector3d(2, -1.5, 6)).norm(), 1);
      }
    }
    for (const ObservationResidual& r : solution.residuals) {
      EXPECT_GT(r.before_m, 0.1);
      EXPECT_GT(r.before_rad, 0.5 * kDegree);
      EXPECT_LT(r.after_m, 0.01);
      EXPECT_LT(r.after_rad, 0.01 * kDegree);
      EXPECT_GT(r.weight, 0.9);
    }
  }
}

TEST(RelativePoseOptimisation, NoiseAveragesAndOutliersDoNotBreakIt) {
  double worst_m[2] = {0, 0}, worst_deg[2] = {0, 0};
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const double outliers : {0.0, 0.2}) {
      ClusterOptions o;
      o.rotation_noise_deg = 0.1;
      o.across_noise_m = 0.1;
      o.length_noise = 0.005;
      o.outliers = outliers;
      const Cluster cluster(o, seed);
      const auto solution = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
      // The error adds up along the chain of UAVs; the next one is what seams are about.
      for (std::size_t s = 1; s < 4; ++s) {
        const auto [metres, degrees] = cluster.worst(solution, s);
        worst_m[outliers > 0] = std::max(worst_m[outliers > 0], metres / double(s));
        worst_deg[outliers > 0] = std::max(worst_deg[outliers > 0], degrees / double(s));
      }
      for (std::size_t k = 0; k < cluster.observations.size(); ++k) {
        if (cluster.outlier[k]) {
          EXPECT_LT(solution.residuals[k].weight, 0.1);
        } else {
          EXPECT_GT(solution.residuals[k].weight, 0.2);
        }
      }
    }
  }
  for (const int k : {0, 1}) {
    EXPECT_LT(worst_m[k], 0.25) << k;
    EXPECT_LT(worst_deg[k], 0.08) << k;
  }
  std::printf("noise: %.3f m %.3f deg; with outliers: %.3f m %.3f deg, per UAV of the chain\n",
              worst_m[0], worst_deg[0], worst_m[1], worst_deg[1]);
}

TEST(RelativePoseOptimisation, SegmentWithoutGeoreferenceIsPlacedByItsObservations) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    ClusterOptions o;
    o.unlocated_uav = 2;
    o.outliers = 0.2;
    const Cluster cluster(o, seed);
    const auto solution = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
    for (std::size_t s = 0; s < 4; ++s) {
      const auto [metres, degrees] = cluster.worst(solution, s);
      EXPECT_LT(metres, 0.05) << s;
      EXPECT_LT(degrees, 0.02) << s;
    }
  }
}

TEST(RelativePoseOptimisation, UnconnectedSegmentKeepsItsPoses) {
  ClusterOptions o;
  o.lone_uav = 3;
  const Cluster cluster(o, 1);
  const auto solution = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
  const SegmentCorrection& lone = solution.corrections[3];
  EXPECT_FALSE(lone.connected);
  EXPECT_EQ(lone.component, 1);
  EXPECT_EQ(lone.S_world_before.scale, 1);
  EXPECT_EQ(lone.S_world_before.rotation, Eigen::Matrix3d::Identity());
  EXPECT_LT(lone.S_world_before.translation.norm(), 1e-12);
  EXPECT_LT(cluster.worst(solution, 2).first, 0.02);
}

TEST(RelativePoseOptimisation, WithoutFixesTheMapStandsOnTheCentralSegment) {
  ClusterOptions o;
  o.fixes = false;
  const Cluster cluster(o, 4);
  const auto solution = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
  for (std::size_t s = 0; s < 4; ++s) EXPECT_LT(cluster.worst(solution, s).first, 0.05) << s;

  // No georeference at all: one map, in the frame of the segment that stays.
  Cluster local = cluster;
  for (SegmentInput& input : local.segments) input.segment.georeferenced = false;
  const auto relative = optimiseRelativePoses(local.segments, local.observations, 0, {});
  for (std::size_t s = 0; s < 4; ++s) EXPECT_LT(local.worst(relative, s).first, 0.05) << s;
}

TEST(RelativePoseOptimisation, RotationIsComparedInTheBodyFrame) {
  // Equation (9) must not notice a common turn of the whole world.
  Cluster cluster({}, 6);
  const auto before = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
  const Sim3 turn = similarity(1, {0.3, -0.2, 1.5}, {0, 0, 0}, {0, 0, 0});
  for (SegmentInput& input : cluster.segments) {
    for (auto& pose : input.segment.poses) pose.T_world_cam = turn.carry(pose.T_world_cam);
    for (auto& fix : input.fixes) fix->position_m = turn * fix->position_m;
  }
  const auto after = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
  for (std::size_t k = 0; k < before.residuals.size(); ++k) {
    EXPECT_NEAR(before.residuals[k].before_rad, after.residuals[k].before_rad, 1e-9);
    EXPECT_NEAR(before.residuals[k].before_m, after.residuals[k].before_m, 1e-6);
  }
}

TEST(RelativePoseOptimisation, IsDeterministicAndRefusesUnknownPhotos) {
  ClusterOptions o;
  o.outliers = 0.1;
  Cluster cluster(o, 8);
  const auto p = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
  const auto q = optimiseRelativePoses(cluster.segments, cluster.observations, 0, {});
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_EQ(p.corrections[s].S_world_before.translation,
              q.corrections[s].S_world_before.translation);
    EXPECT_EQ(p.corrections[s].S_world_before.scale, q.corrections[s].S_world_before.scale);
  }
  cluster.observations[0].pose.b = {9, 9};
  EXPECT_THROW(optimiseRelativePoses(cluster.segments, cluster.observations, 0, {}),
               std::invalid_argument);
  EXPECT_TRUE(optimiseRelativePoses({}, {}, 0, {}).corrections.empty());
}

}  // namespace
}  // namespace cf
