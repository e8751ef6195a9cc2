// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/tile_store.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "cf/base/disk.h"
#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/pcd.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

std::string fileName(TileIndex index) { return fmt::format("{}_{}.pcd", index.x, index.y); }

/// The tile that a file's name stands for; none for other files.
std::optional<TileIndex> indexOf(const fs::path& file) {
  static const std::regex pattern("(-?[0-9]{1,9})_(-?[0-9]{1,9})\\.pcd");
  const std::string name = file.filename().string();
  std::smatch match;
  if (!std::regex_match(name, match, pattern)) return std::nullopt;
  return TileIndex{std::stoi(match[1]), std::stoi(match[2])};
}

}  // namespace

DirectoryTileStore::DirectoryTileStore(fs::path directory, double tile_size_m, double voxel_size_m)
    : directory_(std::move(directory)), tile_size_m_(tile_size_m), voxel_size_m_(voxel_size_m) {}

DirectoryTileStore DirectoryTileStore::create(const fs::path& directory, double tile_size_m,
                                              double voxel_size_m) {
  createFolder(directory / "tiles");
  for (const auto& item : fs::directory_iterator(directory / "tiles")) {
    const bool temporary = item.path().extension() == ".tmp" && indexOf(item.path().stem());
    if (temporary || indexOf(item.path())) fs::remove(item.path());
  }
  DirectoryTileStore store(directory, tile_size_m, voxel_size_m);
  store.flush();
  return store;
}

DirectoryTileStore DirectoryTileStore::open(const fs::path& directory) {
  const fs::path list = directory / "tiles.json";
  const auto fail = [&](const std::string& what) {
    return RunError(list.string() + ": cannot be read: " + what);
  };
  std::ifstream in(list);
  if (!in) throw fail("there are no tiles here");
  try {
    const nlohmann::json json = nlohmann::json::parse(in);
    DirectoryTileStore store(directory, json.at("tile_size_m"), json.at("voxel_size_m"));
    if (!(store.tile_size_m_ > 0 && store.voxel_size_m_ > 0))
      throw fail("its sizes must be above zero");
    for (const auto& item : fs::directory_iterator(directory / "tiles")) {
      if (const auto index = indexOf(item.path())) {
        const Tile tile = readPcd(item.path());
        store.entries_[*index] = {tile.offset_m, tile.points.size()};
      }
    }
    return store;
  } catch (const nlohmann::json::exception& error) {
    throw fail(error.what());
  } catch (const fs::filesystem_error& error) {
    throw fail(error.what());
  }
}

fs::path DirectoryTileStore::file(TileIndex index) const {
  return directory_ / "tiles" / fileName(index);
}

std::optional<Tile> DirectoryTileStore::load(TileIndex index) {
  if (entries_.count(index) == 0) return std::nullopt;
  Tile tile = readPcd(file(index));
  tile.index = index;
  return tile;
}

void DirectoryTileStore::save(const Tile& tile) {
  writePcd(file(tile.index), tile);
  entries_[tile.index] = {tile.offset_m, tile.points.size()};
}

std::vector<TileIndex> DirectoryTileStore::indices() const {
  std::vector<TileIndex> result;
  result.reserve(entries_.size());
  for (const auto& [index, entry] : entries_) result.push_back(index);
  return result;
}

void DirectoryTileStore::flush() {
  nlohmann::ordered_json json;
  json["tile_size_m"] = tile_size_m_;
  json["voxel_size_m"] = voxel_size_m_;
  json["fields"] = {"x", "y", "z", "rgb", "confidence", "views"};
  json["tiles"] = nlohmann::ordered_json::array();
  for (const auto& [index, entry] : entries_) {
    nlohmann::ordered_json tile;
    tile["x"] = index.x;
    tile["y"] = index.y;
    tile["file"] = "tiles/" + fileName(index);
    tile["offset_m"] = {entry.offset_m.x(), entry.offset_m.y(), entry.offset_m.z()};
    tile["points"] = entry.points;
    json["tiles"].push_back(std::move(tile));
  }
  writeFileAtomically(directory_ / "tiles.json", json.dump(1) + "\n");
}

}  // namespace cf
