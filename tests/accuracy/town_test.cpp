// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Hills with houses and trees, three UAVs, receivers that disagree, a wrong focal length.
#include "scene.h"

namespace cf {
namespace {

// About 1.3 to 1.5 times what is reached; what the noise of the fixes decides (scale, biases), and
// with it the size under se3, twice what that noise makes of it.
const std::vector<Limit> kLimits = {
    exactly("/report/components", 1),
    exactly("/report/photos/total", 34),
    exactly("/photos/posed", 34),
    within("/trajectory/sim3/rmse_m", 0.035),
    within("/trajectory/se3/rmse_m", 0.2),
    within("/trajectory/sim3/rotation_rmse_deg", 0.026),
    within("/trajectory/sim3/scale", 0.006, 1),
    within("/scale/error_end_pct/median", 1.0),
    within("/uav_pairs/rotation_rms_deg", 0.011),
    within("/uav_pairs/translation_rms_m", 0.03),
    within("/relative_poses/rotation_deg/median", 0.28),
    within("/relative_poses/direction_deg/median", 0.85),
    within("/seam/all/horizontal_gsd/median", 0.04),
    within("/seam/all/vertical_gsd/median", 0.05),
    within("/seam/all/vertical_gsd/p95", 0.25),
    within("/ground/all/vertical_m/median", 0.16),
    within("/doming/span_m", 0.03),
    within("/camera/focal_rms_pct", 0.15),
    within("/gnss/relative_bias_rms_m/horizontal", 0.6),
    within("/gnss/relative_bias_rms_m/vertical", 1.2),
    within("/depth/scaled/matched_pixels/median", 2.7),
    within("/depth/scaled/matched_pixels/nmad", 1.1),
    atLeast("/depth/completeness", 0.84),
    within("/cloud/height/matched_pixels/bias", 2.5),
    within("/cloud/height/matched_pixels/nmad", 1.2),
    within("/cloud/height/without_bend_matched_pixels/nmad", 1.1),
    atLeast("/cloud/completeness", 0.85),
    atLeast("/cloud/coverage", 0.89),
    within("/cloud/flying/share", 0.016),
};

class Town : public AccuracyScene {};

TEST_F(Town, FiguresKeepTheirLimits) { hold("town", kLimits); }

}  // namespace
}  // namespace cf
