// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Two fixed wings, banked turns, wind, a gap in the photos, an outage and outliers of GNSS.
#include "scene.h"

namespace cf {
namespace {

// About 1.3 to 1.5 times what is reached; what the noise of the fixes decides (scale), and
// with it the size under se3, twice what that noise makes of it.
const std::vector<Limit> kLimits = {
    exactly("/report/components", 1),
    exactly("/report/photos/total", 35),
    exactly("/photos/posed", 35),
    within("/trajectory/sim3/rmse_m", 0.025),
    within("/trajectory/se3/rmse_m", 0.9),
    within("/trajectory/sim3/rotation_rmse_deg", 0.025),
    within("/trajectory/sim3/scale", 0.012, 1),
    within("/scale/error_end_pct/median", 1.5),
    within("/uav_pairs/rotation_rms_deg", 0.014),
    within("/uav_pairs/translation_rms_m", 0.025),
    within("/relative_poses/rotation_deg/median", 0.09),
    within("/relative_poses/direction_deg/median", 1.9),
    within("/seam/all/horizontal_gsd/median", 0.032),
    within("/seam/all/vertical_gsd/median", 0.045),
    within("/seam/all/vertical_gsd/p95", 0.15),
    within("/ground/all/vertical_m/median", 0.13),
    within("/doming/span_m", 0.09),
    within("/camera/focal_rms_pct", 0.12),
    within("/depth/scaled/matched_pixels/median", 1.7),
    within("/depth/scaled/matched_pixels/nmad", 0.95),
    atLeast("/depth/completeness", 0.8),
    within("/cloud/height/matched_pixels/bias", 1.4),
    within("/cloud/height/matched_pixels/nmad", 1.0),
    within("/cloud/height/without_bend_matched_pixels/nmad", 0.88),
    atLeast("/cloud/completeness", 0.45),
    atLeast("/cloud/coverage", 0.53),
    within("/cloud/flying/share", 0.019),
};

class Wing : public AccuracyScene {};

TEST_F(Wing, FiguresKeepTheirLimits) { hold("wing", kLimits); }

}  // namespace
}  // namespace cf
