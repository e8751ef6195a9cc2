// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cf {

/// One zstd frame of the fastest level, its content's size in its header.
std::string zstdPressed(const std::vector<std::uint8_t>& bytes);

/// False: not a zstd frame of just `expected` bytes. Nothing is allocated before the frame itself
/// says that it holds as many.
bool zstdUnpress(std::string_view frame, std::size_t expected, std::vector<std::uint8_t>& out);

}  // namespace cf
