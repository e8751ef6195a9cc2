// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_scale.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "statistics.h"

namespace cf {
namespace {

constexpr std::size_t kEarly = 15;    ///< photos
constexpr double kConverged_pct = 1;  ///< of the true scale
// What a scale may be off, or 3 of the bound's sigmas where that is more.
constexpr double kLimitEarly_pct = 1, kLimitEnd_pct = 0.3;

struct Sample {
  double error_pct = 0, normalised = 0;
};

/// Sum of squared horizontal distances of the fixes within a time from their mean [m^2].
double spreadOfFixes(const RunUav& uav, TimeNs from, TimeNs to) {
  std::vector<Eigen::Vector2d> used;
  for (const TrueFix& fix : uav.fixes)
    if (fix.time >= from && fix.time <= to) used.emplace_back(fix.position_m.head<2>());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : used) mean += p / static_cast<double>(used.size());
  double sum = 0;
  for (const auto& p : used) sum += (p - mean).squaredNorm();
  return sum;
}

/// In units of the receiver's horizontal variance; 0 where the truth does not tell.
double informationOf(const RunUav& uav, TimeNs from, TimeNs to) {
  if (!uav.gnss_true) return 0;
  return spreadOfFixes(uav, from, to) / (uav.gnss_true->sigma_m.head<2>().squaredNorm() / 2);
}

/// An error beside the least sigma that fixes of this information allow, and the limit from it.
Json againstBound(double error_pct, double information, double limit_pct) {
  const double bound_pct = information > 0 ? 100 / std::sqrt(information) : std::nan("");
  const double limit = std::max(limit_pct, 3 * bound_pct);
  const bool known = std::isfinite(bound_pct);
  return {{"error_pct", finite(error_pct)},
          {"bound_sigma_pct", finite(bound_pct)},
          {"limit_pct", known ? Json(limit) : Json(nullptr)},
          {"within_limit", known ? Json(std::abs(error_pct) <= limit) : Json(nullptr)}};
}

/// 1-based number of the first photo from which on the error stays small; null if it does not.
Json photosToConverge(const std::vector<Sample>& samples) {
  std::size_t first = samples.size();
  while (first > 0 && std::abs(samples[first - 1].error_pct) < kConverged_pct) --first;
  return first == samples.size() ? Json(nullptr) : Json(first + 1);
}

/// `rows` of one segment in time order. Errors over sigmas, all and the last, are appended.
Json segmentFigures(const RunUav& uav, int segment, const std::vector<ScaleEstimate>& rows,
                    std::vector<double>& normalised, std::vector<double>& ends) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> pairs;
  std::vector<const RunPhoto*> photos;
  for (const RunPhoto& photo : uav.photos)
    if (photo.segment == segment && photo.local) photos.push_back(&photo);
  std::sort(photos.begin(), photos.end(),
            [](const RunPhoto* a, const RunPhoto* b) { return a->time < b->time; });
  std::vector<Sample> samples;
  Json history = Json::array(), early = nullptr, end = nullptr;
  std::size_t next = 0;
  for (const ScaleEstimate& row : rows) {
    for (; next < photos.size() && photos[next]->time <= row.time; ++next)
      pairs.emplace_back(photos[next]->truth.translation(), photos[next]->local->translation());
    const double truth = umeyamaScale(pairs);
    if (!(truth > 0)) continue;
    Sample sample;
    sample.error_pct = 100 * (row.scale / truth - 1);
    sample.normalised = row.sigma > 0 ? (row.scale - truth) / row.sigma : std::nan("");
    samples.push_back(sample);
    if (std::isfinite(sample.normalised)) normalised.push_back(sample.normalised);
    history.push_back({pairs.size(), sample.error_pct, 100 * row.sigma / truth});
    const double information = informationOf(uav, photos.front()->time, row.time);
    if (early.is_null() && pairs.size() >= kEarly)
      early = againstBound(sample.error_pct, information, kLimitEarly_pct);
    end = againstBound(sample.error_pct, information, kLimitEnd_pct);
  }
  if (samples.empty()) return nullptr;
  if (std::isfinite(samples.back().normalised)) ends.push_back(samples.back().normalised);
  return {{"photos", photos.size()},
          {"after_15", std::move(early)},
          {"end", std::move(end)},
          {"sigma_end_pct", history.back()[2]},
          {"photos_to_converge", photosToConverge(samples)},
          {"history", std::move(history)}};
}

/// Scale of the final poses of one UAV; null where it has too few.
Json mapFigures(const RunUav& uav) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> pairs;
  for (const RunPhoto& photo : uav.photos)
    if (photo.estimate)
      pairs.emplace_back(photo.truth.translation(), photo.estimate->translation());
  const double truth = umeyamaScale(pairs);
  if (!(truth > 0)) return nullptr;
  const auto always = std::numeric_limits<TimeNs>::max();
  return againstBound(100 * (1 / truth - 1), informationOf(uav, 0, always), kLimitEnd_pct);
}

/// Whether all of those that have a limit keep it; null where none has.
void judge(const Json& figures, Json& all_within) {
  if (!figures.is_object() || figures["within_limit"].is_null()) return;
  all_within =
      figures["within_limit"].get<bool>() && (all_within.is_null() || all_within.get<bool>());
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
  Json segments = Json::object(), map = Json::object();
  Json within = {{"after_15", nullptr}, {"end", nullptr}, {"map", nullptr}};
  std::vector<double> normalised, normalised_ends, ends;
  bool any_row = false, any_local = false;
  for (const RunUav& uav : run.uavs) {
    any_row = any_row || !uav.scale.empty();
    any_local = any_local || std::any_of(uav.photos.begin(), uav.photos.end(),
                                         [](const RunPhoto& p) { return p.local.has_value(); });
    map[uav.name] = mapFigures(uav);
    judge(map[uav.name], within["map"]);
    std::map<int, std::vector<ScaleEstimate>> rows;
    for (const ScaleEstimate& row : uav.scale) rows[row.segment].push_back(row);
    for (const auto& [segment, of_segment] : rows) {
      Json figures = segmentFigures(uav, segment, of_segment, normalised, normalised_ends);
      if (figures.is_null()) continue;
      ends.push_back(std::abs(figures["end"]["error_pct"].get<double>()));
      for (const char* when : {"after_15", "end"}) judge(figures[when], within[when]);
      segments[uav.name][std::to_string(segment)] = std::move(figures);
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
  out["within_limits"] = std::move(within);
  out["consistency"] = consistencyOf(normalised);
  out["consistency_end"] = meanSquareOf(normalised_ends);
  out["map"] = std::move(map);
  out["segments"] = std::move(segments);
  return out;
}

}  // namespace cf
