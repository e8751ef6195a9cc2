// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "zstd_bytes.h"

#include <zstd.h>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr int kLevel = 1;

}  // namespace

std::string zstdPressed(const std::vector<std::uint8_t>& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw RunError("zstd cannot compress: out of memory");
  out.resize(size);
  return out;
}

bool zstdUnpress(std::string_view frame, std::size_t expected, std::vector<std::uint8_t>& out) {
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != expected) return false;
  out.resize(expected);
  return ZSTD_decompress(out.data(), out.size(), frame.data(), frame.size()) == expected;
}

}  // namespace cf
