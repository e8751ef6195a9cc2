// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "cf/deliver/ground_control_record.h"

namespace cf {

/// `ground_control` of report.json (docs/evaluation.md).
nlohmann::ordered_json groundControlJson(const GroundControlRecord& record);

/// A section of report.html.
std::string groundControlHtml(const GroundControlRecord& record);

}  // namespace cf
