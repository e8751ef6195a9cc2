// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/joint_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "joint_residuals.h"
#include "link_alignment.h"
#include "observation_noise.h"
#include "point_choice.h"
#include "pose_covariance.h"
#include "posterior.h"
#include "track_parts.h"
#include "track_triangulation.h"

namespace cf {
namespace {

constexpr int kDraftShare = 3;  ///< a draft adjusts one point of so many
constexpr double kTangentialSigma = 0.002;
constexpr double kCentreDeviation = 0.25;       ///< between UAVs, of the prior's sigma
constexpr double kDistortionDeviation = 0.005;  ///< of k1 and k2 between UAVs
constexpr double kTangentialDeviation = 0.0005;
constexpr int kDraws = 500;            ///< of the errors of a map: 3 % in a standard deviation
constexpr double kBiasOverNoise = 10;  ///< a receiver's bias is no more than this times its noise
/// Prior of the poses given, all photos of a component together: enough for what nothing else
/// observes, nothing against what does.
constexpr double kGivenRotationSigma = 0.05;  ///< [rad]
constexpr double kGivenPositionSigma = 0.2;   ///< of the median depth
constexpr double kFinalPx = 2;                ///< threshold of the points that are told

/// From coarse to fine: what was thrown out while the poses were rough gets its chance again.
struct Round {
  double threshold_px, loss_sigmas;
  bool fine;  ///< observations weigh what their residuals are worth, chains of features join in
};
const std::vector<Round> kRounds = {{30, 6, false}, {8, 3, false}, {3, 3, true}, {3, 3, true}};
const std::vector<Round> kDraftRounds = {{30, 6, false}, {8, 3, false}};

void addPrior(ceres::Problem& problem, double* block, const std::vector<double>& mean,
              const std::vector<double>& sigma, ceres::LossFunction* loss = nullptr) {
  std::vector<double> inverse;
  for (const double value : sigma) inverse.push_back(1 / value);
  auto* cost = new ceres::DynamicAutoDiffCostFunction<VectorPrior>(new VectorPrior{mean, inverse});
  cost->AddParameterBlock(static_cast<int>(mean.size()));
  cost->SetNumResiduals(static_cast<int>(mean.size()));
  problem.AddResidualBlock(cost, loss, block);
}

/// The state that the rounds of the adjustment improve.
class Adjustment {
 public:
  Adjustment(const MatchGraph& graph, const std::vector<Track>& tracks, const JointProblem& problem,
             const JointOptions& options)
      : graph_(graph),
        tracks_(tracks),
        parts_(takeApart(graph, tracks)),
        problem_(problem),
        options_(options),
        noise_(options.feature_sigma_px, options.common_error_reach) {
    for (const JointPhoto& photo : problem.photos)
      pose_blocks_.push_back(poseBlockOf(photo.T_world_cam));
    for (std::size_t i = 0; i < pose_blocks_.size(); ++i)
      poses_[problem.photos[i].id] = &pose_blocks_[i];
    for (std::size_t u = 0; u < problem.cameras.size(); ++u) {
      const Lens given = lensOf(problem.cameras[u]);
      lenses_.push_back(given);
      const auto [first, is_new] = first_with_.try_emplace(given, u);
      lens_of_.push_back(options.camera == "shared" ? first->second : u);
    }
  }

  void improve(const Round& round, bool last) {
    const std::map<FrameId, PosedPhoto> photos = posed();
    const auto triangulated = [&](const MatchGraph& graph, const std::vector<Track>& tracks) {
      return Sights{&graph, triangulateTracks(graph, tracks, photos, round.threshold_px)};
    };
    const int wanted = options_.points_per_photo / (problem_.draft ? kDraftShare : 1);
    const auto chosen = [&](Sights sights) {
      sights.points = choosePoints(*sights.graph, sights.points, wanted);
      return sights;
    };
    Sights links = chosen(triangulated(graph_, parts_.links));
    if (!round.fine) return solve({}, {}, links, round.loss_sigmas, last);
    if (problem_.source && aligned_links_.tracks.empty()) {
      aligned_links_ = alignLinks(graph_, links.points, photos, problem_.source);
      links.points = aligned_links_.left;
      parts_.links.clear();
      for (const SparsePoint& link : links.points) parts_.links.push_back(link.observations);
    }
    const Sights chains = triangulated(graph_, parts_.chains);
    const Sights aligned_links = triangulated(aligned_links_.graph, aligned_links_.tracks);
    noise_.measure(triangulated(graph_, parts_.detections), aligned_links, chains, photos, last);
    solve(chosen(chains), aligned_links, links, round.loss_sigmas, last);
  }

  JointSolution solution() const {
    JointSolution out;
    for (const auto& [id, block] : poses_) out.T_world_cam[id] = poseOf(*block);
    out.covariance = pose_covariances_;
    for (std::size_t u = 0; u < lenses_.size(); ++u) {
      out.cameras.push_back(withLens(problem_.cameras[u], lenses_[lens_of_[u]]));
      const auto sigma = lens_sigmas_.find(lens_of_[u]);
      if (sigma == lens_sigmas_.end()) continue;
      CameraModel& camera = out.cameras.back();
      camera.focal_sigma = sigma->second[0] * camera.width;
      camera.k1_sigma = sigma->second[1];
      camera.k2_sigma = sigma->second[2];
    }
    for (const auto& [uav, bias] : biases_)
      out.bias_m[uav] = Eigen::Vector3d(bias[0], bias[1], bias[2]);
    out.points = triangulateTracks(graph_, tracks_, posed(), kFinalPx);
    out.reprojection_rms_px = reprojectionRmsPx(graph_, out.points, posed());
    return out;
  }

 private:
  using PointBlocks = std::vector<std::array<double, 3>>;

  void solve(const Sights& chains, const Sights& aligned_links, const Sights& links,
             double loss_sigmas, bool last) {
    PointBlocks points;
    for (const Sights* sights : {&chains, &aligned_links, &links})
      for (const SparsePoint& p : sights->points)
        points.push_back({p.position_m.x(), p.position_m.y(), p.position_m.z()});
    if (points.empty()) return;
    ceres::Problem problem;
    auto* loss = new ceres::ScaledLoss(new ceres::CauchyLoss(loss_sigmas), 1 / noise_.deflation(),
                                       ceres::TAKE_OWNERSHIP);
    auto point = points.begin();
    const auto observe = [&](const Sights& sights, const auto& sigmaOf) {
      for (const SparsePoint& p : sights.points) {
        for (const SparseObservation& o : p.observations)
          addObservation(problem, sights.graph->photo(o.frame), o.feature, point->data(),
                         sigmaOf(p, o), loss);
        ++point;
      }
    };
    observe(chains, [&](const auto&, const auto&) { return noise_.chained(); });
    observe(aligned_links, [&](const auto&, const auto&) { return noise_.linked(); });
    observe(links, [&](const SparsePoint& p, const SparseObservation& o) {
      return noise_.detection(*graph_.photo(o.frame).features, o.feature) *
             std::sqrt(sharedDetection(graph_, p.observations, o));
    });
    addPosePriors(problem);
    addLensPriors(problem);
    hold(problem);

    ceres::Solver::Options solver;
    solver.linear_solver_type = poses_.size() < 100 ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    solver.linear_solver_ordering = orderOf(problem, points);
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = 1e-4;
    // One thread: sums of residuals keep one order, so the result is the same bytes every time.
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    if (last) keepCovariances(problem, points);
  }

  void addObservation(ceres::Problem& problem, const Keyframe& photo, int feature, double* point,
                      double sigma_px, ceres::LossFunction* loss) {
    problem.AddResidualBlock(
        new ReprojectionError(
            photo.features->pixel[static_cast<std::size_t>(feature)].cast<double>(), photo.camera,
            sigma_px * photo.features->pixel_size),
        loss, poses_.at(photo.id)->data(), point, lensBlock(photo.id.uav));
  }

  double* lensBlock(std::size_t uav) { return lenses_[lens_of_[uav]].data(); }

  /// Within a group Ceres orders by address, which differs from run to run: points and poses lie in
  /// one array each, and what lies elsewhere gets groups of its own.
  std::shared_ptr<ceres::ParameterBlockOrdering> orderOf(ceres::Problem& problem,
                                                         PointBlocks& points) {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& point : points) ordering->AddElementToGroup(point.data(), 0);
    for (PoseBlock& pose : pose_blocks_) {
      problem.SetManifold(
          pose.data(),
          new ceres::ProductManifold<ceres::QuaternionManifold, ceres::EuclideanManifold<3>>());
      ordering->AddElementToGroup(pose.data(), 1);
    }
    int group = 2;
    for (double* block : otherBlocks(problem)) ordering->AddElementToGroup(block, group++);
    return ordering;
  }

  /// Lenses that are used, the lenses that their groups share, biases.
  std::vector<double*> otherBlocks(const ceres::Problem& problem) {
    std::vector<double*> blocks;
    for (Lens& lens : lenses_)
      if (problem.HasParameterBlock(lens.data())) blocks.push_back(lens.data());
    for (auto& [given, lens] : groups_) blocks.push_back(lens.data());
    for (auto& [uav, bias] : biases_) blocks.push_back(bias.data());
    return blocks;
  }

  void keepCovariances(ceres::Problem& problem, PointBlocks& points) {
    std::vector<double*> eliminated, kept;
    for (auto& point : points) eliminated.push_back(point.data());
    for (PoseBlock& pose : pose_blocks_) kept.push_back(pose.data());
    for (double* block : otherBlocks(problem)) kept.push_back(block);
    // The weights are deflated, the noise of the observations is not.
    const std::vector<Eigen::MatrixXd> errors =
        drawErrors(problem, eliminated, kept, 1 / noise_.deflation(), kDraws);
    if (errors.front().size() == 0) return;
    keepPoseCovariances(errors);
    std::size_t next = pose_blocks_.size();
    for (std::size_t u = 0; u < lenses_.size(); ++u) {
      if (!problem.HasParameterBlock(lenses_[u].data())) continue;
      const Eigen::MatrixXd& e = errors[next++];
      const std::vector<int> held = heldOf(u);
      Lens& sigma = lens_sigmas_[u];
      sigma.fill(0);
      for (int k = 0, row = 0; k < kLens && e.rows() > 0; ++k)
        if (std::find(held.begin(), held.end(), k) == held.end())
          sigma[static_cast<std::size_t>(k)] = std::sqrt(e.row(row++).squaredNorm() / kDraws);
    }
  }

  void keepPoseCovariances(const std::vector<Eigen::MatrixXd>& errors) {
    std::vector<ErrorDraws> of_poses;
    std::vector<Eigen::Vector3d> centres;
    for (std::size_t i = 0; i < pose_blocks_.size(); ++i) {
      // Ceres' tangent of a quaternion is half a rotation vector, and comes first.
      ErrorDraws e(6, kDraws);
      e << errors[i].bottomRows<3>(), 2 * errors[i].topRows<3>();
      of_poses.push_back(std::move(e));
      centres.push_back(poseOf(pose_blocks_[i]).translation());
    }
    const std::vector<ErrorDraws> in_map = withoutSimilarity(of_poses, centres);
    for (std::size_t i = 0; i < pose_blocks_.size(); ++i)
      pose_covariances_[problem_.photos[i].id] = {covarianceOf(of_poses[i]),
                                                  covarianceOf(in_map[i])};
  }

  std::map<FrameId, PosedPhoto> posed() const {
    std::map<FrameId, PosedPhoto> photos;
    for (const auto& [id, block] : poses_)
      photos[id] = {poseOf(*block), withLens(graph_.photo(id).camera, lenses_[lens_of_[id.uav]])};
    return photos;
  }

  void addPosePriors(ceres::Problem& problem) {
    const auto free = std::count_if(problem_.photos.begin(), problem_.photos.end(),
                                    [](const JointPhoto& photo) { return !photo.held; });
    const double n = std::sqrt(static_cast<double>(free));
    std::map<std::uint16_t, Eigen::Vector3d> noise;  // of the worst fix of each UAV
    const double rotation_sigma = kGivenRotationSigma * n;
    const double position_sigma_m = kGivenPositionSigma * problem_.median_depth_m * n;
    for (const JointPhoto& photo : problem_.photos) {
      PoseBlock& pose = *poses_.at(photo.id);
      if (photo.held) {
        problem.AddParameterBlock(pose.data(), kPose);  // it may see no point
        continue;
      }
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PosePrior, 6, kPose>(new PosePrior{
              Eigen::Quaterniond(photo.T_world_cam.linear()), photo.T_world_cam.translation(),
              1 / rotation_sigma, 1 / position_sigma_m}),
          nullptr, pose.data());
      if (!photo.fix) continue;
      auto& bias = biases_[photo.id.uav];
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<GnssError, 3, kPose, 3>(
              new GnssError{photo.fix->position_m, photo.fix->sigma_m.cwiseInverse()}),
          new ceres::HuberLoss(2), pose.data(), bias.data());
      auto& worst = noise.try_emplace(photo.id.uav, Eigen::Vector3d::Zero()).first->second;
      worst = worst.cwiseMax(photo.fix->sigma_m);
    }
    const double h = options_.bias_sigma_horizontal_m, v = options_.bias_sigma_vertical_m;
    // Robust: a receiver that is tens of metres off must not drag the others' map along.
    for (auto& [uav, bias] : biases_) {
      const Eigen::Vector3d limit = kBiasOverNoise * noise.at(uav);
      addPrior(problem, bias.data(), {0, 0, 0},
               {std::min(h, limit.x()), std::min(h, limit.y()), std::min(v, limit.z())},
               new ceres::HuberLoss(1));
    }
  }

  /// Each lens is near the mean of the UAVs that were given the same camera, and that is near what
  /// was given.
  void addLensPriors(ceres::Problem& problem) {
    groups_.clear();
    for (std::size_t u = 0; u < lenses_.size(); ++u) {
      if (!problem.HasParameterBlock(lenses_[u].data())) continue;
      const Lens given = lensOf(problem_.cameras[u]);
      const CameraModel& c = problem_.cameras[u];
      auto [group, is_new] = groups_.try_emplace(given, lenses_[u]);
      if (is_new)
        addPrior(problem, group->second.data(), {given.begin(), given.end()},
                 {std::max(1e-6, c.focal_sigma / c.width), std::max(1e-6, c.k1_sigma),
                  std::max(1e-6, c.k2_sigma), kTangentialSigma, kTangentialSigma,
                  options_.principal_point_sigma, options_.principal_point_sigma});
      const double f = 1 / (options_.focal_deviation * given[0]);
      const double k = 1 / kDistortionDeviation, p = 1 / kTangentialDeviation;
      const double centre = 1 / (kCentreDeviation * options_.principal_point_sigma);
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<DifferencePrior, kLens, kLens, kLens>(
              new DifferencePrior{{f, k, k, p, p, centre, centre}}),
          nullptr, lenses_[u].data(), group->second.data());
    }
  }

  /// What is given without a sigma stays as given. Tangential distortion and principal point have
  /// none of their own: they stay where the whole calibration does.
  std::vector<int> heldOf(std::size_t uav) const {
    const CameraModel& c = problem_.cameras[uav];
    std::vector<int> held;
    if (!(c.focal_sigma > 0)) held.push_back(0);
    if (!(c.k1_sigma > 0)) held.push_back(1);
    if (!(c.k2_sigma > 0)) held.push_back(2);
    if (held.size() == 3 || !options_.refine_cameras || problem_.cameras_held)
      held = {0, 1, 2, 3, 4, 5, 6};
    return held;
  }

  void hold(ceres::Problem& problem) {
    for (std::size_t uav = 0; uav < lenses_.size(); ++uav) {
      if (!problem.HasParameterBlock(lenses_[uav].data())) continue;
      const std::vector<int> held = heldOf(uav);
      if (held.size() == kLens)
        problem.SetParameterBlockConstant(lenses_[uav].data());
      else if (!held.empty())
        problem.SetManifold(lenses_[uav].data(), new ceres::SubsetManifold(kLens, held));
    }
    for (const JointPhoto& photo : problem_.photos)
      if (photo.held) problem.SetParameterBlockConstant(poses_.at(photo.id)->data());
  }

  const MatchGraph& graph_;
  const std::vector<Track>& tracks_;
  TrackParts parts_;
  AlignedLinks aligned_links_;
  const JointProblem& problem_;
  const JointOptions& options_;
  NoiseModel noise_;
  std::vector<PoseBlock> pose_blocks_;
  std::map<FrameId, PoseBlock*> poses_;     ///< into pose_blocks_
  std::vector<Lens> lenses_;                ///< by UAV
  std::vector<std::size_t> lens_of_;        ///< the UAV whose lens a UAV uses
  std::map<Lens, std::size_t> first_with_;  ///< the first UAV that was given a lens
  std::map<Lens, Lens> groups_;             ///< by the lens given
  std::map<std::uint16_t, std::array<double, 3>> biases_;
  std::map<FrameId, PoseCovariance> pose_covariances_;
  std::map<std::size_t, Lens> lens_sigmas_;  ///< by UAV
};

}  // namespace

void JointOptions::visit(OptionVisitor& v) {
  v.integer("points_per_photo", points_per_photo, {36, 5000}, "points adjusted per photo");
  v.number("feature_sigma_px", feature_sigma_px, {0.1, 10},
           "of a feature until it is measured, at the feature size [px]");
  v.number("common_error_reach", common_error_reach, {0, 1e6},
           "observations that the error which a photo's features have in common counts for");
  v.number("principal_point_sigma", principal_point_sigma, {1e-6, 0.1},
           "prior, as a fraction of the photo's width");
  v.number("focal_deviation", focal_deviation, {1e-6, 0.2},
           "relative, between UAVs with the same camera model");
  v.number("bias_sigma_horizontal_m", bias_sigma_horizontal_m, {0.001, 1000},
           "prior of a UAV's GNSS bias [m]");
  v.number("bias_sigma_vertical_m", bias_sigma_vertical_m, {0.001, 1000},
           "prior of a UAV's GNSS bias [m]");
  v.choice("camera", camera, {"per_uav", "shared"},
           "UAVs with the same camera model: a lens each, near one another, or one for all");
  v.flag("refine_cameras", refine_cameras, "focal length and distortion of each UAV");
  v.integer("max_iterations", max_iterations, {1, 500}, "of each round");
}

JointSolution adjustJointly(const MatchGraph& graph, const std::vector<Track>& tracks,
                            const JointProblem& problem, const JointOptions& options) {
  Adjustment adjustment(graph, tracks, problem, options);
  const std::vector<Round>& rounds = problem.draft ? kDraftRounds : kRounds;
  for (const Round& round : rounds)
    adjustment.improve(round, !problem.draft && &round == &rounds.back());
  return adjustment.solution();
}

}  // namespace cf
