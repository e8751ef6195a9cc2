// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace cf {

/// All of a file. None if it cannot be read.
std::optional<std::string> fileBytes(const std::filesystem::path& path);

}  // namespace cf
