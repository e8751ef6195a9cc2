// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "load_octomap.h"

#include <fmt/format.h>
#include <octomap/ColorOcTree.h>

#include <fstream>
#include <memory>

#include "cf/base/error.h"

namespace cf {
namespace {

// The header by hand: octomap's own reader writes to stderr as it goes.
std::unique_ptr<octomap::ColorOcTree> readTree(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw RunError(fmt::format("{}: cannot be opened", file.string()));
  const auto fail = [&](const char* what) {
    return RunError(fmt::format("{}: {}", file.string(), what));
  };
  std::string line, key, id;
  std::size_t nodes = 0;
  double resolution_m = 0;
  std::getline(in, line);
  if (line.rfind("# Octomap OcTree file", 0) != 0) throw fail("not an OctoMap .ot file");
  while (in >> key && key != "data") {
    if (key == "id") in >> id;
    if (key == "size") in >> nodes;
    if (key == "res") in >> resolution_m;
    std::getline(in, line);
  }
  in.ignore(1);
  if (!in || !(resolution_m > 0)) throw fail("the OctoMap's header is damaged");
  if (id != "ColorOcTree") throw fail("not a colour OctoMap (ColorOcTree)");
  auto tree = std::make_unique<octomap::ColorOcTree>(resolution_m);
  if (nodes > 0) tree->readData(in);
  if (!in || tree->size() != nodes) throw fail("the OctoMap is cut short");
  return tree;
}

std::size_t countOccupied(const octomap::ColorOcTree& tree, unsigned char depth) {
  std::size_t count = 0;
  for (auto it = tree.begin_leafs(depth), end = tree.end_leafs(); it != end; ++it)
    if (tree.isNodeOccupied(*it)) ++count;
  return count;
}

}  // namespace

std::vector<Voxel> loadVoxels(const std::filesystem::path& file, std::size_t max_voxels) {
  const auto tree = readTree(file);
  auto depth = static_cast<unsigned char>(tree->getTreeDepth());
  while (depth > 1 && countOccupied(*tree, depth) > max_voxels) --depth;
  std::vector<Voxel> voxels;
  for (auto it = tree->begin_leafs(depth), end = tree->end_leafs(); it != end; ++it) {
    if (!tree->isNodeOccupied(*it)) continue;
    Voxel voxel;
    const double size = it.getSize();
    const octomap::point3d centre = it.getCoordinate();
    voxel.centre_m = {centre.x(), centre.y(), centre.z()};
    voxel.size_m = static_cast<float>(size);
    const auto colour = it->getColor();
    voxel.rgb[0] = colour.r;
    voxel.rgb[1] = colour.g;
    voxel.rgb[2] = colour.b;
    // A face is hidden where the voxel beyond its middle is occupied.
    const double reach = 0.5 * size + 0.5 * tree->getNodeSize(depth);
    for (unsigned face = 0; face < 6; ++face) {
      octomap::point3d beyond = centre;
      beyond(face / 2) += static_cast<float>(face % 2 == 0 ? -reach : reach);
      const auto* node = tree->search(beyond, depth);
      if (node == nullptr || !tree->isNodeOccupied(node))
        voxel.faces = static_cast<std::uint8_t>(voxel.faces | (1U << face));
    }
    voxels.push_back(voxel);
  }
  return voxels;
}

}  // namespace cf
