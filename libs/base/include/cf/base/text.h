// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cf {

/// Without the white space at both ends.
std::string trimmed(const std::string& text);

}  // namespace cf
