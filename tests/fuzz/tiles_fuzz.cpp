// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// A folder of tiles, with its list (first byte 'j') or a tile in it (any other) as given.
#include "cf/formats/pcd.h"
#include "cf/formats/tile_store.h"
#include "fuzz/fuzz_target.h"
#include "support/temp_folder.h"

namespace {

namespace fs = std::filesystem;

struct Folder {
  cf::support::TempFolder folder;
  std::string list, tile;
  cf::fuzz::InputFile list_file{"tiles.json"}, tile_file{"0_0.pcd"};

  Folder() {
    auto store = cf::DirectoryTileStore::create(folder.path(), 20, 0.1);
    cf::Tile made;
    made.offset_m = {1000.25, -20, 0.5};
    for (int i = 0; i < 3; ++i) {
      auto& point = made.points.emplace_back();
      point.position_m = {0.5f * static_cast<float>(i), 1, -2};
      point.views = 3;
    }
    store.save(made);
    store.flush();
    list = cf::support::fileText(folder / "tiles.json");
    tile = cf::support::fileText(folder / "tiles/0_0.pcd");
    link(list, list_file, folder / "tiles.json");
    link(tile, tile_file, folder / "tiles/0_0.pcd");
  }
  static void link(const std::string& bytes, cf::fuzz::InputFile& file, const fs::path& at) {
    const fs::path memory =
        file.put(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    fs::remove(at);
    fs::create_symlink(memory, at);
  }
};

Folder& folder() {
  static Folder made;
  return made;
}

}  // namespace

std::vector<std::string> cf::fuzz::seeds() {
  return {
      "j" + folder().list, "t" + folder().tile,
      "t# .PCD v0.7\nVERSION 0.7\nFIELDS z y x label\nSIZE 4 4 4 8\nTYPE F F F U\nCOUNT 1 1 1 2\n"
      "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n0123456789ab0123456789abcdef"};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  Folder& f = folder();
  const bool is_list = data[0] == 'j';
  (is_list ? f.list_file : f.tile_file).put(data + 1, size - 1);
  cf::fuzz::expectOneLineAtMost(f.folder.path(), [&] {
    auto store = cf::DirectoryTileStore::open(f.folder.path());
    cf::fuzz::require(store.tileSize() > 0 && store.voxelSize() > 0, "sizes above zero");
    for (const auto index : store.indices())
      cf::fuzz::require(store.load(index).has_value(), "listed tiles are there");
  });
  const std::string& whole = is_list ? f.list : f.tile;
  (is_list ? f.list_file : f.tile_file)
      .put(reinterpret_cast<const std::uint8_t*>(whole.data()), whole.size());
  return 0;
}
