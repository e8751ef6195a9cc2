// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "cf/types/tile.h"

namespace cf {

/// Writes a tile as a binary PCD 0.7 file that PCL's tools read: x y z (float, tile-relative
/// metres), rgb (PCL's packed float), confidence (float), views (uint16). The tile's offset in the
/// world is kept exactly in a comment line. Atomic. Throws RunError.
void writePcd(const std::filesystem::path& path, const Tile& tile);

/// Reads what writePcd wrote, and any other binary PCD with x y z as floats: fields are found by
/// name in any order, unknown ones are skipped, missing ones are zero. Tile::index is not in the
/// file. Throws RunError where the file is no such PCD or is cut short.
Tile readPcd(const std::filesystem::path& path);

}  // namespace cf
