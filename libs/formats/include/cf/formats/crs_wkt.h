// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "cf/types/gnss_fix.h"

namespace cf {

/// The well-known text (OGC 01-009, which LAS 1.4 asks for) of a projected system and, where it is
/// known what heights count from, of that too: COMPD_CS with mean sea level (EPSG:5714) or the
/// ellipsoid (vertical datum type 2002). Throws RunError where `epsg` is no projected system.
std::string crsWkt(int epsg, HeightDatum datum);

}  // namespace cf
