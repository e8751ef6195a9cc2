// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/fuse/cleaning.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

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
constexpr int kDoubtfulShare = 5;
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
    if (parent_[a] == parent_[b]) return;
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  /// The set of each, named by its least member.
  std::vector<std::uint32_t> roots() {
    for (std::uint32_t i = 0; i < parent_.size(); ++i) parent_[i] = root(i);
    return std::move(parent_);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

struct Cell {
  std::int32_t z = 0;
  std::uint32_t voxels = 0;
  std::uint32_t support = 0;
  std::uint32_t views = 0;  ///< sum
  std::uint16_t best_views = 0;
  bool own = false;  ///< holds a point of the tile itself
};

/// Cells of a few voxels' side over a tile and its surroundings, relative to the tile's offset, by
/// vertical column: a column's cells follow one another upwards.
class SupportGrid {
 public:
  SupportGrid(const Tile& tile, const std::vector<const Tile*>& neighbours, double voxel_m) {
    Eigen::AlignedBox3f box;
    for (const TilePoint& point : tile.points) box.extend(point.position_m);
    for (int doubling = 0;; ++doubling) {
      cell_m_ = 2 * voxel_m * std::pow(2, doubling);
      const Eigen::AlignedBox3d reach(box.min().cast<double>().array() - kMarginCells * cell_m_,
                                      box.max().cast<double>().array() + kMarginCells * cell_m_);
      west_ = floorToInt(reach.min().x() / cell_m_);
      south_ = floorToInt(reach.min().y() / cell_m_);
      width_ = static_cast<std::size_t>(floorToInt(reach.max().x() / cell_m_) - west_ + 1);
      height_ = static_cast<std::size_t>(floorToInt(reach.max().y() / cell_m_) - south_ + 1);
      items_.clear();
      items_.reserve(tile.points.size());
      addTile(tile, Eigen::Vector3d::Zero(), reach);
      for (const Tile* neighbour : neighbours)
        addTile(*neighbour, neighbour->offset_m - tile.offset_m, reach);
      const std::size_t own_cells = fill(tile.points.size());
      const double density =
          static_cast<double>(tile.points.size()) / static_cast<double>(own_cells);
      if (density >= kVoxelsPerCell || doubling == kMaxDoublings) return;
    }
  }

  /// Sums support over neighbouring cells and joins them into components: the first cell of each.
  std::vector<std::uint32_t> connect() {
    DisjointSets sets(cells_.size());
    for (Cell& cell : cells_) cell.support += cell.voxels;
    const auto join = [&](std::uint32_t i, std::uint32_t j) {
      cells_[i].support += cells_[j].voxels;
      cells_[j].support += cells_[i].voxels;
      sets.unite(i, j);
    };
    for (std::size_t y = 0; y < height_; ++y) {
      for (std::size_t x = 0; x < width_; ++x) {
        const std::size_t column = y * width_ + x;
        const std::uint32_t begin = first_[column], end = first_[column + 1];
        if (begin == end) continue;
        for (std::uint32_t i = begin; i + 1 < end; ++i)
          if (cells_[i + 1].z == cells_[i].z + 1) join(i, i + 1);
        // The half of the neighbours that comes after.
        if (x + 1 < width_) joinColumns(column, column + 1, join);
        if (y + 1 == height_) continue;
        if (x > 0) joinColumns(column, column + width_ - 1, join);
        joinColumns(column, column + width_, join);
        if (x + 1 < width_) joinColumns(column, column + width_ + 1, join);
      }
    }
    return sets.roots();
  }

  const std::vector<Cell>& cells() const { return cells_; }
  /// Of each point of the tile.
  const std::vector<std::uint32_t>& cellOfPoint() const { return cell_of_point_; }

  std::size_t width() const { return width_; }
  std::size_t columns() const { return width_ * height_; }
  std::uint32_t columnOf(std::uint32_t cell) const { return column_of_cell_[cell]; }

 private:
  struct Item {
    std::uint32_t column;
    std::int32_t z;
    std::uint32_t point;  ///< of the tile; beyond them for the neighbours'
    std::uint16_t views;
  };

  void addTile(const Tile& tile, const Eigen::Vector3d& shift, const Eigen::AlignedBox3d& reach) {
    const double inverse = 1 / cell_m_;
    const Eigen::Vector3f low = (reach.min() - shift).cast<float>();
    const Eigen::Vector3f high = (reach.max() - shift).cast<float>();
    for (const TilePoint& point : tile.points) {
      const Eigen::Vector3f& q = point.position_m;
      if (q.x() < low.x() || q.x() > high.x() || q.y() < low.y() || q.y() > high.y() ||
          q.z() < low.z() || q.z() > high.z())
        continue;
      const Eigen::Vector3d p = q.cast<double>() + shift;
      const auto x = static_cast<std::size_t>(floorToInt(inverse * p.x()) - west_);
      const auto y = static_cast<std::size_t>(floorToInt(inverse * p.y()) - south_);
      if (x >= width_ || y >= height_) continue;  // by rounding, at the edge of the reach
      items_.push_back({static_cast<std::uint32_t>(y * width_ + x),
                        static_cast<std::int32_t>(floorToInt(inverse * p.z())),
                        static_cast<std::uint32_t>(items_.size()), point.views});
    }
  }

  /// Makes cells of the items, of which the first `points` are the tile's. Returns how many cells
  /// these fall into.
  std::size_t fill(std::size_t points) {
    first_.assign(columns() + 1, 0);
    for (const Item& item : items_) ++first_[item.column + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    sorted_.resize(items_.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (const Item& item : items_) sorted_[next[item.column]++] = item;

    cells_.clear();
    column_of_cell_.clear();
    cell_of_point_.resize(points);
    std::size_t own_cells = 0;
    for (std::size_t column = 0; column < columns(); ++column) {
      const auto begin = sorted_.begin() + first_[column];
      const auto end = sorted_.begin() + next[column];
      std::sort(begin, end, [](const Item& a, const Item& b) { return a.z < b.z; });
      first_[column] = static_cast<std::uint32_t>(cells_.size());
      for (auto item = begin; item != end; ++item) {
        if (item == begin || cells_.back().z != item->z) {
          cells_.emplace_back();
          cells_.back().z = item->z;
          column_of_cell_.push_back(static_cast<std::uint32_t>(column));
        }
        Cell& cell = cells_.back();
        ++cell.voxels;
        cell.views += item->views;
        cell.best_views = std::max(cell.best_views, item->views);
        if (item->point >= points) continue;
        cell_of_point_[item->point] = static_cast<std::uint32_t>(cells_.size() - 1);
        own_cells += !std::exchange(cell.own, true);
      }
    }
    first_.back() = static_cast<std::uint32_t>(cells_.size());
    return own_cells;
  }

  /// Calls join for the cells of two columns that touch.
  template <class Join>
  void joinColumns(std::size_t a, std::size_t b, const Join& join) const {
    std::uint32_t low = first_[b];
    const std::uint32_t end = first_[b + 1];
    for (std::uint32_t i = first_[a]; i < first_[a + 1] && low < end; ++i) {
      while (low < end && cells_[low].z < cells_[i].z - 1) ++low;
      for (std::uint32_t j = low; j < end && cells_[j].z <= cells_[i].z + 1; ++j) join(i, j);
    }
  }

  double cell_m_ = 0;
  std::int64_t west_ = 0, south_ = 0;
  std::size_t width_ = 0, height_ = 0;  ///< [columns]
  std::vector<Item> items_, sorted_;
  std::vector<std::uint32_t> first_;  ///< cell of each column, and the end
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> column_of_cell_;
  std::vector<std::uint32_t> cell_of_point_;
};

struct Component {
  std::size_t cells = 0, voxels = 0, views = 0;
  std::size_t shadowed_cells = 0;  ///< a larger, better seen surface is in their column
  bool flying = false;
};

/// One per cell number; filled where the cell is its component's root.
std::vector<Component> judgeComponents(const SupportGrid& grid,
                                       const std::vector<std::uint32_t>& roots) {
  const std::vector<Cell>& cells = grid.cells();
  std::vector<Component> components(cells.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    Component& component = components[roots[i]];
    ++component.cells;
    component.voxels += cells[i].voxels;
    component.views += cells[i].views;
  }

  std::vector<std::uint16_t> best_views(grid.columns());  // of wide surfaces
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (components[roots[i]].voxels < kIslandVoxels) continue;
    std::uint16_t& best = best_views[grid.columnOf(i)];
    best = std::max(best, cells[i].best_views);
  }
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    Component& component = components[roots[i]];
    if (component.voxels >= kIslandVoxels) continue;
    const std::uint16_t best = best_views[grid.columnOf(i)];
    if (best > 0 && best * component.voxels >= 2 * component.views) ++component.shadowed_cells;
  }
  for (Component& component : components)
    component.flying = component.voxels < kIsletVoxels ||
                       (component.voxels < kIslandVoxels &&
                        static_cast<double>(component.shadowed_cells) >=
                            kColumnShare * static_cast<double>(component.cells));
  return components;
}

/// Most views of any voxel in the 3 x 3 columns around each.
std::vector<std::uint16_t> viewsAround(const SupportGrid& grid) {
  const std::size_t width = grid.width();
  std::vector<std::uint16_t> best(grid.columns()), around(grid.columns());
  for (std::uint32_t i = 0; i < grid.cells().size(); ++i) {
    std::uint16_t& views = best[grid.columnOf(i)];
    views = std::max(views, grid.cells()[i].best_views);
  }
  for (std::size_t column = 0; column < best.size(); ++column) {
    if (best[column] == 0) continue;
    const std::size_t x = column % width, y = column / width;
    for (std::size_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v * width < best.size(); ++v)
      for (std::size_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < width; ++u)
        around[v * width + u] = std::max(around[v * width + u], best[column]);
  }
  return around;
}

double medianSupport(const SupportGrid& grid) {
  std::uint32_t most = 0;
  for (const Cell& cell : grid.cells()) most = std::max(most, cell.support);
  std::vector<std::size_t> count(most + 1);
  for (const std::uint32_t cell : grid.cellOfPoint()) ++count[grid.cells()[cell].support];
  std::size_t below = 0;
  std::uint32_t support = 0;
  while (below + count[support] <= grid.cellOfPoint().size() / 2) below += count[support++];
  return support;
}

}  // namespace

Tile cleaned(const Tile& tile, const std::vector<const Tile*>& neighbours, double voxel_m,
             int trusted_views) {
  Tile result;
  result.index = tile.index;
  result.offset_m = tile.offset_m;
  if (tile.points.empty()) return result;

  SupportGrid grid(tile, neighbours, voxel_m);
  const std::vector<std::uint32_t> roots = grid.connect();
  const std::vector<Component> components = judgeComponents(grid, roots);
  const double least_support = kAloneShare * medianSupport(grid);

  const std::vector<std::uint16_t> views = viewsAround(grid);
  result.points.reserve(tile.points.size());
  for (std::size_t i = 0; i < tile.points.size(); ++i) {
    const std::uint32_t cell = grid.cellOfPoint()[i];
    const bool flying = grid.cells()[cell].support < least_support ||
                        components[roots[cell]].flying ||
                        kDoubtfulShare * tile.points[i].views <= views[grid.columnOf(cell)];
    if (!flying || tile.points[i].views >= trusted_views) result.points.push_back(tile.points[i]);
  }
  return result;
}

}  // namespace cf
