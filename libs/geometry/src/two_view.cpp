// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/two_view.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <string>
#include <utility>

#include "cf/base/median.h"
#include "cf/geometry/triangulation.h"

namespace cf {
namespace {

using Points = std::vector<cv::Point2d>;

Points toCv(const std::vector<Eigen::Vector2d>& points) {
  Points out;
  out.reserve(points.size());
  for (const auto& p : points) out.emplace_back(p.x(), p.y());
  return out;
}

Eigen::Matrix3d toEigen(const cv::Mat& m) {
  Eigen::Matrix3d out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out(r, c) = m.at<double>(r, c);
  return out;
}

/// OpenCV's robust estimators draw from fixed seeds: the same matches give the same model.
cv::Mat essentialOf(const Points& a, const Points& b, double threshold, cv::Mat& mask) {
  return cv::findEssentialMat(a, b, cv::Mat::eye(3, 3, CV_64F), cv::USAC_MAGSAC, 0.9999, threshold,
                              2000, mask);
}

/// In units of the threshold: OpenCV's MAGSAC finds no homography on the normalized plane as soon
/// as there are outliers.
cv::Mat homographyOf(const Points& a, const Points& b, double threshold, cv::Mat& mask) {
  const auto scaled = [&](Points points) {
    for (cv::Point2d& p : points) p *= 1 / threshold;
    return points;
  };
  const cv::Mat H =
      cv::findHomography(scaled(a), scaled(b), cv::USAC_MAGSAC, 1, mask, 2000, 0.9999);
  if (H.empty()) return H;
  const cv::Mat scale = cv::Mat::diag(cv::Mat(cv::Vec3d(threshold, threshold, 1)));
  return scale * H * scale.inv();
}

/// Maps a's frame to b's: p_b = R p_a + t.
struct Hypothesis {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
};

void addEssential(const cv::Mat& E, std::vector<Hypothesis>& out) {
  for (int row = 0; row + 3 <= E.rows; row += 3) {
    cv::Mat R1, R2, t;
    cv::decomposeEssentialMat(E.rowRange(row, row + 3), R1, R2, t);
    const Eigen::Vector3d te(t.at<double>(0), t.at<double>(1), t.at<double>(2));
    for (const cv::Mat& R : {R1, R2})
      for (const double sign : {1.0, -1.0}) out.push_back({toEigen(R), sign * te});
  }
}

void addHomography(const cv::Mat& H, std::vector<Hypothesis>& out) {
  std::vector<cv::Mat> Rs, ts, normals;
  cv::decomposeHomographyMat(H, cv::Mat::eye(3, 3, CV_64F), Rs, ts, normals);
  for (std::size_t i = 0; i < Rs.size(); ++i) {
    const Eigen::Vector3d t(ts[i].at<double>(0), ts[i].at<double>(1), ts[i].at<double>(2));
    if (t.norm() > 1e-6) out.push_back({toEigen(Rs[i]), t.normalized()});
  }
}

struct SampsonError {
  Eigen::Vector2d a, b;
  double scale;

  template <class T>
  bool operator()(const T* rotation, const T* t, T* residual) const {
    const T x[3] = {T(a.x()), T(a.y()), T(1)};
    T Rx[3];
    ceres::QuaternionRotatePoint(rotation, x, Rx);
    // E x_a = t cross (R x_a); E' x_b = R' (x_b cross t).
    T Ex[3], xb[3] = {T(b.x()), T(b.y()), T(1)}, cross[3], Etx[3];
    ceres::CrossProduct(t, Rx, Ex);
    ceres::CrossProduct(xb, t, cross);
    const T inverse[4] = {rotation[0], -rotation[1], -rotation[2], -rotation[3]};
    ceres::QuaternionRotatePoint(inverse, cross, Etx);
    const T algebraic = xb[0] * Ex[0] + xb[1] * Ex[1] + xb[2] * Ex[2];
    const T gradient2 = Ex[0] * Ex[0] + Ex[1] * Ex[1] + Etx[0] * Etx[0] + Etx[1] * Etx[1];
    residual[0] = T(scale) * algebraic / ceres::sqrt(gradient2 + T(1e-12));
    return true;
  }
};

/// Minimises the Sampson error over rotation and direction of translation.
void refine(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b,
            double threshold, Hypothesis& h) {
  const Eigen::Quaterniond q(h.R);
  double rotation[4] = {q.w(), q.x(), q.y(), q.z()};
  double t[3] = {h.t.x(), h.t.y(), h.t.z()};
  ceres::Problem problem;
  // An even sample bounds the cost; the final score uses every match.
  const std::size_t step = std::max<std::size_t>(1, a.size() / 400);
  for (std::size_t i = 0; i < a.size(); i += step)
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<SampsonError, 1, 4, 3>(
                                 new SampsonError{a[i], b[i], 1 / threshold}),
                             new ceres::CauchyLoss(0.5), rotation, t);
  problem.SetManifold(rotation, new ceres::QuaternionManifold());
  problem.SetManifold(t, new ceres::SphereManifold<3>());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 20;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  h.R = Eigen::Quaterniond(rotation[0], rotation[1], rotation[2], rotation[3])
            .normalized()
            .toRotationMatrix();
  h.t = Eigen::Vector3d(t[0], t[1], t[2]).normalized();
}

struct Scored {
  TwoView view;
  double score = 0;  ///< sum of 1 - (error / threshold)^2 over the inliers
};

Scored score(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b,
             double threshold, const Hypothesis& h) {
  Scored out;
  Eigen::Isometry3d T_b_a = Eigen::Isometry3d::Identity();
  T_b_a.linear() = h.R;
  T_b_a.translation() = h.t;
  out.view.T_a_b = T_b_a.inverse();
  out.view.inlier.assign(a.size(), 0);
  out.view.point_a.assign(a.size(), Eigen::Vector3d::Zero());
  std::vector<double> angles;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto point = triangulate({{Eigen::Isometry3d::Identity(), a[i]}, {out.view.T_a_b, b[i]}});
    if (!point || point->max_error > threshold) continue;
    out.view.inlier[i] = 1;
    out.view.point_a[i] = point->position;
    ++out.view.inliers;
    const double e = point->max_error / threshold;
    out.score += 1 - e * e;
    angles.push_back(point->max_angle_rad);
  }
  out.view.median_parallax_rad = upperMedian(std::move(angles));
  return out;
}

}  // namespace

Result<TwoView> estimateTwoView(const std::vector<Eigen::Vector2d>& a,
                                const std::vector<Eigen::Vector2d>& b,
                                const TwoViewOptions& options) {
  const auto too_few = [&](int inliers) {
    return Failure{"too_few_inliers", std::to_string(inliers) + " inliers of " +
                                          std::to_string(a.size()) + " matches, " +
                                          std::to_string(options.min_inliers) + " needed"};
  };
  if (static_cast<int>(a.size()) < std::max(8, options.min_inliers)) return too_few(0);
  const Points ca = toCv(a), cb = toCv(b);
  std::vector<Hypothesis> hypotheses;
  cv::Mat mask_e, mask_h;
  const cv::Mat E = essentialOf(ca, cb, options.threshold, mask_e);
  if (!E.empty()) addEssential(E, hypotheses);
  const cv::Mat H = homographyOf(ca, cb, 2 * options.threshold, mask_h);
  if (!H.empty()) addHomography(H, hypotheses);

  Scored best;
  for (const Hypothesis& raw : hypotheses) {
    // A hypothesis that puts most points behind a camera is not worth refining.
    const Scored first = score(a, b, 3 * options.threshold, raw);
    if (first.view.inliers < options.min_inliers / 2 || first.score < 0.3 * best.score) continue;
    Hypothesis refined = raw;
    refine(a, b, options.threshold, refined);
    Scored candidate = score(a, b, options.threshold, refined);
    if (candidate.score > best.score) best = std::move(candidate);
  }
  if (best.view.inliers < options.min_inliers) return too_few(best.view.inliers);
  best.view.planar =
      !H.empty() && cv::countNonZero(mask_h) > 0.8 * static_cast<double>(best.view.inliers);
  if (best.view.median_parallax_rad < options.min_parallax_rad)
    return Failure{"too_little_parallax",
                   "median parallax " + std::to_string(best.view.median_parallax_rad * 180 / M_PI) +
                       " degrees"};
  return best.view;
}

std::vector<char> consistentMatches(const std::vector<Eigen::Vector2d>& a,
                                    const std::vector<Eigen::Vector2d>& b, double threshold) {
  std::vector<char> keep(a.size(), 0);
  if (a.size() < 8) return keep;
  const Points ca = toCv(a), cb = toCv(b);
  cv::Mat mask_h;
  const cv::Mat H = homographyOf(ca, cb, 2 * threshold, mask_h);
  const int on_plane = H.empty() ? 0 : cv::countNonZero(mask_h);
  // Where a plane holds a fair share, matches far off it are wrong: no relief shifts a point so
  // much. Without them the essential matrix, which is dear among outliers, needs few trials.
  std::vector<std::size_t> candidates(a.size());
  std::iota(candidates.begin(), candidates.end(), std::size_t{0});
  if (on_plane >= std::max(20.0, 0.2 * static_cast<double>(a.size()))) {
    constexpr double kMostRelief = 0.25;  // on the normalized plane
    const Eigen::Matrix3d h = toEigen(H);
    const auto is_far = [&](std::size_t i) {
      return ((h * a[i].homogeneous()).hnormalized() - b[i]).norm() > kMostRelief;
    };
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), is_far),
                     candidates.end());
  }
  Points near_a, near_b;
  for (const std::size_t i : candidates) {
    near_a.push_back(ca[i]);
    near_b.push_back(cb[i]);
  }
  cv::Mat mask_e;
  if (candidates.size() >= 8) essentialOf(near_a, near_b, threshold, mask_e);
  const bool planar = !mask_e.empty() && on_plane >= cv::countNonZero(mask_e);
  if (planar) {
    for (std::size_t i = 0; i < keep.size(); ++i)
      keep[i] = mask_h.at<std::uint8_t>(static_cast<int>(i)) != 0;
  } else if (!mask_e.empty()) {
    for (std::size_t i = 0; i < candidates.size(); ++i)
      keep[candidates[i]] = mask_e.at<std::uint8_t>(static_cast<int>(i)) != 0;
  }
  return keep;
}

}  // namespace cf
