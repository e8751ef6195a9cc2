// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/joint_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "observation_noise.h"
#include "track_triangulation.h"

namespace cf {
namespace {

/// Lens of one UAV in units that do not depend on the photo's size: focal length over width, k1,
/// k2, p1, p2, and the principal point from the photo's left and top edge over width.
constexpr int kLens = 7;
using Lens = std::array<double, kLens>;

Lens lensOf(const CameraModel& c) {
  return {c.fx / c.width, c.k1, c.k2, c.p1, c.p2, (c.cx + 0.5) / c.width, (c.cy + 0.5) / c.width};
}

CameraModel withLens(CameraModel camera, const Lens& lens) {
  const double aspect = camera.fy / camera.fx;
  camera.fx = lens[0] * camera.width;
  camera.fy = aspect * camera.fx;
  camera.k1 = lens[1];
  camera.k2 = lens[2];
  camera.p1 = lens[3];
  camera.p2 = lens[4];
  camera.cx = lens[5] * camera.width - 0.5;
  camera.cy = lens[6] * camera.width - 0.5;
  return camera;
}

/// T_world_cam: quaternion w x y z, then translation. One block: Ceres' Schur complement has a
/// quarter of the cells that two would give it.
constexpr int kPose = 7;
using PoseBlock = std::array<double, kPose>;

/// Distorted pixel of a world point minus where it was seen, in sigmas.
struct ReprojectionError {
  Eigen::Vector2d pixel_from_corner;  ///< not from the first pixel's centre
  double width, aspect, k3, inverse_sigma;

  template <class T>
  bool operator()(const T* pose, const T* point, const T* lens, T* residual) const {
    const T *q = pose, *t = pose + 4;
    const T d[3] = {point[0] - t[0], point[1] - t[1], point[2] - t[2]};
    const T inverse[4] = {q[0], -q[1], -q[2], -q[3]};
    T c[3];
    ceres::QuaternionRotatePoint(inverse, d, c);
    if (c[2] < T(1e-6)) return false;
    const T x = c[0] / c[2], y = c[1] / c[2], r2 = x * x + y * y;
    const T radial = T(1) + r2 * (lens[1] + r2 * (lens[2] + r2 * T(k3)));
    const T xd = x * radial + T(2) * lens[3] * x * y + lens[4] * (r2 + T(2) * x * x);
    const T yd = y * radial + lens[3] * (r2 + T(2) * y * y) + T(2) * lens[4] * x * y;
    const T f = lens[0] * T(width);
    residual[0] = T(inverse_sigma) * (f * xd + lens[5] * T(width) - T(pixel_from_corner.x()));
    residual[1] =
        T(inverse_sigma) * (f * T(aspect) * yd + lens[6] * T(width) - T(pixel_from_corner.y()));
    return true;
  }
};

/// Fix minus (camera centre + bias of its UAV), in sigmas.
struct GnssError {
  Eigen::Vector3d fix, inverse_sigma;
  template <class T>
  bool operator()(const T* pose, const T* bias, T* residual) const {
    for (int i = 0; i < 3; ++i)
      residual[i] = T(inverse_sigma[i]) * (T(fix[i]) - pose[4 + i] - bias[i]);
    return true;
  }
};

struct VectorPrior {
  std::vector<double> mean, inverse_sigma;
  template <class T>
  bool operator()(T const* const* x, T* residual) const {
    for (std::size_t i = 0; i < mean.size(); ++i)
      residual[i] = T(inverse_sigma[i]) * (x[0][i] - T(mean[i]));
    return true;
  }
};

struct DifferencePrior {
  Lens inverse_sigma;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    for (int i = 0; i < kLens; ++i)
      residual[i] = T(inverse_sigma[static_cast<std::size_t>(i)]) * (a[i] - b[i]);
    return true;
  }
};

/// Rotation [rad] and translation [m] against the pose given.
struct PosePrior {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
  double inverse_rotation_sigma, inverse_translation_sigma;
  template <class T>
  bool operator()(const T* pose, T* residual) const {
    const T m[4] = {T(rotation.w()), T(-rotation.x()), T(-rotation.y()), T(-rotation.z())};
    T d[4];
    ceres::QuaternionProduct(m, pose, d);
    const T sign = d[0] < T(0) ? T(-2) : T(2);
    for (int i = 0; i < 3; ++i) {
      residual[i] = T(inverse_rotation_sigma) * sign * d[i + 1];
      residual[3 + i] = T(inverse_translation_sigma) * (pose[4 + i] - T(translation[i]));
    }
    return true;
  }
};

void addPrior(ceres::Problem& problem, double* block, const std::vector<double>& mean,
              const std::vector<double>& sigma) {
  std::vector<double> inverse;
  for (const double value : sigma) inverse.push_back(1 / value);
  auto* cost = new ceres::DynamicAutoDiffCostFunction<VectorPrior>(new VectorPrior{mean, inverse});
  cost->AddParameterBlock(static_cast<int>(mean.size()));
  cost->SetNumResiduals(static_cast<int>(mean.size()));
  problem.AddResidualBlock(cost, nullptr, block);
}

/// The state that the rounds of the adjustment improve.
class Adjustment {
 public:
  Adjustment(const MatchGraph& graph, const std::vector<Track>& tracks, const JointProblem& problem,
             const JointOptions& options)
      : graph_(graph),
        tracks_(tracks),
        problem_(problem),
        options_(options),
        noise_{options.feature_sigma_px, 0} {
    for (const JointPhoto& photo : problem.photos) {
      const Eigen::Quaterniond q(photo.T_world_cam.linear());
      const Eigen::Vector3d t = photo.T_world_cam.translation();
      pose_blocks_.push_back({q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
    }
    for (std::size_t i = 0; i < pose_blocks_.size(); ++i)
      poses_[problem.photos[i].id] = &pose_blocks_[i];
    for (const CameraModel& camera : problem.cameras) lenses_.push_back(lensOf(camera));
  }

  /// Triangulates every track with the state as it is.
  std::vector<SparsePoint> triangulateAll(double threshold_px) const {
    return triangulateTracks(graph_, tracks_, posed(), threshold_px);
  }

  void solve(const std::vector<SparsePoint>& all, double loss_sigmas) {
    const std::vector<SparsePoint> points = choose(all);
    std::vector<std::array<double, 3>> blocks;
    for (const SparsePoint& p : points)
      blocks.push_back({p.position_m.x(), p.position_m.y(), p.position_m.z()});
    ceres::Problem ceres_problem;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    ceres::LossFunction* loss = new ceres::ScaledLoss(
        new ceres::CauchyLoss(loss_sigmas),
        1 / (1 + options_.common_error_reach * noise_.common_share), ceres::TAKE_OWNERSHIP);
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (const auto& o : points[i].observations) {
        const Keyframe& photo = graph_.photo(o.frame);
        const CameraModel& c = photo.camera;
        const double sigma = noise_.sigma_px * photo.features->pixel_size;
        const Eigen::Vector2d pixel =
            photo.features->pixel[static_cast<std::size_t>(o.feature)].cast<double>();
        PoseBlock& pose = *poses_.at(o.frame);
        ceres_problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<ReprojectionError, 2, kPose, 3, kLens>(
                new ReprojectionError{pixel + Eigen::Vector2d(0.5, 0.5),
                                      static_cast<double>(c.width), c.fy / c.fx, c.k3, 1 / sigma}),
            loss, pose.data(), blocks[i].data(), lenses_[o.frame.uav].data());
      }
      ordering->AddElementToGroup(blocks[i].data(), 0);
    }
    if (points.empty()) {
      delete loss;
      return;
    }
    addPosePriors(ceres_problem);
    addLensPriors(ceres_problem);
    // Within a group Ceres orders by address, which differs from run to run: the poses lie in one
    // array, and what lies elsewhere gets groups of its own.
    for (PoseBlock& pose : pose_blocks_) {
      ceres_problem.SetManifold(
          pose.data(),
          new ceres::ProductManifold<ceres::QuaternionManifold, ceres::EuclideanManifold<3>>());
      ordering->AddElementToGroup(pose.data(), 1);
    }
    int group = 2;
    const auto order_next = [&](double* block) {
      if (ceres_problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, group++);
    };
    for (Lens& lens : lenses_) order_next(lens.data());
    for (auto& [given, lens] : groups_) order_next(lens.data());
    for (auto& [uav, bias] : biases_) order_next(bias.data());
    for (std::size_t u = 0; u < lenses_.size(); ++u)
      if (ceres_problem.HasParameterBlock(lenses_[u].data())) hold(u, ceres_problem);
    ceres::Solver::Options solver;
    solver.linear_solver_type = poses_.size() < 100 ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    solver.linear_solver_ordering = ordering;
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = 1e-4;
    // One thread: sums of residuals keep one order, so the result is the same bytes every time.
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &ceres_problem, &summary);
  }

  /// From here on observations weigh what their residuals are worth.
  void weighByResiduals(const std::vector<SparsePoint>& points) {
    const ObservationNoise measured = measureNoise(graph_, points, posed());
    if (measured.sigma_px > 0)
      noise_ = {std::max(kLeastSigmaPx, measured.sigma_px), measured.common_share};
  }

  JointSolution solution(std::vector<SparsePoint> points) const {
    JointSolution out;
    for (const auto& [id, block] : poses_) out.T_world_cam[id] = poseOf(*block);
    for (std::size_t u = 0; u < lenses_.size(); ++u)
      out.cameras.push_back(withLens(problem_.cameras[u], lenses_[u]));
    for (const auto& [uav, bias] : biases_)
      out.bias_m[uav] = Eigen::Vector3d(bias[0], bias[1], bias[2]);
    out.reprojection_rms_px = reprojectionRmsPx(graph_, points, posed());
    out.points = std::move(points);
    return out;
  }

 private:
  static Eigen::Isometry3d poseOf(const PoseBlock& block) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() =
        Eigen::Quaterniond(block[0], block[1], block[2], block[3]).normalized().toRotationMatrix();
    T.translation() = Eigen::Vector3d(block[4], block[5], block[6]);
    return T;
  }

  std::map<FrameId, PosedPhoto> posed() const {
    std::map<FrameId, PosedPhoto> photos;
    for (const auto& [id, block] : poses_)
      photos[id] = {poseOf(*block), withLens(graph_.photo(id).camera, lenses_[id.uav])};
    return photos;
  }

  /// Points for the adjustment: the longest tracks first, those that cross UAVs before others,
  /// until the cells of a grid over each photo have their share.
  std::vector<SparsePoint> choose(const std::vector<SparsePoint>& all) const {
    constexpr int kGrid = 6;
    const int quota = std::max(1, options_.points_per_photo / (kGrid * kGrid));
    std::vector<std::size_t> order(all.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    const auto rank = [&](std::size_t i) {
      const auto& o = all[i].observations;
      const bool crosses = std::any_of(
          o.begin(), o.end(), [&](const auto& x) { return x.frame.uav != o.front().frame.uav; });
      return std::pair(crosses, o.size());
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
    std::map<FrameId, std::array<int, kGrid * kGrid>> used;
    for (const auto& [id, pose] : poses_) used[id].fill(0);
    std::vector<SparsePoint> chosen;
    for (const std::size_t i : order) {
      bool wanted = false;
      std::vector<int*> cells;
      for (const auto& o : all[i].observations) {
        const Keyframe& photo = graph_.photo(o.frame);
        const auto& pixel = photo.features->pixel[static_cast<std::size_t>(o.feature)];
        const int cx =
            std::clamp(static_cast<int>(pixel.x() * kGrid / static_cast<float>(photo.camera.width)),
                       0, kGrid - 1);
        const int cy = std::clamp(
            static_cast<int>(pixel.y() * kGrid / static_cast<float>(photo.camera.height)), 0,
            kGrid - 1);
        int& cell = used.at(o.frame)[static_cast<std::size_t>(cy * kGrid + cx)];
        wanted = wanted || cell < quota;
        cells.push_back(&cell);
      }
      if (!wanted) continue;
      for (int* cell : cells) ++*cell;
      chosen.push_back(all[i]);
    }
    return chosen;
  }

  void addPosePriors(ceres::Problem& problem) {
    const double n = std::sqrt(static_cast<double>(problem_.photos.size()));
    for (const JointPhoto& photo : problem_.photos) {
      PoseBlock& pose = *poses_.at(photo.id);
      // What is given counts once for the whole component, as one observation of 3 degrees and of
      // a fifth of the depth: enough for what nothing else observes, nothing against what does.
      const double arm = 0.2 * problem_.median_depth_m;
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PosePrior, 6, kPose>(new PosePrior{
                                   Eigen::Quaterniond(photo.T_world_cam.linear()),
                                   photo.T_world_cam.translation(), 1 / (0.05 * n), 1 / (arm * n)}),
                               nullptr, pose.data());
      if (!photo.fix) continue;
      auto& bias = biases_[photo.id.uav];
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<GnssError, 3, kPose, 3>(
              new GnssError{photo.fix->position_m, photo.fix->sigma_m.cwiseInverse()}),
          new ceres::HuberLoss(2), pose.data(), bias.data());
    }
    const double h = options_.bias_sigma_horizontal_m, v = options_.bias_sigma_vertical_m;
    for (auto& [uav, bias] : biases_) addPrior(problem, bias.data(), {0, 0, 0}, {h, h, v});
  }

  /// Each UAV's lens is near the mean of the UAVs that were given the same camera, and that is near
  /// what was given.
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
      const double centre = 1 / (kCentreDeviation * options_.principal_point_sigma);
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<DifferencePrior, kLens, kLens, kLens>(new DifferencePrior{
              {f, 1 / 0.005, 1 / 0.005, 1 / 0.0005, 1 / 0.0005, centre, centre}}),
          nullptr, lenses_[u].data(), group->second.data());
    }
  }

  /// What is given without a sigma stays as given. Tangential distortion and principal point have
  /// none of their own: they stay where the whole calibration does.
  void hold(std::size_t uav, ceres::Problem& problem) {
    const CameraModel& c = problem_.cameras[uav];
    std::vector<int> held;
    if (!(c.focal_sigma > 0)) held.push_back(0);
    if (!(c.k1_sigma > 0)) held.push_back(1);
    if (!(c.k2_sigma > 0)) held.push_back(2);
    if (held.size() == 3 || !options_.refine_cameras)
      problem.SetParameterBlockConstant(lenses_[uav].data());
    else if (!held.empty())
      problem.SetManifold(lenses_[uav].data(), new ceres::SubsetManifold(kLens, held));
  }

  static constexpr double kTangentialSigma = 0.002;
  static constexpr double kCentreDeviation = 0.25;  ///< between UAVs, of the prior's sigma
  static constexpr double kLeastSigmaPx = 0.1;

  const MatchGraph& graph_;
  const std::vector<Track>& tracks_;
  const JointProblem& problem_;
  const JointOptions& options_;
  ObservationNoise noise_;
  std::vector<PoseBlock> pose_blocks_;
  std::map<FrameId, PoseBlock*> poses_;  ///< into pose_blocks_
  std::vector<Lens> lenses_;
  std::map<Lens, Lens> groups_;  ///< by the lens given
  std::map<std::uint16_t, std::array<double, 3>> biases_;
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
  v.flag("refine_cameras", refine_cameras, "focal length and distortion of each UAV");
  v.integer("max_iterations", max_iterations, {1, 500}, "of each of the four rounds");
}

JointSolution adjustJointly(const MatchGraph& graph, const std::vector<Track>& tracks,
                            const JointProblem& problem, const JointOptions& options) {
  Adjustment adjustment(graph, tracks, problem, options);
  // From coarse to fine: what was thrown out while the poses were rough gets its chance again.
  struct Round {
    double threshold_px, loss_sigmas;
    bool weigh;
  };
  for (const Round round :
       {Round{30, 6, false}, Round{8, 3, false}, Round{3, 3, true}, Round{3, 3, true}}) {
    const std::vector<SparsePoint> points = adjustment.triangulateAll(round.threshold_px);
    if (round.weigh) adjustment.weighByResiduals(points);
    adjustment.solve(points, round.loss_sigmas);
  }
  return adjustment.solution(adjustment.triangulateAll(2));
}

}  // namespace cf
