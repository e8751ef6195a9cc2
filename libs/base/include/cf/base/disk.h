// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace cf {

/// What has been written to a file is on the disk when it returns: before a file is renamed to its
/// final name, or a cut of power may leave an empty one there. False if it cannot be done.
bool syncFile(const std::filesystem::path& file);

/// A folder with all above it; one that is there already will do. Throws RunError naming it.
void createFolder(const std::filesystem::path& folder);

}  // namespace cf
