// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/self_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cf/deliver/run_record.h"
#include "gnss_residuals.h"
#include "reprojection.h"
#include "seam_cells.h"
#include "summary.h"

namespace cf {
namespace {

/// Limits; docs/self_check.md explains them.
constexpr double kPhotosGreen = 0.98, kPhotosAmber = 0.9;
constexpr double kSeamGreen = 2, kSeamAmber = 6;            ///< pixels of the photos on the ground
constexpr double kDomingGreen = 3, kDomingAmber = 10;       ///< pixels of the photos on the ground
constexpr double kLensGreen = 0.0002, kLensAmber = 0.0006;  ///< of the photo's width
constexpr double kGnssGreen = 2, kGnssAmber = 4;            ///< times what the receivers tag
constexpr double kDepthGreen = 0.6, kDepthAmber = 0.4;

/// Grades the value against its limits.
SelfCheck graded(SelfCheck check) {
  const double sign = check.more_is_better ? -1 : 1, value = sign * *check.value;
  check.grade = value <= sign * check.green   ? Grade::kGreen
                : value <= sign * check.amber ? Grade::kAmber
                                              : Grade::kRed;
  return check;
}

/// No better than `grade`.
void atBest(Grade grade, SelfCheck& check) { check.grade = std::max(check.grade, grade); }

SelfCheck photosCheck(const RunRecord& run) {
  const PhotoTotals totals = totalsOf(run);
  SelfCheck check;
  check.name = "photos";
  check.title = "Photos placed";
  check.value = totals.total > 0 ? static_cast<double>(totals.posed) / totals.total : 0;
  check.unit = "share";
  check.green = kPhotosGreen;
  check.amber = kPhotosAmber;
  check.more_is_better = true;
  check.finding =
      fmt::format("{} of {} photos have a place in the map", totals.posed, totals.total);
  check.advice = "see the list of photos without a pose; fly with more overlap where they lie";
  check = graded(check);
  if (run.components > 1) {
    check.finding +=
        fmt::format("; they form {} parts that no match joins, only GNSS", run.components);
    check.advice = "parts that only GNSS joins lie metres apart: fly them with overlap";
    atBest(Grade::kAmber, check);
  }
  return check;
}

SelfCheck seamCheck(const RunRecord& run, double pixel_m) {
  SelfCheck check;
  check.name = "seam";
  check.title = "Seam between UAVs";
  check.unit = "m";
  check.green = kSeamGreen * pixel_m;
  check.amber = kSeamAmber * pixel_m;
  const auto seam = seamOf(run.seam_points);
  if (!seam) {
    check.finding = run.uavs.size() < 2 ? "one UAV alone: there is no seam"
                                        : "no place of the map is seen well enough from two UAVs";
    if (run.uavs.size() > 1) {
      check.grade = Grade::kAmber;
      check.advice = "only GNSS ties the UAVs together: let their flights overlap";
    }
    return check;
  }
  check.value = seam->rms_m;
  check.finding = fmt::format(
      "the same ground, seen by one UAV and by another, lies {:.3f} m apart (RMS of {} places; "
      "worst {:.3f} m); a pixel of the photos is {:.3f} m",
      seam->rms_m, seam->cells.size(), seam->worst_m, pixel_m);
  check.advice =
      "see where on the seam map; more overlap between the UAVs, or [align] method = joint if it "
      "is not";
  return graded(check);
}

/// Root mean square of the predicted height errors of the photos after the best fit of the whole
/// map, of its first part; none where the adjustment told no covariances.
std::optional<double> predictedBend(const RunRecord& run) {
  double sum = 0;
  int count = 0;
  for (const UavRecord& uav : run.uavs)
    for (const auto& [photo, known] : uav.covariances) {
      if (known.component != 0 || known.covariance.in_map.isZero(0)) continue;
      sum += known.covariance.in_map(2, 2);
      ++count;
    }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / count);
}

SelfCheck domingCheck(const RunRecord& run, double pixel_m) {
  SelfCheck check;
  check.name = "doming";
  check.title = "Bending of the map";
  check.unit = "m";
  check.green = kDomingGreen * pixel_m;
  check.amber = kDomingAmber * pixel_m;
  const auto found = run.world.relative ? std::nullopt : bendAgainstGnss(run);
  const bool seen = found.has_value();
  const Bend bend = found.value_or(Bend{});
  const auto predicted = predictedBend(run);
  std::vector<std::string> findings;
  if (predicted)
    findings.push_back(
        fmt::format("by its own covariance heights bend by {:.3f} m (σ)", *predicted));
  if (seen)
    findings.push_back(
        fmt::format("against the receivers' heights the map bends by {:.2f} ± {:.2f} m",
                    bend.span_m, bend.sigma_m));
  check.finding = findings.empty() ? "neither a covariance nor GNSS heights tell of it"
                                   : fmt::format("{}", fmt::join(findings, "; "));
  check.advice =
      "fly some photos at another height or aslant, or across the strips; give a calibrated camera "
      "(cf-import --camera); measure ground points in the middle and at the edges";
  if (!predicted && !seen) {
    check.grade = Grade::kAmber;
    return check;
  }
  // Four: noise alone gives three free terms a span of up to that many.
  const double measured = std::max(0.0, bend.span_m - 4 * bend.sigma_m);
  check.value = std::max(measured, 2 * predicted.value_or(0));
  check = graded(check);
  if (!predicted && bend.sigma_m > check.green) atBest(Grade::kAmber, check);
  return check;
}

SelfCheck lensCheck(const RunRecord& run) {
  SelfCheck check;
  check.name = "lens";
  check.title = "Lens";
  check.unit = "px";
  const auto all = reprojectionsOf(run);
  double worst = 0;
  for (std::size_t u = 0; u < all.size(); ++u) {
    if (all[u].errors_px.empty()) continue;
    const double width = run.uavs[u].camera_after.width;
    if (check.value && all[u].systematic_px / width <= worst) continue;
    worst = all[u].systematic_px / width;
    check.value = all[u].systematic_px;
    check.green = kLensGreen * width;
    check.amber = kLensAmber * width;
    check.finding = fmt::format(
        "what all photos of {} have in common in a part of the picture is {:.2f} px (RMS) off; "
        "single points {:.2f} px (median)",
        run.uavs[u].name, all[u].systematic_px, all[u].median_px);
  }
  if (!check.value) {
    check.finding = "no points to tell by";
    return check;
  }
  check.advice =
      "the camera's model does not fit: let it be refined ([align] refine_cameras), or give a "
      "calibration";
  return graded(check);
}

SelfCheck gnssCheck(const RunRecord& run) {
  SelfCheck check;
  check.name = "gnss";
  check.title = "GNSS against the map";
  check.unit = "times the tagged σ";
  check.green = kGnssGreen;
  check.amber = kGnssAmber;
  const UavRecord* worst = nullptr;
  bool any_trusted = false;
  for (const UavRecord& uav : run.uavs) {
    const auto residuals = gnssResiduals(uav);
    if (residuals.size() < 3) continue;
    const double ratio = gnssNoiseRatio(residuals);
    any_trusted |= uav.gnss.trusted;
    if (check.value && ratio <= *check.value) continue;
    check.value = ratio;
    worst = &uav;
  }
  check.advice =
      "place, heading and scale of the map are only as good as the receivers: measure ground "
      "points "
      "and give them as [gcp] control";
  if (worst == nullptr) {
    check.finding = "no photo has a GNSS position: place, heading and scale are arbitrary";
    check.grade = Grade::kAmber;
    return check;
  }
  check.finding = fmt::format(
      "fixes of {} scatter {:.1f} times as much about the map as they are tagged (estimated σ "
      "{:.1f} / {:.1f} / {:.1f} m east / north / up)",
      worst->name, *check.value, worst->gnss.sigma_m.x(), worst->gnss.sigma_m.y(),
      worst->gnss.sigma_m.z());
  check = graded(check);
  if (!any_trusted) {
    check.finding += "; no receiver can be trusted";
    atBest(Grade::kRed, check);
  }
  return check;
}

SelfCheck depthCheck(const RunRecord& run) {
  SelfCheck check;
  check.name = "depth";
  check.title = "Consistent depth";
  check.unit = "share";
  check.green = kDepthGreen;
  check.amber = kDepthAmber;
  check.more_is_better = true;
  if (run.cloud.total() == 0) {
    check.grade = Grade::kRed;
    check.finding = "there is no dense map";
    check.advice = "see the warnings: photos without a pose, or without a partner for stereo";
    return check;
  }
  check.value = static_cast<double>(run.cloud.confirmed()) / static_cast<double>(run.cloud.total());
  check.finding = fmt::format(
      "{:.0f} % of {:.2f} million points were measured at the same place by at "
      "least two stereo pairs",
      100 * *check.value, 1e-6 * static_cast<double>(run.cloud.total()));
  check.advice = "more overlap; points that one pair saw alone have views = 1 in cloud/tiles";
  return graded(check);
}

}  // namespace

const char* name(Grade grade) {
  switch (grade) {
    case Grade::kGreen:
      return "green";
    case Grade::kAmber:
      return "amber";
    case Grade::kRed:
      return "red";
    case Grade::kUntested:
      return "untested";
  }
  return "untested";
}

std::vector<SelfCheck> selfCheck(const RunRecord& run) {
  const double pixel_m = groundPixel(run);
  std::vector<SelfCheck> checks = {
      photosCheck(run), seamCheck(run, pixel_m), domingCheck(run, pixel_m),
      lensCheck(run),   gnssCheck(run),          depthCheck(run)};
  for (SelfCheck& check : checks)
    if (check.grade == Grade::kGreen) check.advice.clear();
  return checks;
}

std::vector<std::string> doubts(const std::vector<SelfCheck>& checks) {
  std::vector<std::string> lines;
  for (const SelfCheck& check : checks)
    if (check.grade == Grade::kAmber || check.grade == Grade::kRed)
      lines.push_back(fmt::format("doubtful ({}): {}: {}; {}", name(check.grade), check.title,
                                  check.finding, check.advice));
  if (lines.empty())
    lines.push_back("nothing doubtful: the self-check of the run is green (see report.html)");
  return lines;
}

}  // namespace cf
