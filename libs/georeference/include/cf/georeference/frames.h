// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/types/sim3.h"

namespace cf {

/// Stage 2: from the local frame l_k of a segment of UAV k to the local frame l_0 of the central
/// UAV, S_l0_lk = S_w0_l0^-1 T_w0_wk S_wk_lk, where w_k is the ENU frame of UAV k. The print leaves
/// out T_w0_wk's rotation: two ENU frames 1 km apart differ by about 0.01 degrees.
Sim3 localToCentralLocal(const Sim3& S_w0_l0, const Eigen::Isometry3d& T_w0_wk,
                         const Sim3& S_wk_lk);

}  // namespace cf
