// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/octomap_builder.h"

#include <fmt/format.h>
#include <octomap/ColorOcTree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "brick_set.h"
#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/formats/atomic_file.h"
#include "voxel_index.h"

namespace cf {
namespace {

constexpr std::int64_t kCentreKey = 32768;  ///< OctoMap's key of the cell that starts at zero
constexpr unsigned kTreeDepth = 16;

/// ColorOcTree with leaves above the finest level.
class Tree : public octomap::ColorOcTree {
 public:
  explicit Tree(double resolution_m) : octomap::ColorOcTree(resolution_m) {}

  /// The leaf of `key` at `depth`; nothing below it may exist. Fast where consecutive keys are
  /// near: it descends from the last common ancestor.
  octomap::ColorOcTreeNode& leaf(const octomap::OcTreeKey& key, unsigned depth) {
    if (!root) {
      root = new octomap::ColorOcTreeNode();
      ++tree_size;
      path_[0] = root;
    }
    unsigned differing = 0;
    for (unsigned k = 0; k < 3; ++k) differing |= static_cast<unsigned>(key[k] ^ last_key_[k]);
    unsigned d = 0;
    while (d < last_depth_ && d < depth && (differing >> (kTreeDepth - 1 - d) & 1) == 0) ++d;
    for (; d < depth; ++d) {
      const unsigned child = octomap::computeChildIdx(key, static_cast<int>(kTreeDepth - 1 - d));
      path_[d + 1] = nodeChildExists(path_[d], child) ? getNodeChild(path_[d], child)
                                                      : createNodeChild(path_[d], child);
    }
    last_key_ = key;
    last_depth_ = depth;
    return *path_[depth];
  }

 private:
  std::array<octomap::ColorOcTreeNode*, kTreeDepth + 1> path_ = {};
  octomap::OcTreeKey last_key_;
  unsigned last_depth_ = 0;
};

/// Interleaves the low 16 bits of x, y and z: near cells get near numbers.
std::uint64_t mortonCode(const octomap::OcTreeKey& key) {
  const auto spread = [](std::uint64_t v) {
    v = (v | v << 16) & 0x0000FF0000FF;
    v = (v | v << 8) & 0x00F00F00F00F;
    v = (v | v << 4) & 0x0C30C30C30C3;
    return (v | v << 2) & 0x249249249249;
  };
  return spread(key[0]) | spread(key[1]) << 1 | spread(key[2]) << 2;
}

octomap::OcTreeKey keyOf(std::int64_t x, std::int64_t y, std::int64_t z) {
  return {static_cast<octomap::key_type>(x + kCentreKey),
          static_cast<octomap::key_type>(y + kCentreKey),
          static_cast<octomap::key_type>(z + kCentreKey)};
}

/// Occupied cell.
struct Hits {
  float weight = 0;
  float bgr[3] = {0, 0, 0};  ///< weighted sum
  std::uint32_t count = 0;
};

/// The text that OctoMap's own write() begins with (which prints to stderr besides).
std::string header(const char* first_line, const char* type, const Tree& tree) {
  return fmt::format(
      "{}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
      "id {}\nsize {}\nres {}\ndata\n",
      first_line, type, tree.size(), tree.getResolution());
}

std::uint8_t mean(float sum, float weight) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(sum / weight), 0L, 255L));
}

}  // namespace

void OctomapOptions::visit(OptionVisitor& visitor) {
  visitor.number(
      "resolution_m", resolution_m, {0, 100},
      "side of an occupied cell [m]; 0 = four voxels of the map, 8, 16 ... over large areas");
  visitor.number("free_resolution_m", free_resolution_m, {0.01, 100},
                 "side of a free cell [m], rounded up to a cell size of the octree");
  visitor.integer("rays_per_keyframe", rays_per_keyframe, {0, 1000000},
                  "rays that carve free space, for each depth frame");
}

OctomapOptions OctomapOptions::resolved(double voxel_m, double area_m2) const {
  constexpr double kMostGroundCells = 2e6;
  OctomapOptions result = *this;
  if (resolution_m > 0) return result;
  result.resolution_m = 4 * voxel_m;
  while (area_m2 > kMostGroundCells * result.resolution_m * result.resolution_m)
    result.resolution_m *= 2;
  return result;
}

struct OctoMapBuilder::Impl {
  double resolution_m = 0;
  int levels = 0;  ///< a free cell is 2^levels occupied cells wide
  int rays = 0;
  VoxelIndex index;
  std::vector<Hits> hits;
  BrickSet surface;  ///< coarse cells with hits
  BrickSet free;
  std::size_t outside = 0;

  double coarseSize() const { return std::ldexp(resolution_m, levels); }
  bool fits(std::int64_t cell) const { return cell >= -kCentreKey && cell < kCentreKey; }
  bool fits(const Eigen::Vector3d& p) const {
    return (p.array().abs() < (kCentreKey - 1) * resolution_m).all();
  }

  void carveRay(const Eigen::Vector3d& from, const Eigen::Vector3d& to);
  void writeHits(Tree& tree) const;
  void writeFree(Tree& tree) const;
};

OctoMapBuilder::OctoMapBuilder(const OctomapOptions& options) : impl_(std::make_unique<Impl>()) {
  if (!(options.resolution_m > 0))
    throw UsageError(
        fmt::format("[octomap] resolution_m = {} must be above 0", options.resolution_m));
  impl_->resolution_m = options.resolution_m;
  impl_->rays = options.rays_per_keyframe;
  while (impl_->coarseSize() < options.free_resolution_m * (1 - 1e-9) &&
         impl_->levels < static_cast<int>(kTreeDepth) - 1)
    ++impl_->levels;
}

OctoMapBuilder::~OctoMapBuilder() = default;

void OctoMapBuilder::addSurface(const Tile& tile) {
  for (const TilePoint& point : tile.points) {
    const Eigen::Vector3d p = tile.offset_m + point.position_m.cast<double>();
    if (!impl_->fits(p)) {
      ++impl_->outside;
      continue;
    }
    const std::int64_t cell[3] = {floorToInt(p.x() / impl_->resolution_m),
                                  floorToInt(p.y() / impl_->resolution_m),
                                  floorToInt(p.z() / impl_->resolution_m)};
    const std::uint32_t number = impl_->index.findOrAdd(CellKey::pack(cell[0], cell[1], cell[2]));
    if (number == impl_->hits.size()) {
      impl_->hits.emplace_back();
      impl_->surface.insert(cell[0] >> impl_->levels, cell[1] >> impl_->levels,
                            cell[2] >> impl_->levels);
    }
    Hits& hits = impl_->hits[number];
    hits.weight += point.confidence;
    for (int k = 0; k < 3; ++k) hits.bgr[k] += point.confidence * static_cast<float>(point.bgr[k]);
    hits.count += point.views;
  }
}

void OctoMapBuilder::carve(const Eigen::Vector3d& camera_centre_m, const MapPoints& seen) {
  const std::size_t points = seen.points.size();
  const std::size_t rays = std::min(static_cast<std::size_t>(impl_->rays), points);
  for (std::size_t ray = 0; ray < rays; ++ray) {
    const Eigen::Vector3d to = seen.world(seen.points[(2 * ray + 1) * points / (2 * rays)]);
    if (impl_->fits(camera_centre_m) && impl_->fits(to))
      impl_->carveRay(camera_centre_m, to);
    else
      ++impl_->outside;
  }
}

/// Walks the coarse cells from `from` to before that of `to` (Amanatides and Woo 1987).
void OctoMapBuilder::Impl::carveRay(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d start = from / coarseSize(), end = to / coarseSize();
  std::int64_t cell[3], last[3], step[3];
  double next[3], stride[3];  // ray parameter of the next border, and between borders
  std::int64_t steps = 0;
  for (int k = 0; k < 3; ++k) {
    cell[k] = floorToInt(start[k]);
    last[k] = floorToInt(end[k]);
    const double d = end[k] - start[k];
    step[k] = d > 0 ? 1 : -1;
    const double border = static_cast<double>(cell[k] + (d > 0 ? 1 : 0));
    next[k] = d != 0 ? (border - start[k]) / d : std::numeric_limits<double>::infinity();
    stride[k] = d != 0 ? 1 / std::abs(d) : std::numeric_limits<double>::infinity();
    steps += std::abs(last[k] - cell[k]);
  }
  // As many steps as there are borders between: rounding cannot make the walk miss its end.
  for (; steps > 0; --steps) {
    if (surface.contains(cell[0], cell[1], cell[2])) return;
    free.insert(cell[0], cell[1], cell[2]);
    const int k = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    cell[k] += step[k];
    next[k] += stride[k];
  }
}

void OctoMapBuilder::Impl::writeHits(Tree& tree) const {
  struct Numbered {
    std::uint64_t code;
    octomap::OcTreeKey key;
    std::uint32_t number;
  };
  std::vector<Numbered> order;
  order.reserve(hits.size());
  for (std::uint32_t number = 0; number < hits.size(); ++number) {
    const std::uint64_t cell = index.keys()[number];
    const octomap::OcTreeKey key = keyOf(CellKey::x(cell), CellKey::y(cell), CellKey::z(cell));
    order.push_back({mortonCode(key), key, number});
  }
  std::sort(order.begin(), order.end(),
            [](const Numbered& a, const Numbered& b) { return a.code < b.code; });
  for (const Numbered& item : order) {
    const Hits& cell = hits[item.number];
    octomap::ColorOcTreeNode& node = tree.leaf(item.key, kTreeDepth);
    node.setLogOdds(std::min(tree.getClampingThresMaxLog(),
                             static_cast<float>(cell.count) * tree.getProbHitLog()));
    node.setColor(mean(cell.bgr[2], cell.weight), mean(cell.bgr[1], cell.weight),
                  mean(cell.bgr[0], cell.weight));
  }
}

/// One value for all free cells, so that pruning can merge them.
void OctoMapBuilder::Impl::writeFree(Tree& tree) const {
  free.forEach([&](std::int64_t x, std::int64_t y, std::int64_t z) {
    if (surface.contains(x, y, z)) return;
    const std::int64_t width = std::int64_t{1} << levels;
    tree.leaf(keyOf(x * width, y * width, z * width), kTreeDepth - static_cast<unsigned>(levels))
        .setLogOdds(tree.getClampingThresMinLog());
  });
}

void OctoMapBuilder::write(const std::filesystem::path& base) const {
  if (impl_->outside > 0)
    logWarning(
        fmt::format("OctoMap: {} points are more than {:.0f} m from the origin and left out; a "
                    "larger [octomap] resolution_m reaches further",
                    impl_->outside, (kCentreKey - 1) * impl_->resolution_m));
  Tree tree(impl_->resolution_m);
  impl_->writeHits(tree);
  impl_->writeFree(tree);
  if (tree.getRoot()) {  // ColorOcTree 1.9 crashes on an empty tree
    tree.updateInnerOccupancy();
    tree.prune();
  }
  std::ostringstream colour, binary;
  colour << header("# Octomap OcTree file", "ColorOcTree", tree);
  tree.writeData(colour);
  // OctoMap would name the class ColorOcTree here too, and its own compare_octrees crash on it.
  binary << header("# Octomap OcTree binary file", "OcTree", tree);
  if (tree.getRoot()) tree.writeBinaryData(binary);
  writeFileAtomically(base.string() + ".ot", colour.str());
  writeFileAtomically(base.string() + ".bt", binary.str());
}

OctoMapBuilder::Stats OctoMapBuilder::stats() const {
  return {impl_->hits.size(), impl_->free.size(), impl_->outside};
}

double OctoMapBuilder::resolution() const { return impl_->resolution_m; }
double OctoMapBuilder::freeResolution() const { return impl_->coarseSize(); }

}  // namespace cf
