// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace cf {

/// All figures of a run on a simulated flight: one JSON object as docs/evaluation.md describes it.
/// `truth_dir` is the folder truth/ of cf-simulate. What cannot be computed is null, and "missing"
/// says why. Throws RunError where one of the folders is not what it should be, or a file of theirs
/// cannot be understood.
std::string evaluateRun(const std::filesystem::path& out_dir,
                        const std::filesystem::path& truth_dir);

/// The chief figures of such a JSON object as a table for people.
std::string runTable(const std::string& json);

}  // namespace cf
