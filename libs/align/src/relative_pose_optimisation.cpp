// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/relative_pose_optimisation.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include <Eigen/Dense>
#include <array>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "relative_pose_residuals.h"

namespace cf {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// Where a photo is: its segment and its pose there.
struct Place {
  std::size_t segment = 0, pose = 0;
};

class Optimisation {
 public:
  Optimisation(const std::vector<SegmentInput>& segments,
               const std::vector<PairObservation>& observations, std::uint16_t central_uav,
               const RelativePoseOptions& options)
      : segments_(segments),
        observations_(observations),
        central_uav_(central_uav),
        options_(options),
        base_(segments.size()),
        blocks_(segments.size()) {
    locate();
    joinComponents();
  }

  RelativePoseSolution solve() {
    RelativePoseSolution solution;
    for (std::size_t k = 0; k < observations_.size(); ++k) {
      const auto [before_m, before_rad] = discrepancy(k);
      solution.residuals.push_back({before_m, before_m, before_rad, before_rad, 0});
    }
    placeUnlocated();
    setPivots();
    // From a loss that every observation can pull on to one that leaves outliers behind.
    for (const double widening : {300.0, 30.0, 10.0, 3.0, 1.0}) run(widening * options_.loss);
    for (std::size_t k = 0; k < observations_.size(); ++k) {
      if (within(k)) continue;
      auto& r = solution.residuals[k];
      std::tie(r.after_m, r.after_rad) = discrepancy(k);
      r.weight = 1 / (1 + whitened2(k) / (options_.loss * options_.loss));
    }
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      SegmentCorrection c;
      c.id = segments_[s].segment.id;
      c.connected = connected(s);
      c.component = component_[s];
      c.S_world_before = blocks_[s].similarity() * base_[s];
      solution.corrections.push_back(c);
    }
    for (const auto& [uav, bias] : bias_) solution.bias_m[uav] = Eigen::Vector3d(bias.data());
    return solution;
  }

 private:
  void locate() {
    std::map<FrameId, Place> places;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const auto& poses = segments_[s].segment.poses;
      for (std::size_t i = 0; i < poses.size(); ++i) places[poses[i].frame] = {s, i};
    }
    for (const PairObservation& o : observations_) {
      const auto a = places.find(o.pose.a), b = places.find(o.pose.b);
      if (a == places.end() || b == places.end()) {
        throw std::invalid_argument("relative pose of a photo that is in no segment");
      }
      ends_.emplace_back(a->second, b->second);
    }
  }

  bool within(std::size_t k) const { return ends_[k].first.segment == ends_[k].second.segment; }

  /// The segment that does not move in its component: the central UAV's largest georeferenced one;
  /// in a component without any georeference, the largest.
  void joinComponents() {
    std::vector<std::size_t> root(segments_.size());
    std::iota(root.begin(), root.end(), std::size_t{0});
    const auto find = [&](std::size_t s) {
      while (root[s] != s) s = root[s] = root[root[s]];
      return s;
    };
    for (const auto& [a, b] : ends_) root[find(a.segment)] = find(b.segment);
    const std::size_t main = mainSegment();
    std::map<std::size_t, int> numbers;
    if (main != kNone) numbers[find(main)] = 0;
    int next = main != kNone ? 1 : 0;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const auto [it, fresh] = numbers.try_emplace(find(s), next);
      next += fresh;
      component_.push_back(it->second);
    }
    sizes_.assign(static_cast<std::size_t>(next), 0);
    located_.assign(static_cast<std::size_t>(next), false);
    held_.assign(static_cast<std::size_t>(next), kNone);
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const auto c = static_cast<std::size_t>(component_[s]);
      ++sizes_[c];
      located_[c] = located_[c] || segments_[s].segment.georeferenced;
    }
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const auto c = static_cast<std::size_t>(component_[s]);
      if (!located_[c] && larger(s, held_[c])) held_[c] = s;
    }
    if (main != kNone && segments_[main].segment.georeferenced) held_[0] = main;
  }

  /// The central UAV's largest segment, if possible a georeferenced one.
  std::size_t mainSegment() const {
    std::size_t main = kNone;
    for (const bool georeferenced : {true, false}) {
      for (std::size_t s = 0; s < segments_.size(); ++s) {
        const GeoSegment& g = segments_[s].segment;
        const bool fits = g.id.uav == central_uav_ && g.georeferenced == georeferenced;
        if (fits && larger(s, main)) main = s;
      }
      if (main != kNone) break;
    }
    return main;
  }

  bool larger(std::size_t s, std::size_t than) const {
    return than == kNone ||
           segments_[s].segment.poses.size() > segments_[than].segment.poses.size();
  }
  bool connected(std::size_t s) const {
    return sizes_[static_cast<std::size_t>(component_[s])] > 1;
  }
  bool held(std::size_t s) const { return held_[static_cast<std::size_t>(component_[s])] == s; }

  Eigen::Isometry3d poseOf(Place p) const {
    return base_[p.segment].carry(segments_[p.segment].segment.poses[p.pose].T_world_cam);
  }

  /// The lengths of an observation were measured before a segment got its first placing.
  RelativePoseResidual residual(std::size_t k) const {
    const auto& [a, b] = ends_[k];
    RelativePoseResidual r(observations_[k], poseOf(a), poseOf(b), blocks_[a.segment].pivot,
                           blocks_[b.segment].pivot);
    r.length_a_m *= base_[a.segment].scale;
    r.weight_a /= base_[a.segment].scale;
    r.length_b_m *= base_[b.segment].scale;
    r.weight_b /= base_[b.segment].scale;
    // Where neither segment knew metres, the rest of the observation is in units of a as well.
    if (!segments_[a.segment].segment.georeferenced &&
        !segments_[b.segment].segment.georeferenced) {
      r.weight_across /= base_[a.segment].scale;
    }
    return r;
  }

  std::pair<double, double> discrepancy(std::size_t k) const {
    return residual(k).discrepancy(blocks_[ends_[k].first.segment].v,
                                   blocks_[ends_[k].second.segment].v);
  }

  double whitened2(std::size_t k) const {
    double r[RelativePoseResidual::kSize];
    residual(k)(blocks_[ends_[k].first.segment].v, blocks_[ends_[k].second.segment].v, r);
    return std::inner_product(r, r + RelativePoseResidual::kSize, r, 0.0);
  }

  /// The place of segment `s` that observation k gives it, the other end being placed.
  std::optional<Sim3> placing(std::size_t k, std::size_t s) const {
    const PairObservation& o = observations_[k];
    const bool new_is_b = ends_[k].second.segment == s;
    const Place known = new_is_b ? ends_[k].first : ends_[k].second;
    const Place fresh = new_is_b ? ends_[k].second : ends_[k].first;
    const DepthLength& by_known = new_is_b ? o.by_depth_a : o.by_depth_b;
    const DepthLength& by_fresh = new_is_b ? o.by_depth_b : o.by_depth_a;
    if (by_known.sigma_m <= 0 || by_fresh.sigma_m <= 0 || by_fresh.length_m <= 0) {
      return std::nullopt;
    }
    Eigen::Isometry3d T_a_b = o.pose.T_a_b;
    const double known_scale = base_[known.segment].scale;
    T_a_b.translation() = known_scale * by_known.length_m * o.direction_a;
    const Eigen::Isometry3d T_world_fresh = poseOf(known) * (new_is_b ? T_a_b : T_a_b.inverse());
    const Eigen::Isometry3d& before = segments_[s].segment.poses[fresh.pose].T_world_cam;
    Sim3 S;
    S.scale = known_scale * by_known.length_m / by_fresh.length_m;
    S.rotation = T_world_fresh.linear() * before.linear().transpose();
    S.translation = T_world_fresh.translation() - S.scale * (S.rotation * before.translation());
    return S;
  }

  /// Segments without georeference take the place on which their observations agree best.
  void placeUnlocated() {
    std::vector<char> placed(segments_.size());
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      placed[s] = segments_[s].segment.georeferenced || held(s);
    }
    for (bool progress = true; progress;) {
      progress = false;
      for (std::size_t s = 0; s < segments_.size(); ++s) {
        if (placed[s]) continue;
        std::vector<std::size_t> links;
        for (std::size_t k = 0; k < ends_.size(); ++k) {
          const std::size_t a = ends_[k].first.segment, b = ends_[k].second.segment;
          if ((a == s && placed[b]) || (b == s && placed[a])) links.push_back(k);
        }
        double best_cost = std::numeric_limits<double>::infinity();
        Sim3 best;
        for (const std::size_t k : links) {
          const auto candidate = placing(k, s);
          if (!candidate) continue;
          base_[s] = *candidate;
          double cost = 0;
          for (const std::size_t other : links) cost += std::log1p(whitened2(other));
          if (cost < best_cost) {
            best_cost = cost;
            best = *candidate;
            placed[s] = progress = true;
          }
        }
        base_[s] = best;
      }
    }
  }

  void setPivots() {
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const auto& poses = segments_[s].segment.poses;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < poses.size(); ++i) sum += poseOf({s, i}).translation();
      if (!poses.empty()) blocks_[s].pivot = sum / static_cast<double>(poses.size());
    }
  }

  void addPriors(ceres::Problem& problem) {
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      const SegmentInput& input = segments_[s];
      if (!connected(s) || !input.segment.georeferenced) continue;
      const double angle = options_.rotation_prior_deg * M_PI / 180;
      Eigen::Matrix<double, 7, 7> weight = Eigen::Matrix<double, 7, 7>::Zero();
      weight.diagonal() << 1 / angle, 1 / angle, 1 / angle, 0, 0, 0, 1 / options_.scale_prior;
      problem.AddResidualBlock(new ceres::NormalPrior(weight, Eigen::Matrix<double, 7, 1>::Zero()),
                               nullptr, blocks_[s].v);
      const std::uint16_t uav = input.segment.id.uav;
      for (std::size_t i = 0; i < input.fixes.size(); ++i) {
        if (!input.fixes[i]) continue;
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<FixResidual, 3, 7, 3>(
                new FixResidual{poseOf({s, i}).translation() - blocks_[s].pivot, blocks_[s].pivot,
                                input.fixes[i]->position_m, input.fixes[i]->sigma_m}),
            new ceres::CauchyLoss(options_.loss), blocks_[s].v,
            bias_.try_emplace(uav).first->second.data());
      }
    }
    for (auto& [uav, bias] : bias_) {
      const Eigen::Vector3d information(1 / options_.bias_horizontal_m,
                                        1 / options_.bias_horizontal_m,
                                        1 / options_.bias_vertical_m);
      problem.AddResidualBlock(
          new ceres::NormalPrior(information.asDiagonal().toDenseMatrix(), Eigen::Vector3d::Zero()),
          nullptr, bias.data());
      if (uav == central_uav_) problem.SetParameterBlockConstant(bias.data());
    }
  }

  void run(double loss) {
    ceres::Problem problem;
    for (std::size_t k = 0; k < observations_.size(); ++k) {
      if (within(k)) continue;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RelativePoseResidual, RelativePoseResidual::kSize, 7, 7>(
              new RelativePoseResidual(residual(k))),
          new ceres::CauchyLoss(loss), blocks_[ends_[k].first.segment].v,
          blocks_[ends_[k].second.segment].v);
    }
    if (problem.NumResidualBlocks() == 0) return;
    addPriors(problem);
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      if (connected(s) && held(s)) problem.SetParameterBlockConstant(blocks_[s].v);
    }
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = 100;
    solver.function_tolerance = 1e-12;
    solver.num_threads = 1;  // the same sums in the same order
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
  }

  const std::vector<SegmentInput>& segments_;
  const std::vector<PairObservation>& observations_;
  std::uint16_t central_uav_;
  RelativePoseOptions options_;
  std::vector<std::pair<Place, Place>> ends_;  ///< per observation
  std::vector<int> component_;                 ///< per segment
  std::vector<int> sizes_;                     ///< per component: segments
  std::vector<char> located_;                  ///< per component: any georeferenced
  std::vector<std::size_t> held_;              ///< per component: the segment that stays, or none
  std::vector<Sim3> base_;  ///< first placing; identity for what is georeferenced
  std::vector<CorrectionBlock> blocks_;
  std::map<std::uint16_t, std::array<double, 3>> bias_;
};

}  // namespace

void RelativePoseOptions::visit(OptionVisitor& v) {
  v.number("rotation_prior_deg", rotation_prior_deg, {1e-3, 180},
           "standard deviation of a georeferenced segment's attitude [deg]");
  v.number("scale_prior", scale_prior, {1e-4, 10},
           "relative standard deviation of a georeferenced segment's scale, its fixes apart");
  v.number("relative_pose_loss", loss, {0.1, 1000},
           "residual in sigmas at which a relative pose loses weight");
}

RelativePoseSolution optimiseRelativePoses(const std::vector<SegmentInput>& segments,
                                           const std::vector<PairObservation>& observations,
                                           std::uint16_t central_uav,
                                           const RelativePoseOptions& options) {
  return Optimisation(segments, observations, central_uav, options).solve();
}

}  // namespace cf
