// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cf/types/depth_frame.h"

namespace cf {

/// A depth frame as bytes: disparity and confidence lossless (zstd), colour as JPEG of quality 90
/// if there is any, a checksum at the end. About 1.2 bytes a pixel, a third of it colour.
std::string encodeDepthFrame(const DepthFrame& frame);

/// Throws RunError naming `source` on anything but what encodeDepthFrame wrote.
DepthFrame decodeDepthFrame(const std::string& bytes, const std::string& source);

/// The file appears whole or not at all. Throws RunError naming the path.
void writeDepthFrame(const std::filesystem::path& path, const DepthFrame& frame);
DepthFrame readDepthFrame(const std::filesystem::path& path);
/// None if it is absent, damaged or of another version: the pair has to be matched again.
std::optional<DepthFrame> tryReadDepthFrame(const std::filesystem::path& path);

}  // namespace cf
