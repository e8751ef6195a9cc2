// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/image_header.h"

#include <cstring>

namespace cf {
namespace {

/// Bytes with their length; what lies beyond reads as zero.
struct Bytes {
  const std::uint8_t* data;
  std::size_t size;

  std::uint32_t at(std::size_t i) const { return i < size ? data[i] : 0; }
  std::uint32_t big(std::size_t i, int count) const {
    std::uint32_t value = 0;
    for (int k = 0; k < count; ++k) value = value << 8 | at(i + static_cast<std::size_t>(k));
    return value;
  }
  std::uint32_t little(std::size_t i, int count) const {
    std::uint32_t value = 0;
    for (int k = count - 1; k >= 0; --k) value = value << 8 | at(i + static_cast<std::size_t>(k));
    return value;
  }
  bool startsWith(const char* text, std::size_t count) const {
    return size >= count && std::memcmp(data, text, count) == 0;
  }
};

/// ITU-T T.81, B.2: segments up to the frame header.
ImageSize jpegSize(const Bytes& b) {
  for (std::size_t i = 2; i + 1 < b.size;) {
    if (b.at(i) != 0xFF) return {};
    const std::uint32_t marker = b.at(i + 1);
    if (marker == 0xFF) {  // filling
      ++i;
      continue;
    }
    const bool frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) return {b.big(i + 7, 2), b.big(i + 5, 2)};
    if (marker == 0xDA || marker == 0xD9) return {};
    const bool alone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    i += 2 + (alone ? 0 : b.big(i + 2, 2));
  }
  return {};
}

/// TIFF 6.0, section 2: width and height of the first directory.
ImageSize tiffSize(const Bytes& b) {
  const bool little = b.at(0) == 'I';
  const auto number = [&](std::size_t i, int count) {
    return little ? b.little(i, count) : b.big(i, count);
  };
  const std::size_t directory = number(4, 4);
  ImageSize size;
  for (std::size_t k = 0; k < number(directory, 2); ++k) {
    const std::size_t entry = directory + 2 + 12 * k;
    constexpr std::uint32_t kWidth = 256, kHeight = 257, kShort = 3;
    const std::uint32_t tag = number(entry, 2);
    const std::uint32_t value = number(entry + 8, number(entry + 2, 2) == kShort ? 2 : 4);
    if (tag == kWidth) size.width = value;
    if (tag == kHeight) size.height = value;
  }
  return size;
}

}  // namespace

std::optional<ImageSize> imageSizeOf(const std::uint8_t* bytes, std::size_t size) {
  const Bytes b{bytes, size};
  ImageSize found;
  if (b.startsWith("\xFF\xD8", 2))
    found = jpegSize(b);
  else if (b.startsWith("\x89PNG\r\n\x1A\n", 8))
    found = {b.big(16, 4), b.big(20, 4)};
  else if (b.startsWith("II*\0", 4) || b.startsWith("MM\0*", 4))
    found = tiffSize(b);
  if (found.width == 0 || found.height == 0) return std::nullopt;
  return found;
}

}  // namespace cf
