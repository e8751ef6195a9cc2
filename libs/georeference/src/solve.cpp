// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/ceres.h>

#include <array>
#include <cmath>

#include "method.h"
#include "residuals.h"

namespace cf {
namespace {

constexpr int kIterations = 12;
constexpr double kHuberFix = 2.5;      ///< in sigmas
constexpr double kCauchyAttitude = 2;  ///< in sigmas
constexpr double kLooseYaw = M_PI;     ///< nothing known of the heading
constexpr double kLooseLogScale = 3;   ///< a factor of 20 either way

/// The parameters and residuals of one segment, linearised at its current estimate.
class Linearised {
 public:
  Linearised(const Segment& segment, const Noise& noise, const GeoreferenceMethod& method)
      : segment_(segment),
        method_(method),
        options_(method.options()),
        blocks_(segment.nodes.size()) {
    for (auto& block : blocks_) {
      block.fill(0);
      problem_.AddParameterBlock(block.data(), 6);
    }
    problem_.AddParameterBlock(&log_scale_, 1);
    for (std::size_t j = 1; j < blocks_.size(); ++j) addOdometry(j);
    for (std::size_t i = 0; i < blocks_.size(); ++i) addFix(i, noise);
    addAttitudes();
    addScaleHints();
    add<LooseResidual, 1, 6>({5, kLooseYaw}, nullptr, blocks_[0].data());
    add<LooseResidual, 1, 1>({0, kLooseLogScale}, nullptr, &log_scale_);
  }

  void minimise(std::size_t first_free) {
    for (std::size_t i = 0; i < first_free; ++i)
      problem_.SetParameterBlockConstant(blocks_[i].data());
    if (first_free > 0 || !method_.scaleIsState()) problem_.SetParameterBlockConstant(&log_scale_);
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = kIterations;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    usable_ = summary.IsSolutionUsable();
  }

  void apply(Segment& segment) const {
    if (!usable_) return;
    segment.scale *= std::exp(log_scale_);
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const LinearPose pose(segment.nodes[i].T_world_cam);
      segment.nodes[i].T_world_cam.linear() =
          pose.rotationAt(blocks_[i].data()).normalized().toRotationMatrix();
      segment.nodes[i].T_world_cam.translation() = pose.positionAt(blocks_[i].data());
    }
  }

  ChainInformation information() {
    const int n = static_cast<int>(blocks_.size());
    ceres::Problem::EvaluateOptions evaluate;
    for (auto& block : blocks_) evaluate.parameter_blocks.push_back(block.data());
    evaluate.parameter_blocks.push_back(&log_scale_);
    ceres::CRSMatrix jacobian;
    problem_.Evaluate(evaluate, nullptr, nullptr, nullptr, &jacobian);

    ChainInformation info;
    info.diagonal.assign(blocks_.size(), Matrix6d::Zero());
    info.upper.assign(blocks_.size() - 1, Matrix6d::Zero());
    info.border.assign(blocks_.size(), Eigen::Matrix<double, 6, 1>::Zero());
    const auto at = [](int k) { return static_cast<std::size_t>(k); };
    for (int row = 0; row < jacobian.num_rows; ++row) {
      const int end = jacobian.rows[at(row) + 1];
      for (int a = jacobian.rows[at(row)]; a < end; ++a)
        for (int b = jacobian.rows[at(row)]; b < end; ++b) {
          const int ca = jacobian.cols[at(a)], cb = jacobian.cols[at(b)];
          const double v = jacobian.values[at(a)] * jacobian.values[at(b)];
          if (ca == 6 * n && cb == 6 * n)
            info.corner += v;
          else if (cb == 6 * n)
            info.border[at(ca / 6)](ca % 6) += v;
          else if (ca < 6 * n && ca / 6 == cb / 6)
            info.diagonal[at(ca / 6)](ca % 6, cb % 6) += v;
          else if (ca < 6 * n && ca / 6 + 1 == cb / 6)
            info.upper[at(ca / 6)](ca % 6, cb % 6) += v;
        }
    }
    return info;
  }

 private:
  template <class Functor, int kResiduals, int... kBlocks, class... Pointers>
  void add(const Functor& functor, ceres::LossFunction* loss, Pointers... blocks) {
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Functor, kResiduals, kBlocks...>(new Functor(functor)),
        loss, blocks...);
  }

  void addOdometry(std::size_t j) {
    const Increment increment = method_.increment(segment_, j);
    add<OdometryResidual, 6, 6, 6, 1>(
        {LinearPose(segment_.nodes[j - 1].T_world_cam), LinearPose(segment_.nodes[j].T_world_cam),
         Eigen::Quaterniond(increment.T_i_j.linear()), increment.T_i_j.translation(),
         segment_.scale, increment.rotation_sigma_rad,
         segment_.scale * increment.translation_sigma},
        nullptr, blocks_[j - 1].data(), blocks_[j].data(), &log_scale_);
  }

  void addFix(std::size_t i, const Noise& noise) {
    const Node& node = segment_.nodes[i];
    if (!node.fix) return;
    const LinearPose pose(node.T_world_cam);
    const Eigen::Vector3d sigma = node.fix->sigma_m.cwiseProduct(noise.weighed());
    if (!node.horizontal_outlier)
      add<HorizontalFixResidual, 2, 6>({pose, node.fix->position_m.head<2>(), sigma.head<2>()},
                                       new ceres::HuberLoss(kHuberFix), blocks_[i].data());
    if (!node.vertical_outlier)
      add<VerticalFixResidual, 1, 6>({pose, node.fix->position_m.z(), sigma.z()},
                                     new ceres::HuberLoss(kHuberFix), blocks_[i].data());
  }

  /// Errors of these are common to the segment: all photos together weigh as one.
  ceres::LossFunction* sharedLoss(double count) const {
    return new ceres::ScaledLoss(new ceres::CauchyLoss(kCauchyAttitude), 1 / count,
                                 ceres::TAKE_OWNERSHIP);
  }

  void addAttitudes() {
    double tagged = 0, grounds = 0;
    for (const Node& node : segment_.nodes) {
      tagged += node.keyframe->attitude ? 1 : 0;
      grounds += node.ground_normal_cam ? 1 : 0;
    }
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const Node& node = segment_.nodes[i];
      const LinearPose pose(node.T_world_cam);
      if (node.keyframe->attitude) {
        const Eigen::Quaterniond tag(rotationWorldCam(*node.keyframe->attitude));
        add<TiltResidual, 3, 6>({pose, tag.conjugate() * Eigen::Vector3d::UnitZ(),
                                 options_.gimbal_tilt_sigma_deg * kRadPerDeg},
                                sharedLoss(tagged), blocks_[i].data());
        add<YawResidual, 1, 6>({pose, tag, options_.gimbal_yaw_sigma_deg * kRadPerDeg},
                               sharedLoss(tagged), blocks_[i].data());
      } else if (tagged == 0) {
        add<DirectionResidual, 3, 6>({pose, Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ(),
                                      options_.nadir_sigma_deg * kRadPerDeg},
                                     sharedLoss(static_cast<double>(blocks_.size())),
                                     blocks_[i].data());
      }
      if (node.ground_normal_cam)
        add<DirectionResidual, 3, 6>(
            {pose, *node.ground_normal_cam, Eigen::Vector3d::UnitZ(), node.ground_sigma_rad},
            sharedLoss(grounds), blocks_[i].data());
    }
  }

  void addScaleHints() {
    const std::vector<double> hints = scaleHints(segment_);
    for (const double hint : hints)
      add<LogScaleResidual, 1, 1>({std::log(hint / segment_.scale), options_.height_tag_sigma},
                                  sharedLoss(static_cast<double>(hints.size())), &log_scale_);
  }

  const Segment& segment_;
  const GeoreferenceMethod& method_;
  const GeoreferenceOptions& options_;
  std::vector<std::array<double, 6>> blocks_;
  double log_scale_ = 0;
  ceres::Problem problem_;
  bool usable_ = false;
};

}  // namespace

void solve(Segment& segment, const Noise& weights, const GeoreferenceMethod& method,
           std::size_t first_free) {
  {
    Linearised problem(segment, weights, method);
    problem.minimise(first_free);
    problem.apply(segment);
  }
  const ChainCovariance covariance = marginals(Linearised(segment, weights, method).information());
  segment.log_scale_sigma = std::sqrt(covariance.corner);
  for (std::size_t i = 0; i < segment.nodes.size(); ++i)
    segment.nodes[i].covariance = covariance.diagonal[i];
  measureNoise(segment, weights);
  segment.solved = std::isfinite(segment.log_scale_sigma) && std::isfinite(segment.scale);
}

}  // namespace cf
