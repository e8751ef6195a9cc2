// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace cf {

struct ImageSize {
  std::uint32_t width = 0, height = 0;  ///< [px], as stored, above 0
};

/// The size that the header of a JPEG, PNG or TIFF tells, without decoding anything: for judging a
/// file before memory is taken for it. None for other formats and for broken headers.
std::optional<ImageSize> imageSizeOf(const std::uint8_t* bytes, std::size_t size);

}  // namespace cf
