// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/trajectory.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cf/base/error.h"
#include "pose_consistency.h"
#include "pose_errors.h"
#include "statistics.h"

namespace cf {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

}  // namespace

PoseErrors poseErrors(const std::vector<PosePair>& pairs, const Sim3& S_ref_est) {
  PoseErrors errors;
  std::vector<double> distance, angle;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    const Eigen::Isometry3d aligned = S_ref_est.carry(pair.estimate);
    const Eigen::Vector3d d = aligned.translation() - pair.reference.translation();
    const Eigen::Quaterniond q_ref(pair.reference.linear());
    distance.push_back(d.norm());
    squares += d.cwiseAbs2();
    angle.push_back(kDegrees * q_ref.angularDistance(Eigen::Quaterniond(aligned.linear())));
  }
  errors.matched = static_cast<int>(pairs.size());
  errors.rmse_m = rms(distance);
  errors.rmse_axis_m = (squares / static_cast<double>(pairs.size())).cwiseSqrt();
  errors.max_m = *std::max_element(distance.begin(), distance.end());
  errors.median_m = median(distance);
  errors.rotation_rmse_deg = rms(angle);
  errors.rotation_median_deg = median(angle);
  return errors;
}

Json jsonOf(const PoseErrors& e) {
  return {{"matched", e.matched},
          {"rmse_m", e.rmse_m},
          {"median_m", e.median_m},
          {"max_m", e.max_m},
          {"rmse_axis_m", {e.rmse_axis_m.x(), e.rmse_axis_m.y(), e.rmse_axis_m.z()}},
          {"rotation_rmse_deg", e.rotation_rmse_deg},
          {"rotation_median_deg", e.rotation_median_deg}};
}

TrajectoryEvaluation evaluateTrajectory(const PosePairs& joined,
                                        std::optional<AlignmentModel> align) {
  if (joined.pairs.empty())
    throw RunError(
        "no pose of the estimate matches one of the reference: check that both are of "
        "the same flight");
  TrajectoryEvaluation evaluation;
  evaluation.pairs = joined.pairs;
  evaluation.missing = joined.missing;
  evaluation.unreferenced = joined.unreferenced;
  std::vector<Eigen::Vector3d> reference, estimate;
  Eigen::AlignedBox3d box;
  std::map<std::string, std::vector<PosePair>> by_uav;
  for (const PosePair& pair : joined.pairs) {
    reference.push_back(pair.reference.translation());
    estimate.push_back(pair.estimate.translation());
    box.extend(reference.back());
    by_uav[pair.uav].push_back(pair);
  }
  evaluation.extent_m = box.diagonal().norm();
  if (align) {
    const auto S = alignPoints(reference, estimate, *align);
    if (!S) throw RunError("the trajectories cannot be aligned: " + S.failure().detail);
    evaluation.S_ref_est = *S;
  }
  evaluation.all = poseErrors(joined.pairs, evaluation.S_ref_est);
  for (const auto& [uav, pairs] : by_uav)
    evaluation.per_uav[uav] = poseErrors(pairs, evaluation.S_ref_est);
  return evaluation;
}

std::string toJson(const TrajectoryEvaluation& evaluation, const std::string& align) {
  const Sim3& S = evaluation.S_ref_est;
  Json json = {
      {"align", align}, {"missing", evaluation.missing}, {"unreferenced", evaluation.unreferenced}};
  json.update(jsonOf(evaluation.all));
  json["scale"] = S.scale;
  json["alignment"] = {
      {"rotation_deg", kDegrees * Eigen::AngleAxisd(S.rotation).angle()},
      {"translation_m", {S.translation.x(), S.translation.y(), S.translation.z()}}};
  json["extent_m"] = evaluation.extent_m;
  json["rmse_over_extent"] =
      evaluation.extent_m > 0 ? Json(evaluation.all.rmse_m / evaluation.extent_m) : Json(nullptr);
  json["per_uav"] = Json::object();
  for (const auto& [uav, errors] : evaluation.per_uav) json["per_uav"][uav] = jsonOf(errors);
  json["consistency"] = mapConsistency(evaluation.pairs);
  return json.dump(2);
}

}  // namespace cf
