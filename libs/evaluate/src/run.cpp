// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/run.h"

#include "cf/base/error.h"
#include "ground_points.h"
#include "run_cloud.h"
#include "run_depth.h"
#include "run_poses.h"
#include "run_scale.h"
#include "run_sensors.h"
#include "truth_views.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

void add(Json& out, const char* name, const RunSection& section) {
  out[name] = section ? *section : Json(nullptr);
  if (!section) out["missing"][name] = section.failure().detail;
}

/// Everything that needs the true depth maps.
void addGround(Json& out, const RunInputs& run, const std::vector<TruthView>& views,
               const Sim3& S_ref_est) {
  if (views.empty()) {
    const Failure none{"no_truth", "the truth has neither depth maps nor dsm.tif"};
    for (const char* name : {"seam", "ground", "doming", "depth"}) add(out, name, none);
    return;
  }
  const std::vector<GroundPoint> points = mapGroundPoints(run, views, S_ref_est);
  add(out, "seam", seamFigures(run, points));
  add(out, "ground", groundFigures(run, points));
  add(out, "doming", domingFigures(points));
  add(out, "depth", depthFigures(run, views, S_ref_est.scale));
}

}  // namespace

std::string evaluateRun(const fs::path& out_dir, const fs::path& truth_dir) {
  const RunInputs run = readRun(out_dir, truth_dir);
  Json out = {{"missing", Json::object()}, {"photos", photoFigures(run)}};
  add(out, "trajectory", trajectoryFigures(run));
  add(out, "consistency", consistencyFigures(run));
  add(out, "scale", scaleFigures(run));
  add(out, "relative_poses", relativePoseFigures(run));
  add(out, "camera", cameraFigures(run));
  add(out, "gnss", gnssFigures(run));
  const std::vector<TruthView> views = readTruthViews(run);
  const Result<Sim3> S_ref_est = alignCluster(run);
  if (S_ref_est) {
    add(out, "uav_pairs", pairFigures(run, *S_ref_est));
    addGround(out, run, views, *S_ref_est);
    add(out, "cloud", cloudFigures(run, views, *S_ref_est, matchedGroundSize(run, views)));
  } else {
    const Failure none{"not_aligned", "the cluster cannot be aligned with the truth: " +
                                          S_ref_est.failure().detail};
    for (const char* name : {"uav_pairs", "seam", "ground", "doming", "depth", "cloud"})
      add(out, name, none);
  }
  return out.dump(2);
}

}  // namespace cf
