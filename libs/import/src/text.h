// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace cf {

/// All numbers in a text such as "(46) (50) (33.3855)".
std::vector<double> numbersIn(const std::string& text);

}  // namespace cf
