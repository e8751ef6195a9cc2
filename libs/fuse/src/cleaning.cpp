// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/cleaning.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "voxel_index.h"

namespace cf {
namespace {

/// Support of a point: voxels in the 3 x 3 x 3 cells around it. Alone: below this share of the
/// median. A vertical pole one voxel wide has a sixth of what a plane has.
constexpr double kAloneShare = 0.1;
constexpr std::size_t kIsletVoxels = 30;
constexpr std::size_t kIslandVoxels = 500;
constexpr double kColumnShare = 0.5;
/// A cell holds about this many voxels of a surface, which then is connected through its cells.
constexpr double kVoxelsPerCell = 1.8;
constexpr int kMaxDoublings = 4;
/// A voxel is doubted where the best seen one in the columns around was seen so many times as
/// often.
constexpr int kDoubtfulShare = 8;
constexpr double kMarginCells = 16;  ///< of the neighbours' border that counts

/// Connected cells.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

struct Cell {
  std::uint32_t voxels = 0;
  std::uint32_t support = 0;
  std::uint32_t views = 0;  ///< sum
  std::uint16_t best_views = 0;
};

/// Cells of a few voxels' side over a tile and its surroundings, relative to the tile's offset.
class SupportGrid {
 public:
  SupportGrid(const Tile& tile, double voxel_m) : offset_m_(tile.offset_m) {
    for (int doubling = 0;; ++doubling) {
      cell_m_ = 2 * voxel_m * std::pow(2, doubling);
      index_ = {};
      cells_.clear();
      cell_of_point_.clear();
      for (const TilePoint& point : tile.points)
        cell_of_point_.push_back(add(point, point.position_m.cast<double>()));
      const double density =
          static_cast<double>(tile.points.size()) / static_cast<double>(index_.size());
      if (density >= kVoxelsPerCell || doubling == kMaxDoublings) break;
    }
  }

  void addSurroundings(const Tile& tile, const std::vector<const Tile*>& neighbours) {
    Eigen::Array3d low = Eigen::Array3d::Constant(1e30), high = -low;
    for (const TilePoint& point : tile.points) {
      low = low.min(point.position_m.cast<double>().array());
      high = high.max(point.position_m.cast<double>().array());
    }
    low -= kMarginCells * cell_m_;
    high += kMarginCells * cell_m_;
    for (const Tile* neighbour : neighbours) {
      const Eigen::Vector3d shift = neighbour->offset_m - offset_m_;
      for (const TilePoint& point : neighbour->points) {
        const Eigen::Vector3d p = point.position_m.cast<double>() + shift;
        if ((p.array() >= low).all() && (p.array() <= high).all()) add(point, p);
      }
    }
  }

  /// Sums support over neighbouring cells and joins them into components.
  DisjointSets connect() {
    DisjointSets sets(cells_.size());
    for (Cell& cell : cells_) cell.support += cell.voxels;
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
      const std::uint64_t key = index_.keys()[i];
      const std::int64_t x = CellKey::x(key), y = CellKey::y(key), z = CellKey::z(key);
      for (int d = 14; d < 27; ++d) {  // the half of the 26 neighbours that comes after (0, 0, 0)
        const std::uint32_t j =
            index_.find(CellKey::pack(x + d % 3 - 1, y + d / 3 % 3 - 1, z + d / 9 - 1));
        if (j == VoxelIndex::kNone) continue;
        cells_[i].support += cells_[j].voxels;
        cells_[j].support += cells_[i].voxels;
        sets.unite(i, j);
      }
    }
    return sets;
  }

  const std::vector<Cell>& cells() const { return cells_; }
  const std::vector<std::uint32_t>& cellOfPoint() const { return cell_of_point_; }
  /// Key of the vertical column that a cell is in.
  std::uint64_t column(std::uint32_t cell) const {
    const std::uint64_t key = index_.keys()[cell];
    return CellKey::pack(CellKey::x(key), CellKey::y(key), 0);
  }

 private:
  std::uint32_t add(const TilePoint& point, const Eigen::Vector3d& relative_m) {
    const std::uint32_t number = index_.findOrAdd(
        CellKey::pack(floorToInt(relative_m.x() / cell_m_), floorToInt(relative_m.y() / cell_m_),
                      floorToInt(relative_m.z() / cell_m_)));
    if (number == cells_.size()) cells_.emplace_back();
    Cell& cell = cells_[number];
    ++cell.voxels;
    cell.views += point.views;
    cell.best_views = std::max(cell.best_views, point.views);
    return number;
  }

  Eigen::Vector3d offset_m_;
  double cell_m_ = 0;
  VoxelIndex index_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> cell_of_point_;
};

struct Component {
  std::size_t cells = 0, voxels = 0, views = 0;
  std::size_t shadowed_cells = 0;  ///< a larger, better seen surface is in their column
  bool flying = false;
};

/// One per cell number; filled where the cell is its component's root.
std::vector<Component> judgeComponents(const SupportGrid& grid, DisjointSets& sets) {
  const std::vector<Cell>& cells = grid.cells();
  std::vector<Component> components(cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    Component& component = components[sets.root(i)];
    ++component.cells;
    component.voxels += cells[i].voxels;
    component.views += cells[i].views;
  }

  VoxelIndex columns;
  std::vector<std::uint16_t> best_views;  // of wide surfaces, by column
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (components[sets.root(i)].voxels < kIslandVoxels) continue;
    const std::uint32_t column = columns.findOrAdd(grid.column(i));
    if (column == best_views.size()) best_views.push_back(0);
    best_views[column] = std::max(best_views[column], cells[i].best_views);
  }
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    Component& component = components[sets.root(i)];
    if (component.voxels >= kIslandVoxels) continue;
    const std::uint32_t column = columns.find(grid.column(i));
    if (column != VoxelIndex::kNone && best_views[column] * component.voxels >= 2 * component.views)
      ++component.shadowed_cells;
  }
  for (Component& component : components)
    component.flying = component.voxels < kIsletVoxels ||
                       (component.voxels < kIslandVoxels &&
                        static_cast<double>(component.shadowed_cells) >=
                            kColumnShare * static_cast<double>(component.cells));
  return components;
}

/// Most views of any voxel in the 3 x 3 columns around each cell.
class ColumnViews {
 public:
  explicit ColumnViews(const SupportGrid& grid) {
    for (std::uint32_t i = 0; i < grid.cells().size(); ++i) {
      const std::uint32_t column = columns_.findOrAdd(grid.column(i));
      if (column == best_.size()) best_.push_back(0);
      best_[column] = std::max(best_[column], grid.cells()[i].best_views);
    }
    around_.resize(best_.size());
    for (std::uint32_t column = 0; column < best_.size(); ++column) {
      const std::uint64_t key = columns_.keys()[column];
      for (int d = 0; d < 9; ++d) {
        const std::uint32_t beside = columns_.find(
            CellKey::pack(CellKey::x(key) + d % 3 - 1, CellKey::y(key) + d / 3 - 1, 0));
        if (beside != VoxelIndex::kNone) around_[column] = std::max(around_[column], best_[beside]);
      }
    }
  }
  int around(std::uint64_t column) const { return around_[columns_.find(column)]; }

 private:
  VoxelIndex columns_;
  std::vector<std::uint16_t> best_, around_;
};

double medianSupport(const SupportGrid& grid) {
  std::vector<std::uint32_t> support;
  support.reserve(grid.cellOfPoint().size());
  for (const std::uint32_t cell : grid.cellOfPoint()) support.push_back(grid.cells()[cell].support);
  const auto middle = support.begin() + static_cast<std::ptrdiff_t>(support.size() / 2);
  std::nth_element(support.begin(), middle, support.end());
  return *middle;
}

}  // namespace

Tile cleaned(const Tile& tile, const std::vector<const Tile*>& neighbours, double voxel_m,
             int trusted_views) {
  Tile result;
  result.index = tile.index;
  result.offset_m = tile.offset_m;
  if (tile.points.empty()) return result;

  SupportGrid grid(tile, voxel_m);
  grid.addSurroundings(tile, neighbours);
  DisjointSets sets = grid.connect();
  const std::vector<Component> components = judgeComponents(grid, sets);
  const double least_support = kAloneShare * medianSupport(grid);

  const ColumnViews views(grid);
  result.points.reserve(tile.points.size());
  for (std::size_t i = 0; i < tile.points.size(); ++i) {
    const std::uint32_t cell = grid.cellOfPoint()[i];
    const bool flying = grid.cells()[cell].support < least_support ||
                        components[sets.root(cell)].flying ||
                        kDoubtfulShare * tile.points[i].views <= views.around(grid.column(cell));
    if (!flying || tile.points[i].views >= trusted_views) result.points.push_back(tile.points[i]);
  }
  return result;
}

}  // namespace cf
