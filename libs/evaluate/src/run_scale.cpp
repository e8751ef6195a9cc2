// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_scale.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>

#include "statistics.h"

namespace cf {
namespace {

constexpr std::size_t kEarly = 15;    ///< photos
constexpr double kConverged_pct = 1;  ///< of the true scale

struct Sample {
  double error_pct = 0, normalised = 0;
};

/// The least relative sigma that fixes of this horizontal sigma allow.
double boundPercent(const std::vector<Eigen::Vector3d>& positions, double sigma_m) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : positions) mean += p.head<2>() / static_cast<double>(positions.size());
  double sum = 0;
  for (const auto& p : positions) sum += (p.head<2>() - mean).squaredNorm();
  return 100 * sigma_m / std::sqrt(sum);
}

/// 1-based number of the first photo from which on the error stays small; null if it does not.
Json photosToConverge(const std::vector<Sample>& samples) {
  std::size_t first = samples.size();
  while (first > 0 && std::abs(samples[first - 1].error_pct) < kConverged_pct) --first;
  return first == samples.size() ? Json(nullptr) : Json(first + 1);
}

/// `rows` of one segment in time order.
Json segmentFigures(const RunUav& uav, int segment, const std::vector<ScaleEstimate>& rows,
                    std::vector<double>& normalised) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> pairs;
  std::vector<Eigen::Vector3d> positions;
  std::vector<const RunPhoto*> photos;
  for (const RunPhoto& photo : uav.photos)
    if (photo.segment == segment && photo.local) photos.push_back(&photo);
  std::sort(photos.begin(), photos.end(),
            [](const RunPhoto* a, const RunPhoto* b) { return a->time < b->time; });
  std::vector<Sample> samples;
  Json history = Json::array();
  std::size_t next = 0;
  for (const ScaleEstimate& row : rows) {
    for (; next < photos.size() && photos[next]->time <= row.time; ++next) {
      positions.push_back(photos[next]->truth.translation());
      pairs.emplace_back(positions.back(), photos[next]->local->translation());
    }
    const double truth = umeyamaScale(pairs);
    if (!(truth > 0)) continue;
    Sample sample;
    sample.error_pct = 100 * (row.scale / truth - 1);
    sample.normalised = row.sigma > 0 ? (row.scale - truth) / row.sigma : std::nan("");
    samples.push_back(sample);
    if (std::isfinite(sample.normalised)) normalised.push_back(sample.normalised);
    history.push_back({pairs.size(), sample.error_pct, 100 * row.sigma / truth});
  }
  if (samples.empty()) return nullptr;
  Json out = {{"photos", photos.size()},
              {"error_end_pct", samples.back().error_pct},
              {"error_15_pct",
               samples.size() < kEarly ? Json(nullptr) : Json(samples[kEarly - 1].error_pct)},
              {"sigma_end_pct", history.back()[2]},
              {"bound_sigma_pct", nullptr},
              {"photos_to_converge", photosToConverge(samples)}};
  if (uav.gnss_true)
    out["bound_sigma_pct"] =
        finite(boundPercent(positions, uav.gnss_true->sigma_m.head<2>().norm() / std::sqrt(2)));
  out["history"] = std::move(history);
  return out;
}

}  // namespace

double umeyamaScale(const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>& pairs) {
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = mean_a;
  for (const auto& [a, b] : pairs) {
    mean_a += a / n;
    mean_b += b / n;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double variance = 0;
  for (const auto& [a, b] : pairs) {
    covariance += (a - mean_a) * (b - mean_b).transpose();
    variance += (b - mean_b).squaredNorm();
  }
  if (!(variance > 0)) return 0;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance);
  const Eigen::Vector3d d = svd.singularValues();
  return (d.x() + d.y() + (covariance.determinant() < 0 ? -d.z() : d.z())) / variance;
}

RunSection scaleFigures(const RunInputs& run) {
  Json per_uav = Json::object();
  std::vector<double> normalised, ends;
  bool any_row = false, any_local = false;
  for (const RunUav& uav : run.uavs) {
    any_row = any_row || !uav.scale.empty();
    any_local = any_local || std::any_of(uav.photos.begin(), uav.photos.end(),
                                         [](const RunPhoto& p) { return p.local.has_value(); });
    std::set<int> segments;
    for (const ScaleEstimate& row : uav.scale) segments.insert(row.segment);
    for (const int segment : segments) {
      std::vector<ScaleEstimate> rows;
      for (const ScaleEstimate& row : uav.scale)
        if (row.segment == segment) rows.push_back(row);
      Json figures = segmentFigures(uav, segment, rows, normalised);
      if (figures.is_null()) continue;
      ends.push_back(std::abs(figures["error_end_pct"].get<double>()));
      per_uav[uav.name][std::to_string(segment)] = std::move(figures);
    }
  }
  if (!any_row) return Failure{"no_scale", "the run has no line in scale/<uav>.csv"};
  if (!any_local || ends.empty())
    return Failure{"no_local_poses",
                   "the run has no odometry/<uav>.tum: the true scale of a segment needs its local "
                   "trajectory"};
  Json out;
  out["error_end_pct"] = {{"median", median(ends)},
                          {"max", *std::max_element(ends.begin(), ends.end())}};
  out["consistency"] = consistencyOf(normalised);
  out["segments"] = std::move(per_uav);
  return out;
}

}  // namespace cf
