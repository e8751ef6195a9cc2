// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cf {

/// Every breach of the house's rules in the tree at `root`, one line each, sorted: "FILE: what".
///  - libs include and link libs of lower floors only (table in house_rules.cpp,
///  docs/architecture.md)
///  - each lib uses its own outside libraries only, in public headers only Eigen and OpenCV core
///  - apps keep main.cpp small
///  - sources carry the SPDX lines, headers #pragma once
///  - no -march, -mavx or -ffast-math flag in CMake files
std::vector<std::string> houseBreaches(const std::filesystem::path& root);

}  // namespace cf
