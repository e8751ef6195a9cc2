// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ortho_views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace cf {
namespace {

constexpr int kLattice = OrthoSurface::kLattice;
constexpr float kBorderPenalty = 0.6F;
/// Worse than the best at the middle of a cell by so much, a photo is the best nowhere in it.
constexpr float kShortlistMargin = 0.08F;
constexpr std::size_t kShortlistAtLeast = 5;
/// Sights flatter than this show sides, not tops.
constexpr float kFlattest = 2.5F;
/// Length over which the grid is taken for affine.
constexpr double kAffineReach_m = 100;

}  // namespace

double sightLimit(const CameraModel& camera) {
  double limit = 0;
  for (const double x : {0., camera.width - 1.})
    for (const double y : {0., camera.height - 1.})
      limit = std::max(limit, 1.05 * camera.undistort({x, y}).squaredNorm());
  return limit;
}

Eigen::Affine3d T_world_local(const GridFrame& grid, const Eigen::Vector3d& place_grid) {
  return grid.T_grid_world(grid.toWorld(place_grid)).inverse() * Eigen::Translation3d(place_grid);
}

PhotoProjection::PhotoProjection(const OrthoPhoto& photo, double sight_limit,
                                 const Eigen::Affine3d& T_world_local)
    : camera_(photo.camera), sight_limit_(sight_limit) {
  const Eigen::Affine3d T_cam_local = photo.T_world_cam.inverse() * T_world_local;
  A_ = T_cam_local.linear();
  b_ = T_cam_local.translation();
  centre_ = T_world_local.inverse() * photo.T_world_cam.translation();
}

PhotoProjection::Sight PhotoProjection::project(const Eigen::Vector3d& p) const {
  Sight sight = place(p);
  if (sight.border > -1) sight.steepness = steepness(p);
  return sight;
}

PhotoProjection::Sight PhotoProjection::place(const Eigen::Vector3d& p) const {
  Sight sight;
  const double x = p.x(), y = p.y(), z = p.z();
  const double cz = A_(2, 0) * x + A_(2, 1) * y + A_(2, 2) * z + b_.z();
  if (!(cz > 0) || !(centre_.z() > z)) return sight;
  const double per_z = 1 / cz;
  const double nx = (A_(0, 0) * x + A_(0, 1) * y + A_(0, 2) * z + b_.x()) * per_z;
  const double ny = (A_(1, 0) * x + A_(1, 1) * y + A_(1, 2) * z + b_.y()) * per_z;
  const double r2 = nx * nx + ny * ny;
  if (r2 > sight_limit_) return sight;
  const CameraModel& c = camera_;
  const double radial = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double u = c.fx * (nx * radial + 2 * c.p1 * nx * ny + c.p2 * (r2 + 2 * nx * nx)) + c.cx;
  const double v = c.fy * (ny * radial + c.p1 * (r2 + 2 * ny * ny) + 2 * c.p2 * nx * ny) + c.cy;
  sight.u = static_cast<float>(u);
  sight.v = static_cast<float>(v);
  sight.border = static_cast<float>(std::min({u, v, c.width - 1 - u, c.height - 1 - v}) / c.width);
  return sight;
}

float demerit(const PhotoProjection::Sight& sight) {
  const float inside = std::clamp(sight.border / kOrthoBorder, 0.F, 1.F);
  return sight.steepness + kBorderPenalty * (1 - inside);
}

std::vector<std::vector<OrthoCandidate>> orthoCandidates(const OrthoSurface& surface,
                                                         const GridFrame& grid,
                                                         const std::vector<OrthoPhoto>& photos) {
  const cv::Mat& lattice = surface.lattice();
  const double cell_m = kLattice * surface.node();
  std::vector<double> limits;
  for (const OrthoPhoto& photo : photos) limits.push_back(sightLimit(photo.camera));
  const Eigen::Vector3d origin(surface.left(), surface.top(), 0);
  std::vector<std::vector<OrthoCandidate>> out(lattice.total());
  tbb::parallel_for(0, lattice.rows, [&](int row) {
    const int step = std::max(1, static_cast<int>(kAffineReach_m / cell_m));
    for (int begin = 0; begin < lattice.cols; begin += step) {
      const Eigen::Vector3d middle =
          origin + Eigen::Vector3d((begin + 0.5 * step) * cell_m, -(row + 0.5) * cell_m,
                                   static_cast<double>(lattice.at<float>(
                                       row, std::min(begin + step / 2, lattice.cols - 1))));
      const Eigen::Affine3d T = T_world_local(grid, middle);
      for (std::size_t i = 0; i < photos.size(); ++i) {
        if (photos[i].thumbnail.empty()) continue;
        const PhotoProjection view(photos[i], limits[i], T);
        for (int column = begin; column < std::min(begin + step, lattice.cols); ++column) {
          const double z = static_cast<double>(lattice.at<float>(row, column)) - middle.z();
          const double x = (column - begin + 0.5 - 0.5 * step) * cell_m;
          const auto sight = view.project({x, 0, z});
          const double depth = view.centre().z() - z;
          const double rim = 0.75 * cell_m / depth * photos[i].camera.fx / photos[i].camera.width;
          if (!(depth > 0) || sight.steepness > kFlattest ||
              static_cast<double>(sight.border) < -rim)
            continue;
          // What stands on the cell falls outwards in the photo.
          const double stands =
              std::max(0.0, static_cast<double>(surface.latticeTop().at<float>(row, column)) - z -
                                middle.z());
          const double room = 2 * rim + stands * static_cast<double>(sight.steepness) /
                                            (depth - std::min(stands, 0.5 * depth)) *
                                            photos[i].camera.fx / photos[i].camera.width;
          const bool whole =
              static_cast<double>(sight.border) > static_cast<double>(kOrthoBorder) + room &&
              stands < 0.5 * depth;
          out[static_cast<std::size_t>(row * lattice.cols + column)].push_back(
              {static_cast<int>(i), demerit(sight), sight.u, sight.v, whole});
        }
      }
    }
    for (int column = 0; column < lattice.cols; ++column) {
      auto& cell = out[static_cast<std::size_t>(row * lattice.cols + column)];
      std::sort(cell.begin(), cell.end(), [](const OrthoCandidate& a, const OrthoCandidate& b) {
        return a.demerit != b.demerit ? a.demerit < b.demerit : a.photo < b.photo;
      });
    }
  });
  return out;
}

std::size_t orthoShortlist(const std::vector<OrthoCandidate>& candidates) {
  std::size_t n = 0;
  while (n < candidates.size() &&
         (n < kShortlistAtLeast ||
          candidates[n].demerit < candidates.front().demerit + kShortlistMargin))
    ++n;
  return n;
}

}  // namespace cf
