// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Flat fields in rows, two UAVs at different heights, one receiver 8 m too high.
#include "scene.h"

namespace cf {
namespace {

// About 1.3 to 1.5 times what is reached; what the noise of the fixes decides (scale, biases), and
// with it the size under se3, twice what that noise makes of it.
const std::vector<Limit> kLimits = {
    exactly("/report/components", 1),
    exactly("/report/photos/total", 30),
    exactly("/photos/posed", 30),
    within("/trajectory/sim3/rmse_m", 0.055),
    within("/trajectory/se3/rmse_m", 0.35),
    within("/trajectory/sim3/rotation_rmse_deg", 0.1),
    within("/trajectory/sim3/scale", 0.01, 1),
    within("/scale/error_end_pct/median", 1.0),
    within("/uav_pairs/rotation_rms_deg", 0.055),
    within("/uav_pairs/translation_rms_m", 0.07),
    within("/relative_poses/rotation_deg/median", 0.09),
    within("/relative_poses/direction_deg/median", 0.46),
    within("/seam/all/horizontal_gsd/median", 0.035),
    within("/seam/all/vertical_gsd/median", 0.045),
    within("/seam/all/vertical_gsd/p95", 0.25),
    within("/ground/all/vertical_m/median", 0.18),
    within("/doming/span_m", 0.22),
    within("/camera/focal_rms_pct", 0.5),
    within("/gnss/relative_bias_rms_m/vertical", 2),
    within("/depth/scaled/matched_pixels/median", 2.7),
    within("/depth/scaled/matched_pixels/nmad", 0.9),
    atLeast("/depth/completeness", 0.91),
    within("/cloud/height/matched_pixels/bias", 2.6),
    within("/cloud/height/matched_pixels/nmad", 1.8),
    within("/cloud/height/without_bend_matched_pixels/nmad", 0.95),
    atLeast("/cloud/completeness", 0.85),
    atLeast("/cloud/coverage", 0.89),
    within("/cloud/flying/share", 0.003),
};

class Fields : public AccuracyScene {};

TEST_F(Fields, FiguresKeepTheirLimits) { hold("fields", kLimits); }

}  // namespace
}  // namespace cf
