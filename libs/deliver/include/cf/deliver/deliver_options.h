// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/base/options.h"

namespace cf {

/// Section [deliver].
struct DeliverOptions {
  bool html = true;
  bool las = true;
  bool dsm = true;
  bool orthophoto = true;
  double orthophoto_gsd_m = 0;  ///< 0 = automatic
  bool handover = true;
  bool depth_maps = false;

  void visit(OptionVisitor& v);
};

}  // namespace cf
