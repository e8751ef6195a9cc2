// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/homography.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <string>
#include <utility>

#include "cf/base/median.h"

namespace cf {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Matrix28d = Eigen::Matrix<double, 2, 8>;

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d rotationOf(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-15) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

/// Two unit vectors normal to n and to each other.
Eigen::Matrix<double, 3, 2> tangentOf(const Eigen::Vector3d& n) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = n.unitOrthogonal();
  basis.col(1) = n.cross(basis.col(0));
  return basis;
}

double angleBetween(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// H_b_a with positive scale: x_b ~ H x_a. OpenCV's estimator draws from a fixed seed.
std::optional<cv::Matx33d> robustHomography(const Points& a, const Points& b, double threshold) {
  // In units of the threshold, as MAGSAC's tables are made for pixels.
  std::vector<cv::Point2d> pa, pb;
  for (const auto& p : a) pa.emplace_back(p.x() / threshold, p.y() / threshold);
  for (const auto& p : b) pb.emplace_back(p.x() / threshold, p.y() / threshold);
  cv::Mat mask;
  const cv::Mat H = cv::findHomography(pa, pb, cv::USAC_MAGSAC, 1.0, mask, 5000, 0.9999);
  if (H.empty()) return std::nullopt;
  const auto scale = cv::Matx33d::diag({threshold, threshold, 1});
  const auto unscale = cv::Matx33d::diag({1 / threshold, 1 / threshold, 1});
  cv::Matx33d out = scale * cv::Matx33d(H) * unscale;
  int in_front = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double z = out(2, 0) * a[i].x() + out(2, 1) * a[i].y() + out(2, 2);
    if (mask.at<std::uint8_t>(static_cast<int>(i)) != 0) in_front += z > 0 ? 1 : -1;
  }
  return in_front >= 0 ? out : out * -1.0;
}

double transferError(const PlaneMotion& m, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector3d y = transfer(m, a);
  return y.z() > 0 && m.normal_a.dot(a.homogeneous()) > 0 ? (y.hnormalized() - b).norm()
                                                          : std::numeric_limits<double>::infinity();
}

double priorCost(const PlaneMotion& m, const PlanePrior& prior) {
  double cost = 0;
  if (prior.normal_a) {
    cost += std::pow(angleBetween(*prior.normal_a, m.normal_a) / prior.normal_sigma_rad, 2);
  }
  if (prior.R_a_b) {
    const Eigen::AngleAxisd apart(Eigen::Matrix3d(prior.R_a_b->transpose() * m.T_a_b.linear()));
    cost += std::pow(apart.angle() / prior.rotation_sigma_rad, 2);
  }
  return cost;
}

/// The decompositions H = R_b_a + t n' / d that keep the matches in front of both cameras, the
/// likest to the prior first.
std::vector<PlaneMotion> decompose(const cv::Matx33d& H, const Points& a,
                                   const std::vector<char>& use, const PlanePrior& prior) {
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(H, cv::Matx33d::eye(), rotations, translations, normals);
  std::vector<PlaneMotion> motions;
  for (std::size_t k = 0; k < rotations.size(); ++k) {
    PlaneMotion m;
    Eigen::Matrix3d R_b_a;
    Eigen::Vector3d t, n;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) R_b_a(r, c) = rotations[k].at<double>(r, c);
      t[r] = translations[k].at<double>(r);
      n[r] = normals[k].at<double>(r);
    }
    m.T_a_b.linear() = R_b_a.transpose();
    if (n.norm() > 0.5) {
      m.normal_a = n.normalized();
      m.T_a_b.translation() = -(R_b_a.transpose() * t);
    } else {  // pure rotation has no normal
      m.normal_a = prior.normal_a.value_or(Eigen::Vector3d::UnitZ());
    }
    int seen = 0, total = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (!use[i]) continue;
      ++total;
      seen += m.normal_a.dot(a[i].homogeneous()) > 0 && transfer(m, a[i]).z() > 0;
    }
    if (seen < 0.9 * total) continue;
    m.prior_cost = priorCost(m, prior);
    motions.push_back(m);
  }
  std::stable_sort(motions.begin(), motions.end(), [](const PlaneMotion& p, const PlaneMotion& q) {
    return p.prior_cost < q.prior_cost;
  });
  return motions;
}

/// Transfer residual of one match and its derivative in the order of PlanarPose::covariance.
Eigen::Vector2d linearise(const PlaneMotion& m, const Eigen::Matrix<double, 3, 2>& tangent,
                          const Eigen::Vector2d& a, const Eigen::Vector2d& b, Matrix28d& J) {
  // y = R' (x - c (n.x)), R -> R exp(w), c -> c + dc, n -> n + tangent dn.
  const Eigen::Vector3d x = a.homogeneous();
  const Eigen::Matrix3d Rt = m.T_a_b.linear().transpose();
  const Eigen::Vector3d y = transfer(m, a);
  Eigen::Matrix<double, 3, 8> dy;
  dy.leftCols<3>() = -m.normal_a.dot(x) * Rt;
  dy.middleCols<3>(3) = skew(y);
  dy.rightCols<2>() = -(Rt * m.T_a_b.translation()) * (x.transpose() * tangent);
  Eigen::Matrix<double, 2, 3> projection;
  projection << 1 / y.z(), 0, -y.x() / (y.z() * y.z()), 0, 1 / y.z(), -y.y() / (y.z() * y.z());
  J = projection * dy;
  return y.hnormalized() - b;
}

struct NormalEquations {
  Matrix8d hessian = Matrix8d::Zero();
  Vector8d gradient = Vector8d::Zero();
  double cost = 0;
};

/// Robust (Cauchy) least squares over the matches in use, with the prior of the normal.
class Refinement {
 public:
  Refinement(const Points& a, const Points& b, const std::vector<char>& use, double sigma,
             const PlaneMotion& start, const PlanePrior& prior)
      : a_(a),
        b_(b),
        use_(use),
        sigma_(sigma),
        normal_(prior.normal_a.value_or(start.normal_a)),
        normal_sigma_(prior.normal_a ? prior.normal_sigma_rad : 1.0) {}

  NormalEquations at(const PlaneMotion& m) const {
    NormalEquations eq;
    const auto tangent = tangentOf(m.normal_a);
    Matrix28d J;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      if (!use_[i]) continue;
      const Eigen::Vector2d r = linearise(m, tangent, a_[i], b_[i], J) / sigma_;
      const double s = r.squaredNorm() / (kCauchy * kCauchy);
      const double w = 1 / ((1 + s) * sigma_ * sigma_);
      eq.hessian += w * J.transpose() * J;
      eq.gradient += w * sigma_ * J.transpose() * r;
      eq.cost += kCauchy * kCauchy * std::log1p(s) / 2;
    }
    const double information = 1 / (normal_sigma_ * normal_sigma_);
    const Eigen::Vector2d tilt = tangent.transpose() * (m.normal_a - normal_);
    eq.hessian.bottomRightCorner<2, 2>() += information * Eigen::Matrix2d::Identity();
    eq.gradient.tail<2>() += information * tilt;
    eq.cost += information * (1 - m.normal_a.dot(normal_));
    return eq;
  }

  PlaneMotion minimise(PlaneMotion m) const {
    NormalEquations eq = at(m);
    double damping = 1e-4;
    for (int i = 0; i < 50; ++i) {
      Matrix8d damped = eq.hessian;
      damped.diagonal() *= 1 + damping;
      const Vector8d step = -damped.ldlt().solve(eq.gradient);
      const PlaneMotion next = moved(m, step);
      const NormalEquations there = at(next);
      if (there.cost < eq.cost) {
        const bool done = eq.cost - there.cost < 1e-10 * eq.cost;
        m = next;
        eq = there;
        damping = std::max(damping / 10, 1e-12);
        if (done) break;
      } else {
        damping *= 10;
        if (damping > 1e8) break;
      }
    }
    return m;
  }

 private:
  static constexpr double kCauchy = 2.385;  // 95 % efficient for normal errors

  static PlaneMotion moved(PlaneMotion m, const Vector8d& step) {
    m.T_a_b.translation() += step.head<3>();
    m.T_a_b.linear() = (m.T_a_b.linear() * rotationOf(step.segment<3>(3))).eval();
    m.normal_a = (m.normal_a + tangentOf(m.normal_a) * step.tail<2>()).normalized();
    return m;
  }

  const Points &a_, &b_;
  const std::vector<char>& use_;
  double sigma_;
  Eigen::Vector3d normal_;
  double normal_sigma_;
};

/// Sigma of one coordinate from the median of the (Rayleigh) distances.
double sigmaOf(const PlaneMotion& m, const Points& a, const Points& b,
               const std::vector<char>& use) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (use[i]) errors.push_back(transferError(m, a[i], b[i]));
  }
  return std::max(upperMedian(std::move(errors)) / std::sqrt(2 * std::log(2.0)), 1e-9);
}

int selectInliers(const PlaneMotion& m, const Points& a, const Points& b, double threshold,
                  std::vector<char>& inlier) {
  int count = 0;
  inlier.assign(a.size(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    inlier[i] = transferError(m, a[i], b[i]) < threshold;
    count += inlier[i];
  }
  return count;
}

}  // namespace

Eigen::Vector3d transfer(const PlaneMotion& motion, const Eigen::Vector2d& a) {
  const Eigen::Vector3d x = a.homogeneous();
  return motion.T_a_b.linear().transpose() *
         (x - motion.normal_a.dot(x) * motion.T_a_b.translation());
}

PlaneMotion refinePlaneMotion(const Points& a, const Points& b, const std::vector<char>& inlier,
                              double sigma, const PlaneMotion& start, const PlanePrior& prior) {
  return Refinement(a, b, inlier, sigma, start, prior).minimise(start);
}

Result<PlanarPose> estimatePlanarPose(const Points& a, const Points& b, const PlanePrior& prior,
                                      const HomographyOptions& options) {
  const auto too_few = [&](int inliers) {
    return Failure{"too_few_inliers", std::to_string(inliers) + " inliers of " +
                                          std::to_string(a.size()) + " matches, " +
                                          std::to_string(options.min_inliers) + " needed"};
  };
  const int needed = std::max(5, options.min_inliers);
  if (static_cast<int>(a.size()) < needed) return too_few(0);
  const auto H = robustHomography(a, b, options.threshold);
  if (!H) return too_few(0);

  PlanarPose pose;
  std::vector<char>& inlier = pose.inlier;
  inlier.assign(a.size(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const cv::Vec3d y = *H * cv::Vec3d(a[i].x(), a[i].y(), 1);
    const bool near = (Eigen::Vector2d(y[0], y[1]) / y[2] - b[i]).norm() < options.threshold;
    inlier[i] = y[2] > 0 && near;
    pose.inliers += inlier[i];
  }
  if (pose.inliers < needed) return too_few(pose.inliers);

  std::vector<PlaneMotion> motions = decompose(*H, a, inlier, prior);
  if (motions.empty()) {
    return Failure{"no_decomposition",
                   "no decomposition of the homography has the matches in front of both cameras"};
  }
  PlaneMotion& m = motions.front();
  for (int round = 0; round < 2; ++round) {
    const double sigma = sigmaOf(m, a, b, inlier);
    m = Refinement(a, b, inlier, sigma, m, prior).minimise(m);
    pose.inliers = selectInliers(m, a, b, options.threshold, inlier);
    if (pose.inliers < needed) return too_few(pose.inliers);
  }
  pose.sigma = sigmaOf(m, a, b, inlier);
  const Refinement refinement(a, b, inlier, pose.sigma, m, prior);
  m = refinement.minimise(m);
  m.prior_cost = priorCost(m, prior);
  pose.covariance = refinement.at(m).hessian.ldlt().solve(Matrix8d::Identity());
  pose.motion = m;
  pose.alternatives.assign(motions.begin() + 1, motions.end());

  const Eigen::Vector3d c = m.T_a_b.translation();
  const auto across = tangentOf(c.norm() > 0 ? c.normalized() : Eigen::Vector3d::UnitZ());
  const double spread =
      (across.transpose() * pose.covariance.topLeftCorner<3, 3>() * across).trace() / 2;
  pose.direction_sigma_rad = std::atan2(std::sqrt(spread), c.norm());
  return pose;
}

}  // namespace cf
