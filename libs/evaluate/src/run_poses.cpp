// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_poses.h"

#include <Eigen/Geometry>
#include <cmath>

#include "cf/base/error.h"
#include "cf/geometry/similarity.h"
#include "pose_consistency.h"
#include "pose_errors.h"
#include "statistics.h"

namespace cf {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

std::vector<PosePair> pairsOf(const RunUav& uav) {
  std::vector<PosePair> pairs;
  for (const RunPhoto& photo : uav.photos)
    if (photo.estimate)
      pairs.push_back({uav.name, *photo.estimate, photo.truth, photo.covariance, photo.component});
  return pairs;
}

std::vector<PosePair> pairsOf(const RunInputs& run) {
  std::vector<PosePair> all;
  for (const RunUav& uav : run.uavs)
    for (const PosePair& pair : pairsOf(uav)) all.push_back(pair);
  return all;
}

Result<Sim3> align(const std::vector<PosePair>& pairs, AlignmentModel model) {
  std::vector<Eigen::Vector3d> reference, estimate;
  for (const PosePair& pair : pairs) {
    reference.push_back(pair.reference.translation());
    estimate.push_back(pair.estimate.translation());
  }
  return alignPoints(reference, estimate, model);
}

Json errorsUnder(const std::vector<PosePair>& pairs, const Result<Sim3>& S) {
  if (!S) return nullptr;
  Json json = jsonOf(poseErrors(pairs, *S));
  json["scale"] = S->scale;
  return json;
}

/// Takes the UAV's true poses to its estimated ones: centres, and tips of the cameras' axes as far
/// out as the centres are spread, so that a single straight strip determines it too.
Result<Sim3> truthToEstimate(const std::vector<PosePair>& pairs, const Sim3& S_ref_est) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PosePair& p : pairs)
    mean += p.reference.translation() / static_cast<double>(pairs.size());
  double spread = 0;
  for (const PosePair& p : pairs)
    spread += (p.reference.translation() - mean).squaredNorm() / static_cast<double>(pairs.size());
  const double lever = std::max(1.0, std::sqrt(spread));
  std::vector<Eigen::Vector3d> estimate, reference;
  for (const PosePair& p : pairs) {
    const Eigen::Isometry3d aligned = S_ref_est.carry(p.estimate);
    for (int axis = -1; axis < 3; ++axis) {
      const Eigen::Vector3d tip =
          axis < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(lever * Eigen::Vector3d::Unit(axis));
      estimate.push_back(aligned * tip);
      reference.push_back(p.reference * tip);
    }
  }
  return alignPoints(estimate, reference, AlignmentModel::kSe3);
}

}  // namespace

Json photoFigures(const RunInputs& run) {
  Json out = {{"total", 0}, {"posed", 0}};
  std::size_t total = 0, posed = 0;
  for (const RunUav& uav : run.uavs) {
    const std::size_t here = pairsOf(uav).size();
    total += uav.photos.size();
    posed += here;
    out["per_uav"][uav.name] = {{"total", uav.photos.size()}, {"posed", here}};
  }
  out["total"] = total;
  out["posed"] = posed;
  return out;
}

Result<Sim3> alignCluster(const RunInputs& run) {
  return align(pairsOf(run), AlignmentModel::kSim3);
}

RunSection trajectoryFigures(const RunInputs& run) {
  const std::vector<PosePair> all = pairsOf(run);
  if (all.empty()) return Failure{"no_poses", "no photo of the truth has a pose in the run"};
  const Result<Sim3> se3 = align(all, AlignmentModel::kSe3), sim3 = alignCluster(run);
  Json out;
  out["none"] = errorsUnder(all, Sim3());
  out["none"].erase("scale");
  out["se3"] = errorsUnder(all, se3);
  out["sim3"] = errorsUnder(all, sim3);
  for (const RunUav& uav : run.uavs) {
    const std::vector<PosePair> own = pairsOf(uav);
    if (own.empty()) continue;
    out["per_uav"][uav.name] = {{"own_se3", errorsUnder(own, align(own, AlignmentModel::kSe3))},
                                {"cluster_se3", errorsUnder(own, se3)}};
  }
  return out;
}

RunSection pairFigures(const RunInputs& run, const Sim3& S_ref_est) {
  std::vector<double> rotations, shifts;
  Json pairs = Json::array();
  for (std::size_t a = 0; a < run.uavs.size(); ++a)
    for (std::size_t b = a + 1; b < run.uavs.size(); ++b) {
      const auto poses_a = pairsOf(run.uavs[a]), poses_b = pairsOf(run.uavs[b]);
      if (poses_a.empty() || poses_b.empty()) continue;
      const auto T_a = truthToEstimate(poses_a, S_ref_est),
                 T_b = truthToEstimate(poses_b, S_ref_est);
      if (!T_a || !T_b) continue;
      // Where a point amid the two UAVs would come to lie, moved with the one and with the other.
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      const auto n = static_cast<double>(poses_a.size() + poses_b.size());
      for (const auto* poses : {&poses_a, &poses_b})
        for (const PosePair& p : *poses) middle += p.reference.translation() / n;
      const Eigen::Vector3d shift = *T_b * middle - *T_a * middle;
      const double angle =
          kDegrees * Eigen::AngleAxisd(T_a->rotation.transpose() * T_b->rotation).angle();
      rotations.push_back(angle);
      shifts.push_back(shift.norm());
      pairs.push_back({{"a", run.uavs[a].name},
                       {"b", run.uavs[b].name},
                       {"rotation_deg", angle},
                       {"translation_m", shift.norm()},
                       {"horizontal_m", shift.head<2>().norm()},
                       {"vertical_m", shift.z()}});
    }
  if (pairs.empty()) return Failure{"one_uav", "fewer than two UAVs have poses"};
  return Json{{"rotation_rms_deg", rms(rotations)},
              {"translation_rms_m", rms(shifts)},
              {"pairs", std::move(pairs)}};
}

RunSection consistencyFigures(const RunInputs& run) {
  const std::vector<PosePair> all = pairsOf(run);
  Json world = worldConsistency(all);
  if (world.is_null())
    return Failure{"no_covariances", "the run has no line in trajectories/<uav>.covariance.csv"};
  return Json{{"world", std::move(world)}, {"map", mapConsistency(all)}};
}

RunSection relativePoseFigures(const RunInputs& run) {
  if (run.relative_poses.empty())
    return Failure{"no_relative_poses", "relative_poses.csv has no pair of photos of the truth"};
  constexpr double kChi2Of3_95 = 7.815, kParallel = 1e-9;
  std::vector<double> rotations, directions, lengths, normalised_t, normalised_r;
  std::size_t within_t = 0, within_r = 0;
  for (const RunRelativePose& p : run.relative_poses) {
    const Eigen::AngleAxisd rotation(p.estimate.linear() * p.truth.linear().transpose());
    const Eigen::Vector3d t = p.estimate.translation(), t_true = p.truth.translation();
    rotations.push_back(kDegrees * rotation.angle());
    if (t.norm() > kParallel && t_true.norm() > kParallel) {
      directions.push_back(kDegrees * std::atan2(t.cross(t_true).norm(), t.dot(t_true)));
      lengths.push_back(100 * (t.norm() / t_true.norm() - 1));
    }
    if (!(p.sigma.minCoeff() > 0)) continue;
    const Eigen::Vector3d e_t = (t - t_true).cwiseQuotient(p.sigma.head<3>());
    const Eigen::Vector3d e_r =
        (rotation.angle() * rotation.axis()).cwiseQuotient(p.sigma.tail<3>());
    for (int i = 0; i < 3; ++i) {
      normalised_t.push_back(e_t[i]);
      normalised_r.push_back(e_r[i]);
    }
    within_t += e_t.squaredNorm() < kChi2Of3_95 ? 1 : 0;
    within_r += e_r.squaredNorm() < kChi2Of3_95 ? 1 : 0;
  }
  const auto consistency = [](const std::vector<double>& normalised, std::size_t within) {
    Json json = consistencyOf(normalised);
    if (!json.is_null())
      json["within_chi2_95"] =
          3 * static_cast<double>(within) / static_cast<double>(normalised.size());
    return json;
  };
  return Json{
      {"count", run.relative_poses.size()},
      {"rotation_deg", {{"rms", rms(rotations)}, {"median", median(rotations)}}},
      {"direction_deg", directions.empty()
                            ? Json(nullptr)
                            : Json{{"rms", rms(directions)}, {"median", median(directions)}}},
      {"length_pct",
       lengths.empty() ? Json(nullptr) : Json{{"rms", rms(lengths)}, {"median", median(lengths)}}},
      {"consistency_translation", consistency(normalised_t, within_t)},
      {"consistency_rotation", consistency(normalised_r, within_r)}};
}

}  // namespace cf
