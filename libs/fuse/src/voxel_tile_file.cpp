// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <fstream>
#include <type_traits>

#include "cf/base/error.h"
#include "voxel_tile.h"

namespace cf {
namespace {

template <class T>
void put(std::ofstream& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  out.write(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <class T>
void get(std::ifstream& in, T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  in.read(reinterpret_cast<char*>(&value), sizeof(T));
}

}  // namespace

void VoxelTile::save(const std::filesystem::path& path) const {
  std::ofstream out(path, std::ios::binary);
  put(out, size_);
  put(out, room_);
  put(out, view_);
  put(out, stamp_);
  for (const auto& block : blocks_) {
    put(out, block != nullptr);
    if (block) put(out, *block);
  }
  for (const auto& slab : slabs_) put(out, *slab);
  out.close();
  if (!out) throw RunError("cannot write " + path.string() + ": is the disk full?");
}

void VoxelTile::load(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  get(in, size_);
  get(in, room_);
  get(in, view_);
  get(in, stamp_);
  for (auto& block : blocks_) {
    bool filled = false;
    get(in, filled);
    if (!in) break;
    if (!filled) continue;
    block = std::make_unique<Block>();
    get(in, *block);
    ++filled_blocks_;
  }
  for (std::uint32_t begin = 0; in && begin < room_; begin += kSlabVoxels) {
    slabs_.push_back(std::make_unique<Slab>());
    get(in, *slabs_.back());
  }
  if (!in) throw RunError("cannot read " + path.string() + ": it was there before");
}

}  // namespace cf
