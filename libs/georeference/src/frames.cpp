// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/georeference/frames.h"

namespace cf {

Sim3 localToCentralLocal(const Sim3& S_w0_l0, const Eigen::Isometry3d& T_w0_wk,
                         const Sim3& S_wk_lk) {
  const Sim3 S_w0_wk{1, T_w0_wk.linear(), T_w0_wk.translation()};
  return S_w0_l0.inverse() * S_w0_wk * S_wk_lk;
}

}  // namespace cf
