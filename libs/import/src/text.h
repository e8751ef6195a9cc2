// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cf/base/text.h"

namespace cf {

/// Words between white space.
std::vector<std::string> wordsOf(const std::string& text);
/// A finite number ("+1.5", "-3e2") that is the whole text; whatever the locale.
std::optional<double> numberFrom(const std::string& text);
/// All numbers in a text such as "(46) (50) (33.3855)".
std::vector<double> numbersIn(const std::string& text);

}  // namespace cf
