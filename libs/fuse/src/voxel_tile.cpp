// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "voxel_tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace cf {
namespace {

std::uint16_t saturatedSum(std::uint16_t a, std::uint16_t b) {
  return static_cast<std::uint16_t>(std::min<std::uint32_t>(65535u, std::uint32_t{a} + b));
}

}  // namespace

VoxelTile::VoxelTile(TileIndex index, double tile_m, double voxel_m)
    : index_(index),
      offset_m_(index.x * tile_m, index.y * tile_m, 0),
      voxel_m_(voxel_m, voxel_m, kHeightOverSide * voxel_m),
      inverse_voxel_(voxel_m_.cwiseInverse()) {}

std::int64_t VoxelTile::cellOf(double relative_m, int axis) const {
  const std::int64_t cell = floorToInt(relative_m * inverse_voxel_[axis]);
  // A point on the tile's lower edge may fall a rounding error outside of it.
  return axis < 2 ? std::max<std::int64_t>(cell, 0) : cell;
}

bool VoxelTile::locate(const Eigen::Vector3d& relative_m, Place& place) const {
  if (!(std::abs(relative_m.z() * inverse_voxel_.z()) < CellKey::kLimit - 1)) return false;
  std::int64_t cell[3];
  for (int k = 0; k < 3; ++k) {
    cell[k] = cellOf(relative_m[k], k);
    place.rest[k] = static_cast<float>(relative_m[k] * inverse_voxel_[k] -
                                       (static_cast<double>(cell[k]) + 0.5));
  }
  place.key = CellKey::pack(cell[0], cell[1], cell[2]);
  return true;
}

VoxelTile::Voxel& VoxelTile::voxelAt(const Place& place) {
  const std::uint32_t number = numbers_.findOrAdd(place.key);
  if (number == voxels_.size()) appendTightly(voxels_, Voxel{});
  return voxels_[number];
}

std::size_t VoxelTile::add(const MapPoint* begin, const MapPoint* end, std::uint32_t view) {
  // In blocks, each memory access asked for ahead of its use: waiting for them is most of the time.
  constexpr std::size_t kBlock = 32;
  std::array<Place, kBlock> places;
  std::array<const MapPoint*, kBlock> points;
  std::size_t merged = 0;
  while (begin != end) {
    std::size_t n = 0;
    for (; begin != end && n < kBlock; ++begin) {
      if (!locate(begin->position_m - offset_m_, places[n])) continue;
      numbers_.prefetchSlot(places[n].key);
      points[n++] = begin;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t number = numbers_.prefetchKey(places[i].key);
      if (number < voxels_.size()) __builtin_prefetch(&voxels_[number], 1);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const MapPoint& point = *points[i];
      Voxel& voxel = voxelAt(places[i]);
      voxel.weight += point.weight;
      for (int k = 0; k < 3; ++k) {
        voxel.offset[k] += point.weight * places[i].rest[k];
        voxel.bgr[k] += point.weight * static_cast<float>(point.bgr[k]);
      }
      if (voxel.last_view == view) continue;
      voxel.last_view = view;
      voxel.views = saturatedSum(voxel.views, 1);
    }
    merged += n;
  }
  return merged;
}

void VoxelTile::merge(const Tile& tile) {
  const Eigen::Vector3d shift = tile.offset_m - offset_m_;
  for (const TilePoint& point : tile.points) {
    Place place;
    if (!locate(point.position_m.cast<double>() + shift, place)) continue;
    Voxel& voxel = voxelAt(place);
    voxel.weight += point.confidence;
    for (int k = 0; k < 3; ++k) {
      voxel.offset[k] += point.confidence * place.rest[k];
      voxel.bgr[k] += point.confidence * static_cast<float>(point.bgr[k]);
    }
    voxel.views = saturatedSum(voxel.views, point.views);
  }
}

float VoxelTile::positionInCell(double relative_m, std::int64_t cell, int axis) const {
  auto position = static_cast<float>(relative_m);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  while (cellOf(position, axis) > cell) position = std::nextafter(position, -kInfinity);
  while (cellOf(position, axis) < cell) position = std::nextafter(position, kInfinity);
  return position;
}

Tile VoxelTile::toTile() const {
  const std::vector<std::uint64_t>& keys = numbers_.keys();
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  order.reserve(keys.size());
  for (std::uint32_t number = 0; number < keys.size(); ++number)
    order.emplace_back(keys[number], number);
  std::sort(order.begin(), order.end());

  Tile tile;
  tile.index = index_;
  tile.offset_m = offset_m_;
  tile.points.reserve(voxels_.size());
  for (const auto& [key, number] : order) {
    const Voxel& voxel = voxels_[number];
    const std::int64_t cell[3] = {CellKey::x(key), CellKey::y(key), CellKey::z(key)};
    TilePoint point;
    for (int k = 0; k < 3; ++k) {
      const double mean = static_cast<double>(voxel.offset[k]) / voxel.weight;
      point.position_m[k] =
          positionInCell((static_cast<double>(cell[k]) + 0.5 + mean) * voxel_m_[k], cell[k], k);
      point.bgr[k] =
          static_cast<std::uint8_t>(std::clamp(std::lround(voxel.bgr[k] / voxel.weight), 0L, 255L));
    }
    point.views = voxel.views;
    point.confidence = voxel.weight;
    tile.points.push_back(point);
  }
  return tile;
}

std::size_t VoxelTile::bytes() const {
  return numbers_.bytes() + voxels_.capacity() * sizeof(Voxel);
}

}  // namespace cf
