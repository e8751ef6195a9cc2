// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/densify/densify.h"

namespace cf {

void DensifyOptions::visit(OptionVisitor& visitor) {
  visitor.number("megapixels", megapixels, {0.05, 50},
                 "size of the matched common area of a stereo pair [MP], never above the photos'");
  visitor.choice("matcher", matcher, {"sgm", "elas"}, "dense stereo matcher");
  visitor.integer("partners", partners, {1, 8}, "stereo partners of a photo");
  visitor.number("min_baseline_over_depth", min_baseline_over_depth, {0.001, 2},
                 "shortest baseline of a pair, as a share of the scene's distance");
  visitor.number("max_baseline_over_depth", max_baseline_over_depth, {0.01, 3},
                 "longest baseline of a pair, as a share of the scene's distance");
  visitor.number("max_convergence_deg", max_convergence_deg, {1, 60},
                 "largest angle between the optical axes of a pair [deg]");
  visitor.number("min_overlap", min_overlap, {0.05, 1},
                 "share of the reference photo that its partner must see");
  visitor.integer("min_confidence", min_confidence, {1, 255},
                  "matches of less confidence are dropped [0..255]");
}

}  // namespace cf
