// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cf {

/// Without the white space at both ends.
std::string trimmed(const std::string& text);

/// Words between white space.
std::vector<std::string> wordsOf(const std::string& text);

/// A finite number ("+1.5", "-3e2") that is the whole text but for white space at both ends;
/// whatever the locale.
std::optional<double> numberFrom(const std::string& text);

/// Fit for one line: names of files and what they hold as they are, but for control characters,
/// each of which becomes a '?'.
std::string printable(std::string text);

}  // namespace cf
