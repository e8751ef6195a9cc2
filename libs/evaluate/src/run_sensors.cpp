// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_sensors.h"

#include <algorithm>
#include <cmath>

#include "statistics.h"

namespace cf {
namespace {

constexpr int kGrid = 40;  ///< pixels looked at along each side

Json cameraJson(const CameraModel& truth, const CameraModel& estimate) {
  const PixelDisplacement d = displacementOf(truth, estimate);
  return {{"focal_error_pct", 100 * (estimate.fx / truth.fx - 1)},
          {"displacement_rms_px", finite(d.rms_px)},
          {"displacement_max_px", finite(d.max_px)}};
}

/// Where a standard deviation of so many errors lies over the true one in 95 % of cases.
Json ratioBounds(int fixes) {
  if (fixes <= 0) return nullptr;
  const double n = fixes;
  return {std::sqrt(chiSquareQuantile(0.025, n) / n), std::sqrt(chiSquareQuantile(0.975, n) / n)};
}

}  // namespace

PixelDisplacement displacementOf(const CameraModel& truth, const CameraModel& estimate) {
  PixelDisplacement out;
  double sum = 0;
  for (int j = 0; j <= kGrid; ++j)
    for (int i = 0; i <= kGrid; ++i) {
      const Eigen::Vector2d pixel(i * (truth.width - 1.0) / kGrid,
                                  j * (truth.height - 1.0) / kGrid);
      const double d = (estimate.distort(truth.undistort(pixel)) - pixel).norm();
      sum += d * d;
      out.max_px = std::max(out.max_px, d);
    }
  out.rms_px = std::sqrt(sum / ((kGrid + 1) * (kGrid + 1)));
  return out;
}

RunSection cameraFigures(const RunInputs& run) {
  Json out = Json::object();
  std::vector<double> normalised, all, focal;
  for (const RunUav& uav : run.uavs) {
    if (!uav.camera_true || !uav.camera_after) continue;
    const CameraModel& truth = *uav.camera_true;
    const CameraModel after = uav.camera_after->scaled(truth.width, truth.height);
    Json figures = {{"before", nullptr}, {"after", cameraJson(truth, after)}};
    if (uav.camera_before && uav.camera_before->width > 0)
      figures["before"] = cameraJson(truth, uav.camera_before->scaled(truth.width, truth.height));
    const auto over = [&](double error, double sigma) {
      if (!(sigma > 0)) return Json(nullptr);
      all.push_back(error / sigma);
      return finite(error / sigma);
    };
    figures["focal_error_over_sigma"] = over(after.fx - truth.fx, after.focal_sigma);
    if (after.focal_sigma > 0) normalised.push_back(all.back());
    figures["k1_error_over_sigma"] = over(after.k1 - truth.k1, after.k1_sigma);
    figures["k2_error_over_sigma"] = over(after.k2 - truth.k2, after.k2_sigma);
    focal.push_back(100 * (after.fx / truth.fx - 1));
    out["per_uav"][uav.name] = std::move(figures);
  }
  if (focal.empty()) return Failure{"no_cameras", "truth or run lack cameras/<uav>.ini"};
  out["focal_rms_pct"] = rms(focal);
  out["focal_consistency"] = consistencyOf(normalised);
  out["consistency"] = consistencyOf(all);  // focal length, k1 and k2
  return out;
}

RunSection gnssFigures(const RunInputs& run) {
  std::vector<const RunUav*> known;
  Eigen::Vector3d common = Eigen::Vector3d::Zero();
  for (const RunUav& uav : run.uavs)
    if (uav.gnss_true && uav.gnss_estimated) known.push_back(&uav);
  if (known.empty())
    return Failure{"no_gnss",
                   "gnss.json of the truth or report.json of the run lack the receivers"};
  for (const RunUav* uav : known)
    common +=
        (uav->gnss_estimated->bias_m - uav->gnss_true->bias_m) / static_cast<double>(known.size());
  Json out = {{"common_bias_error_m", triple(common)}};
  std::vector<double> horizontal, vertical;
  for (const RunUav* uav : known) {
    const GnssFigures &truth = *uav->gnss_true, &estimate = *uav->gnss_estimated;
    const Eigen::Vector3d relative = estimate.bias_m - truth.bias_m - common;
    horizontal.push_back(relative.head<2>().norm());
    vertical.push_back(relative.z());
    out["per_uav"][uav->name] = {
        {"sigma_m", triple(estimate.sigma_m)},
        {"sigma_true_m", triple(truth.sigma_m)},
        {"sigma_ratio", triple(estimate.sigma_m.cwiseQuotient(truth.sigma_m))},
        {"sigma_ratio_95", ratioBounds(estimate.fixes)},
        {"bias_m", triple(estimate.bias_m)},
        {"bias_true_m", triple(truth.bias_m)},
        {"relative_bias_error_m", triple(relative)}};
  }
  out["relative_bias_rms_m"] = {{"horizontal", rms(horizontal)}, {"vertical", rms(vertical)}};
  return out;
}

}  // namespace cf
