// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace cf {

/// "; did you mean 'X'?" with the candidate nearest to `word` by edit distance (case ignored), or
/// "; known are: A, B" where none is near. Empty without candidates.
std::string suggestion(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace cf
