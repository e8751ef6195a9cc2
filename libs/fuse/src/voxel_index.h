// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace cf {

/// Rounds down. Without SSE4.1 std::floor is a call, and it is most of what a point costs.
inline std::int64_t floorToInt(double value) {
  const auto truncated = static_cast<std::int64_t>(value);
  return truncated - (static_cast<double>(truncated) > value ? 1 : 0);
}

/// Cell of a grid packed into 64 bits: 21 bits an axis, two's complement of that width.
struct CellKey {
  static constexpr int kBits = 21;
  static constexpr std::int64_t kLimit = std::int64_t{1} << (kBits - 1);

  static bool fits(std::int64_t i) { return i >= -kLimit && i < kLimit; }
  /// Ordered as (z, y, x) are.
  static std::uint64_t pack(std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::uint64_t>(z + kLimit) << (2 * kBits) |
           static_cast<std::uint64_t>(y + kLimit) << kBits | static_cast<std::uint64_t>(x + kLimit);
  }
  static std::int64_t x(std::uint64_t key) { return part(key, 0); }
  static std::int64_t y(std::uint64_t key) { return part(key, 1); }
  static std::int64_t z(std::uint64_t key) { return part(key, 2); }

 private:
  static std::int64_t part(std::uint64_t key, int axis) {
    return static_cast<std::int64_t>(key >> (axis * kBits) & ((1u << kBits) - 1)) - kLimit;
  }
};

/// Appends with less room to spare than push_back: the map's memory is bounded.
template <class T>
void appendTightly(std::vector<T>& to, const T& value) {
  if (to.size() == to.capacity()) to.reserve(to.size() + to.size() / 4 + 16);
  to.push_back(value);
}

/// Numbers distinct 64-bit keys 0, 1, 2… in the order of their arrival: a hash table with open
/// addressing and linear probing that holds the numbers, beside the dense list of keys. Values live
/// in the caller's own vectors, by number.
class VoxelIndex {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t find(std::uint64_t key) const {
    if (slots_.empty()) return kNone;
    for (std::size_t s = slotOf(key);; s = (s + 1) & mask_) {
      const std::uint32_t number = slots_[s];
      if (number == kNone || keys_[number] == key) return number;
    }
  }

  /// The number of `key`; a new key gets size() as it was before.
  std::uint32_t findOrAdd(std::uint64_t key) {
    if (2 * (keys_.size() + 1) > slots_.size()) grow();
    std::size_t s = slotOf(key);
    for (;; s = (s + 1) & mask_) {
      const std::uint32_t number = slots_[s];
      if (number == kNone) break;
      if (keys_[number] == key) return number;
    }
    const auto added = static_cast<std::uint32_t>(keys_.size());
    slots_[s] = added;
    appendTightly(keys_, key);
    return added;
  }

  std::size_t size() const { return keys_.size(); }
  const std::vector<std::uint64_t>& keys() const { return keys_; }
  std::size_t bytes() const {
    return slots_.capacity() * sizeof(slots_[0]) + keys_.capacity() * sizeof(keys_[0]);
  }

 private:
  /// Fibonacci hashing; the lowest two bits stay, so that neighbours along x share a cache line.
  std::size_t slotOf(std::uint64_t key) const {
    return (((key >> 2) * 0x9E3779B97F4A7C15u) >> shift_ & ~std::uint64_t{3}) | (key & 3);
  }

  void grow() {
    const std::size_t size = slots_.empty() ? 64 : 2 * slots_.size();
    mask_ = size - 1;
    shift_ = 64;
    for (std::size_t n = size; n > 1; n /= 2) --shift_;
    slots_.assign(size, kNone);
    for (std::uint32_t number = 0; number < keys_.size(); ++number) {
      std::size_t s = slotOf(keys_[number]);
      while (slots_[s] != kNone) s = (s + 1) & mask_;
      slots_[s] = number;
    }
  }

  std::vector<std::uint32_t> slots_;
  std::vector<std::uint64_t> keys_;
  std::size_t mask_ = 0;
  int shift_ = 0;
};

}  // namespace cf
