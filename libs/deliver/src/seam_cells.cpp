// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "seam_cells.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "robust.h"

namespace cf {
namespace {

constexpr double kCellsAcross = 12;     ///< of the places where UAVs meet, along the longer side
constexpr double kMedianLoss = 1.2533;  ///< σ of a median over that of a mean

SeamCell cellOf(const std::vector<const SeamPoint*>& points) {
  SeamCell cell;
  cell.uav_a = points.front()->uav_a;
  cell.uav_b = points.front()->uav_b;
  cell.points = static_cast<int>(points.size());
  double variance = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const SeamPoint* p : points) values.push_back(p->difference_m[axis]);
    cell.difference_m[axis] = medianOf(values);
    const double sigma = kMedianLoss * robustSigma(values);
    variance += sigma * sigma / static_cast<double>(points.size());
  }
  cell.sigma_m = std::sqrt(variance);
  return cell;
}

}  // namespace

std::optional<Seam> seamOf(const std::vector<SeamPoint>& points) {
  std::vector<double> x, y;
  for (const SeamPoint& p : points) {
    x.push_back(p.position_m.x());
    y.push_back(p.position_m.y());
  }
  const double side = std::max(quantileOf(x, 0.98) - quantileOf(x, 0.02),
                               quantileOf(y, 0.98) - quantileOf(y, 0.02));
  if (!(side > 0)) return std::nullopt;
  Seam seam;
  seam.cell_m = side / kCellsAcross;
  seam.points = points.size();
  std::map<std::tuple<int, int, int, int>, std::vector<const SeamPoint*>> by_cell;
  for (const SeamPoint& p : points)
    by_cell[{p.uav_a, p.uav_b, static_cast<int>(std::floor(p.position_m.x() / seam.cell_m)),
             static_cast<int>(std::floor(p.position_m.y() / seam.cell_m))}]
        .push_back(&p);
  double sum = 0;
  for (const auto& [key, of_cell] : by_cell) {
    if (of_cell.size() < Seam::kEnough) continue;
    SeamCell cell = cellOf(of_cell);
    cell.middle_m = seam.cell_m * Eigen::Vector2d(std::get<2>(key) + 0.5, std::get<3>(key) + 0.5);
    sum += cell.difference_m.squaredNorm() - cell.sigma_m * cell.sigma_m;
    seam.worst_m = std::max(seam.worst_m, cell.difference_m.norm());
    seam.cells.push_back(cell);
  }
  if (seam.cells.empty()) return std::nullopt;
  seam.rms_m = std::sqrt(std::max(0.0, sum / static_cast<double>(seam.cells.size())));
  return seam;
}

}  // namespace cf
