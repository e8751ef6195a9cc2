// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace cf {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 4000;
  c.height = 3000;
  c.fx = c.fy = 3000;
  c.cx = 1999.5;
  c.cy = 1499.5;
  return c;
}

/// Nadir camera whose image top points `yaw` from north, counter-clockwise; pitch lifts the axis.
Eigen::Isometry3d cameraPose(const Eigen::Vector3d& centre, double yaw_deg, double pitch_deg = 0) {
  Eigen::Matrix3d nadir;
  nadir << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * M_PI / 180, Eigen::Vector3d::UnitZ()) * nadir *
               Eigen::AngleAxisd(pitch_deg * M_PI / 180, Eigen::Vector3d::UnitX());
  T.translation() = centre;
  return T;
}

std::set<std::pair<FrameId, FrameId>> keys(const std::vector<CandidatePair>& pairs) {
  std::set<std::pair<FrameId, FrameId>> k;
  for (const CandidatePair& p : pairs) k.insert({p.a, p.b});
  return k;
}

/// Share of a fine grid over `a` inside `b`, by pixels of the camera: independent of polygons.
double overlapByProjection(const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b,
                           double ground_z) {
  const CameraModel c = camera();
  int inside = 0, total = 0;
  for (int u = 20; u < c.width; u += 40) {
    for (int v = 20; v < c.height; v += 40) {
      const Eigen::Vector3d ray = T_a.linear() * c.undistort({u, v}).homogeneous();
      const Eigen::Vector3d p =
          T_a.translation() + (ground_z - T_a.translation().z()) / ray.z() * ray;
      const Eigen::Vector3d in_b = T_b.inverse() * p;
      ++total;
      inside += in_b.z() > 0 && c.contains(c.project(in_b));
    }
  }
  return static_cast<double>(inside) / total;
}

std::vector<Footprint> lawnmower(double sigma_m) {
  std::vector<Footprint> all;
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> jitter(-4, 4);
  for (int uav = 0; uav < 3; ++uav) {
    std::uint32_t index = 0;
    for (int strip = 0; strip < 4; ++strip) {
      for (int i = 0; i < 12; ++i) {
        const double along = 20 * (strip % 2 == 0 ? i : 11 - i), across = 45 * strip;
        const bool turned = uav == 2;  // crosses the others at right angles, higher
        const Eigen::Vector3d eye(turned ? across : along + 100 * uav, turned ? along : across,
                                  turned ? 130 : 100);
        const auto T = cameraPose(eye + Eigen::Vector3d(jitter(rng), jitter(rng), 0),
                                  (turned ? 90 : 0) + 180 * (strip % 2));
        all.push_back(predictFootprint({static_cast<std::uint16_t>(uav), index++}, strip / 2, T,
                                       camera(), eye.z(), sigma_m));
      }
    }
  }
  return all;
}

TEST(Candidates, OverlapIsThatOfTheProjection) {
  const auto T_a = cameraPose({0, 0, 100}, 0);
  const Footprint a = predictFootprint({0, 0}, 0, T_a, camera(), 100, 0);
  for (const double yaw : {0.0, 30.0, 90.0, 180.0}) {
    for (const double height : {70.0, 100.0}) {
      const auto T_b = cameraPose({35, -20, height}, yaw);
      const Footprint b = predictFootprint({1, 0}, 0, T_b, camera(), height, 0);
      // The smaller footprint is b's.
      EXPECT_NEAR(overlapOf(a, b), overlapByProjection(T_b, T_a, 0), 0.02) << yaw << " " << height;
    }
  }
}

TEST(Candidates, ObliqueFootprintLiesAheadAndStaysFinite) {
  const auto T = cameraPose({0, 0, 100}, 0, 16);
  const Footprint f = predictFootprint({0, 0}, 0, T, camera(), 100 / std::cos(16 * M_PI / 180), 0);
  EXPECT_NEAR(f.centre_m.y(), 100 * std::tan(16 * M_PI / 180), 1e-9);
  EXPECT_EQ(f.outline_m.size(), 4u);
  const Footprint level =
      predictFootprint({0, 0}, 0, cameraPose({0, 0, 100}, 0, 90), camera(), 50, 0);
  for (const auto& p : level.outline_m) EXPECT_LE(p.norm(), 100 + 1e-9);
}

TEST(Candidates, SlackMovesFootprintsTogether) {
  const Footprint a = predictFootprint({0, 0}, 0, cameraPose({0, 0, 100}, 0), camera(), 100, 0);
  const Footprint b = predictFootprint({1, 0}, 0, cameraPose({200, 0, 100}, 0), camera(), 100, 0);
  EXPECT_EQ(overlapOf(a, b), 0);
  EXPECT_NEAR(overlapOf(a, b, 1000), 1, 1e-9);
  EXPECT_NEAR(overlapOf(a, b, 134), 0.505, 0.01);  // 66 m apart, 133.3 m wide
}

TEST(Candidates, AreExactlyThoseOfBruteForce) {
  for (const double sigma : {0.0, 3.0, 40.0}) {
    const std::vector<Footprint> all = lawnmower(sigma);
    CandidateOptions options;
    options.max_pairs_per_photo = 1000;
    std::set<std::pair<FrameId, FrameId>> expected;
    for (const Footprint& a : all) {
      for (const Footprint& b : all) {
        if (!(a.frame < b.frame)) continue;
        if (a.frame.uav == b.frame.uav && a.segment == b.segment &&
            b.frame.index - a.frame.index < 6) {
          continue;
        }
        if (overlapOf(a, b, 2 * sigma * std::sqrt(2.0)) >= options.min_overlap) {
          expected.insert({a.frame, b.frame});
        }
      }
    }
    EXPECT_GT(expected.size(), 100u);
    EXPECT_EQ(keys(findCandidates(all, options)), expected) << "sigma " << sigma;
  }
}

TEST(Candidates, InsertingOneByOneFindsTheSamePairs) {
  const std::vector<Footprint> all = lawnmower(3);
  CandidateOptions options;
  options.max_pairs_per_photo = 1000;
  CandidateIndex index(options);
  std::set<std::pair<FrameId, FrameId>> grown;
  for (const Footprint& f : all) {
    for (const CandidatePair& p : index.insert(f)) {
      EXPECT_TRUE(grown.insert({p.a, p.b}).second);
    }
  }
  EXPECT_EQ(index.size(), all.size());
  EXPECT_EQ(grown, keys(findCandidates(all, options)));
}

TEST(Candidates, CapKeepsEveryOtherSegmentAndTheBestOfEach) {
  const std::vector<Footprint> all = lawnmower(500);  // junk GPS: everything may overlap everything
  CandidateOptions options;
  options.max_pairs_per_photo = 5;
  CandidateIndex index(options);
  index.rebuild(all);
  for (const Footprint& f : all) {
    const auto pairs = index.query(f);
    ASSERT_EQ(pairs.size(), 5u);
    std::map<std::pair<int, int>, std::pair<int, double>> seen;  // segment: count, best overlap
    for (const CandidatePair& p : pairs) {
      const FrameId other = p.a == f.frame ? p.b : p.a;
      const auto it = std::find_if(all.begin(), all.end(),
                                   [&](const Footprint& o) { return o.frame == other; });
      auto& [count, best] = seen[{other.uav, it->segment}];
      ++count;
      best = std::max(best, p.overlap);
    }
    // Its own segment has partners too: six segments, five of them asked once.
    EXPECT_EQ(seen.size(), 5u);
    for (const auto& [segment, entry] : seen) {
      for (const Footprint& o : all) {
        const bool neighbour = o.frame.uav == f.frame.uav && o.segment == f.segment &&
                               std::abs(int(o.frame.index) - int(f.frame.index)) < 6;
        if (std::pair<int, int>(o.frame.uav, o.segment) == segment && !neighbour) {
          EXPECT_LE(overlapOf(f, o), entry.second + 1e-12);
        }
      }
    }
  }
}

TEST(Candidates, DoNotDependOnTheOrderOfThePhotos) {
  std::vector<Footprint> all = lawnmower(10);
  const auto first = findCandidates(all, {});
  std::reverse(all.begin(), all.end());
  const auto second = findCandidates(all, {});
  ASSERT_EQ(first.size(), second.size());
  EXPECT_EQ(keys(first), keys(second));
}

TEST(Candidates, UnlocatedPhotosAskEverywhereWithinTheirCap) {
  std::vector<Footprint> all = lawnmower(1);
  CandidateOptions options;
  options.max_unlocated_pairs = 10;
  CandidateIndex index(options);
  index.rebuild(all);
  const auto pairs = index.insert(unlocatedFootprint({3, 0}, 0));
  ASSERT_EQ(pairs.size(), 10u);
  std::set<int> uavs;
  for (const CandidatePair& p : pairs) uavs.insert(p.a.uav);
  EXPECT_EQ(uavs.size(), 3u);
  // A located newcomer asks for the unlocated one as well.
  const auto newcomer = index.query(all[0]);
  EXPECT_TRUE(std::any_of(newcomer.begin(), newcomer.end(),
                          [](const CandidatePair& p) { return p.b.uav == 3; }));
}

TEST(Candidates, RebuildTakesTheNewPoses) {
  const auto at = [](FrameId id, double x) {
    return predictFootprint(id, 0, cameraPose({x, 0, 100}, 0), camera(), 100, 0);
  };
  CandidateIndex index({});
  EXPECT_TRUE(index.insert(at({0, 0}, 0)).empty());
  EXPECT_TRUE(index.insert(at({1, 0}, 500)).empty());
  index.rebuild({at({0, 0}, 0), at({1, 0}, 20)});
  EXPECT_EQ(index.query(at({0, 0}, 0)).size(), 1u);
}

}  // namespace
}  // namespace cf
