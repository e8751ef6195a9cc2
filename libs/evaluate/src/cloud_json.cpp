// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cf/evaluate/cloud.h"

namespace cf {
namespace {

using Json = nlohmann::ordered_json;

Json jsonOf(const DistanceFigures& figures, std::optional<double> gsd_m) {
  Json json = {{"median_m", figures.median_m},
               {"rms_m", figures.rms_m},
               {"nmad_m", figures.nmad_m},
               {"p95_m", figures.p95_m}};
  if (gsd_m) {
    json["median_gsd"] = figures.median_m / *gsd_m;
    json["rms_gsd"] = figures.rms_m / *gsd_m;
    json["nmad_gsd"] = figures.nmad_m / *gsd_m;
    json["p95_gsd"] = figures.p95_m / *gsd_m;
  }
  for (std::size_t k = 0; k < kDistanceLimits_m.size(); ++k)
    json["share_within"][fmt::format("{}m", kDistanceLimits_m[k])] = figures.share_within[k];
  return json;
}

}  // namespace

std::string toJson(const CloudEvaluation& evaluation, std::optional<double> gsd_m) {
  Json json = {{"align", evaluation.icp ? "icp" : "none"},
               {"world_origins", evaluation.common_world ? "both known" : "taken as the same"},
               {"estimate_points", evaluation.estimate_points},
               {"reference_points", evaluation.reference_points},
               {"sampled", evaluation.sampled},
               {"compared", evaluation.compared},
               {"compared_share", static_cast<double>(evaluation.compared) /
                                      static_cast<double>(evaluation.sampled)}};
  if (gsd_m) json["gsd_m"] = *gsd_m;
  json["plane"] = jsonOf(evaluation.plane, gsd_m);
  json["plane"]["bias_m"] = evaluation.plane_bias_m;
  json["nearest"] = jsonOf(evaluation.nearest, gsd_m);
  json["completeness"] = {{"0.5m", evaluation.completeness_050},
                          {"1m", evaluation.completeness_100}};
  if (evaluation.icp) {
    const Registration& icp = *evaluation.icp;
    json["icp"] = {{"shift_m", {icp.shift_m.x(), icp.shift_m.y(), icp.shift_m.z()}},
                   {"rotation_deg", icp.rotation_deg},
                   {"inlier_share", icp.inlier_share},
                   {"inlier_rms_m", icp.inlier_rms_m}};
  }
  return json.dump(2);
}

}  // namespace cf
