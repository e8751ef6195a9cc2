// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "height_search.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "statistics.h"

namespace cf {
namespace {

constexpr double kReach_m = 12;
constexpr std::size_t kMaxCells = 8000;
constexpr std::size_t kMinCells = 20;
constexpr double kAgreement_m = 0.5;

/// Median height per cell; NaN where there is no point.
struct HeightMap {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();
  double cell_m = 1;
  Eigen::MatrixXd height;

  HeightMap(const std::vector<Eigen::Vector3f>& points, double cell) : cell_m(cell) {
    Eigen::AlignedBox3f box;
    for (const auto& p : points) box.extend(p);
    corner = box.min().head<2>().cast<double>();
    const auto cells = [&](float length) { return static_cast<Eigen::Index>(length / cell) + 1; };
    height.setConstant(cells(box.sizes().x()), cells(box.sizes().y()),
                       std::numeric_limits<double>::quiet_NaN());
    std::vector<std::pair<Eigen::Index, double>> sorted;
    for (const auto& p : points) {
      const Eigen::Vector2d at = (p.head<2>().cast<double>() - corner) / cell;
      const auto x = std::min(static_cast<Eigen::Index>(at.x()), height.rows() - 1);
      const auto y = std::min(static_cast<Eigen::Index>(at.y()), height.cols() - 1);
      sorted.emplace_back(x + y * height.rows(), p.z());
    }
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0, first = 0; i < sorted.size(); first = i) {
      while (i < sorted.size() && sorted[i].first == sorted[first].first) ++i;
      height.data()[sorted[first].first] = sorted[(first + i) / 2].second;
    }
  }

  double at(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d cell = (p - corner) / cell_m;
    if (cell.x() < 0 || cell.y() < 0) return std::numeric_limits<double>::quiet_NaN();
    const auto x = static_cast<Eigen::Index>(cell.x()), y = static_cast<Eigen::Index>(cell.y());
    if (x >= height.rows() || y >= height.cols()) return std::numeric_limits<double>::quiet_NaN();
    return height(x, y);
  }
};

struct Shift {
  Eigen::Vector2d horizontal_m = Eigen::Vector2d::Zero();
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();  ///< dz = plane . (x, y, 1), estimate's x, y
  double score = 0;                                 ///< 0..1
  std::size_t cells = 0;
};

/// Plane through the height differences by iterated reweighting, and how well they agree with it.
void fitPlane(const std::vector<Eigen::Vector3d>& cells, const std::vector<double>& dz, Shift& s) {
  s.plane = {0, 0, median(dz)};
  std::vector<double> residual(dz.size());
  const auto update = [&] {
    for (std::size_t i = 0; i < dz.size(); ++i)
      residual[i] = std::abs(dz[i] - s.plane.dot(cells[i]));
  };
  update();
  for (int round = 0; round < 5; ++round) {
    const double limit = 3 * std::max(0.05, 1.4826 * median(residual));
    Eigen::Matrix3d H = 1e-6 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < dz.size(); ++i) {
      if (residual[i] > limit) continue;
      H += cells[i] * cells[i].transpose();
      b += cells[i] * dz[i];
    }
    s.plane = H.ldlt().solve(b);
    update();
  }
  for (const double r : residual) s.score += std::max(0.0, 1 - r / kAgreement_m);
  s.score /= static_cast<double>(residual.size());
}

}  // namespace

std::vector<Eigen::Isometry3d> searchByHeight(const std::vector<Eigen::Vector3f>& estimate,
                                              const std::vector<Eigen::Vector3f>& reference,
                                              double cell_m, std::size_t count) {
  if (estimate.empty() || reference.empty()) return {};
  const HeightMap est(estimate, cell_m), ref(reference, cell_m);
  std::vector<Eigen::Vector3d> cells;
  for (Eigen::Index y = 0; y < est.height.cols(); ++y)
    for (Eigen::Index x = 0; x < est.height.rows(); ++x)
      if (!std::isnan(est.height(x, y)))
        cells.emplace_back(est.corner.x() + (static_cast<double>(x) + 0.5) * cell_m,
                           est.corner.y() + (static_cast<double>(y) + 0.5) * cell_m,
                           est.height(x, y));
  const std::size_t step = cells.size() / kMaxCells + 1;

  const int reach = static_cast<int>(std::ceil(kReach_m / cell_m)), side = 2 * reach + 1;
  std::vector<Shift> shifts(static_cast<std::size_t>(side * side));
  tbb::parallel_for(0, side * side, [&](int k) {
    Shift& s = shifts[static_cast<std::size_t>(k)];
    s.horizontal_m = cell_m * Eigen::Vector2d(k % side - reach, k / side - reach);
    std::vector<Eigen::Vector3d> common;
    std::vector<double> dz;
    for (std::size_t i = 0; i < cells.size(); i += step) {
      const double z = ref.at(cells[i].head<2>() + s.horizontal_m);
      if (std::isnan(z)) continue;
      common.emplace_back(cells[i].x(), cells[i].y(), 1);
      dz.push_back(z - cells[i].z());
    }
    s.cells = dz.size();
    if (s.cells >= kMinCells) fitPlane(common, dz, s);
  });

  std::size_t most = 0;
  for (const Shift& s : shifts) most = std::max(most, s.cells);
  std::stable_sort(shifts.begin(), shifts.end(),
                   [](const Shift& a, const Shift& b) { return a.score > b.score; });
  std::vector<Shift> best;
  for (const Shift& s : shifts) {
    if (best.size() == count || s.cells < kMinCells) break;
    const bool apart = std::all_of(best.begin(), best.end(), [&](const Shift& other) {
      return (other.horizontal_m - s.horizontal_m).norm() > 2.5 * cell_m;
    });
    if (apart && 2 * s.cells >= most) best.push_back(s);
  }

  std::vector<Eigen::Isometry3d> starts;
  for (const Shift& s : best) {
    // Tilted about the middle of the cells, where the plane also gives the vertical shift.
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& c : cells) middle += c / static_cast<double>(cells.size());
    const Eigen::Vector3d tilt(s.plane.y(), -s.plane.x(), 0);
    const double dz = s.plane.dot(Eigen::Vector3d(middle.x(), middle.y(), 1));
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translate(middle + Eigen::Vector3d(s.horizontal_m.x(), s.horizontal_m.y(), dz));
    if (tilt.norm() > 0) T.rotate(Eigen::AngleAxisd(tilt.norm(), tilt.normalized()));
    T.translate(-middle);
    starts.push_back(T);
  }
  return starts;
}

}  // namespace cf
