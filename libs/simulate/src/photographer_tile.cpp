// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photographer_tile.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "scene_impl.h"

namespace cf {
namespace {

constexpr int kSide = PhotoTile::kSide;
constexpr int kNodes = 5;
constexpr int kBlock = 4;  // pixels are kept in blocks of 4 x 4: one packet of rays each
static_assert(kSide % kBlock == 0);
// A good lens and the pixel's own size: light from one point spreads by half a pixel.
constexpr float kSpotVariance_px2 = 0.25F;

/// Index of pixel (x, y) of the tile, apron included.
int indexOf(int x, int y) {
  return ((y / kBlock) * (kSide / kBlock) + x / kBlock) * kBlock * kBlock + (y % kBlock) * kBlock +
         x % kBlock;
}

using Weights = Eigen::Matrix<double, kSide, kNodes>;
using Square = Eigen::Matrix<double, kSide, kSide>;

double node(int k) { return (kSide - 1.0) * k / (kNodes - 1); }

/// Lagrange's polynomials through five nodes along a side: the lens bends so little within a tile
/// that they are good to 1e-9.
Weights lagrange() {
  Weights w;
  for (int i = 0; i < kSide; ++i) {
    for (int k = 0; k < kNodes; ++k) {
      double product = 1;
      for (int m = 0; m < kNodes; ++m) {
        if (m != k) product *= (i - node(m)) / (node(k) - node(m));
      }
      w(i, k) = product;
    }
  }
  return w;
}

/// x and y of the directions (z = 1, camera frame) through all pixels; rows are image rows.
std::pair<Square, Square> directions(const TrueCamera& camera, int x0, int y0) {
  static const Weights kWeights = lagrange();
  Eigen::Matrix<double, kNodes, kNodes> nx, ny;
  for (int r = 0; r < kNodes; ++r) {
    for (int c = 0; c < kNodes; ++c) {
      const Eigen::Vector3d d =
          camera.rayThrough({x0 - PhotoTile::kApron + node(c), y0 - PhotoTile::kApron + node(r)});
      nx(r, c) = d.x();
      ny(r, c) = d.y();
    }
  }
  return {kWeights * nx * kWeights.transpose(), kWeights * ny * kWeights.transpose()};
}

/// Size on the ground of a pixel's side, along the steepest line of sight where it is oblique.
float footprint(float depth, float dx, float dy, float dz, float nx, float ny, float nz,
                float pixel) {
  const float length = std::sqrt(dx * dx + dy * dy + dz * dz);
  const float cosine = -(dx * nx + dy * ny + dz * nz) / length;
  return depth * pixel * length / std::max(cosine, 0.25F);
}

void setFootprints(Samples& s, float pixel) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.n); ++i) {
    s.footprint[i] =
        s.t[i] < 0 ? 1.0F
                   : footprint(s.t[i], s.dx[i], s.dy[i], s.dz[i], s.nx[i], s.ny[i], s.nz[i], pixel);
  }
}

/// Whether two neighbouring pixels see different things: an edge runs between them.
bool differ(const Scene::Impl& scene, const Samples& s, std::size_t i, std::size_t j) {
  if (s.object[i] != s.object[j] || (s.t[i] < 0) != (s.t[j] < 0)) return true;
  if (s.t[i] < 0) return false;
  // Off the tangent plane by more than some footprints: one part hides another of the object.
  const float step =
      s.nx[i] * (s.x[j] - s.x[i]) + s.ny[i] * (s.y[j] - s.y[i]) + s.nz[i] * (s.z[j] - s.z[i]);
  if (std::abs(step) > 3 * s.footprint[i]) return true;
  // The facets of a crown are all turned differently, and shade each other: that is its texture.
  return !scene.isPlant(s.object[i]) && (s.sun[i] > 0) != (s.sun[j] > 0);
}

}  // namespace

Eigen::Isometry3d poseAt(const CameraMotion& motion, double time_s) {
  Eigen::Isometry3d pose = motion.T_world_cam;
  pose.pretranslate(motion.velocity_mps * time_s);
  const Eigen::Vector3d turn = motion.angular_velocity_radps * time_s;
  if (turn.norm() > 0) pose.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return pose;
}

double timeOfRow(const TrueCamera& camera, const PhotoOptions& options, double row) {
  if (camera.height < 2) return 0;
  return options.readout_s * (row / (camera.height - 1) - 0.5);
}

PhotoTile::PhotoTile()
    : pixels_(kSide * kSide),
      extra_(0),
      light_(std::size_t{3} * kSide * kSide),
      blurred_(std::size_t{3} * kSide * kSide),
      sum_(std::size_t{3} * kSide * kSide) {}

void PhotoTile::render(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
                       const PhotoOptions& options, int x0, int y0, int moments) {
  std::fill(sum_.begin(), sum_.end(), 0.0F);
  for (int k = 0; k < moments; ++k) {
    const double moment_s = options.exposure_s * ((k + 0.5) / moments - 0.5);
    castRays(scene, camera, motion, options, x0, y0, moment_s);
    refineEdges(scene, camera, options.edge_samples);
    blur(camera, motion, options.exposure_s / moments);
    for (std::size_t i = 0; i < sum_.size(); ++i) {
      sum_[i] += blurred_[i] / static_cast<float>(moments);
    }
  }
}

std::array<float, 3> PhotoTile::light(int x, int y) const {
  const auto i = std::size_t{3} * static_cast<std::size_t>(indexOf(x + kApron, y + kApron));
  return {sum_[i], sum_[i + 1], sum_[i + 2]};
}

void PhotoTile::castRays(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
                         const PhotoOptions& options, int x0, int y0, double moment_s) {
  const auto [nx, ny] = directions(camera, x0, y0);
  for (int y = 0; y < kSide; ++y) {
    const double time_s = timeOfRow(camera, options, y0 - kApron + y) + moment_s;
    const Eigen::Isometry3d T_world_cam = poseAt(motion, time_s);
    const Eigen::Vector3d origin = T_world_cam.translation() - scene.impl().offset();
    const Eigen::Matrix3d rotation = T_world_cam.linear();
    for (int x = 0; x < kSide; ++x) {
      const auto i = static_cast<std::size_t>(indexOf(x, y));
      const Eigen::Vector3d d = rotation * Eigen::Vector3d(nx(y, x), ny(y, x), 1);
      pixels_.ox[i] = static_cast<float>(origin.x());
      pixels_.oy[i] = static_cast<float>(origin.y());
      pixels_.oz[i] = static_cast<float>(origin.z());
      pixels_.dx[i] = static_cast<float>(d.x());
      pixels_.dy[i] = static_cast<float>(d.y());
      pixels_.dz[i] = static_cast<float>(d.z());
    }
  }
  scene.impl().trace(pixels_);
  setFootprints(pixels_, static_cast<float>(1 / camera.focal));
  scene.impl().shade(pixels_);
  for (std::size_t i = 0; i < static_cast<std::size_t>(pixels_.n); ++i) {
    light_[3 * i] = pixels_.blue[i];
    light_[3 * i + 1] = pixels_.green[i];
    light_[3 * i + 2] = pixels_.red[i];
  }
}

void PhotoTile::refineEdges(const Scene& scene, const TrueCamera& camera, int samples_per_pixel) {
  if (samples_per_pixel < 2) return;
  edges_.clear();
  for (int y = 1; y + 1 < kSide; ++y) {
    for (int x = 1; x + 1 < kSide; ++x) {
      const auto i = static_cast<std::size_t>(indexOf(x, y));
      for (const int j :
           {indexOf(x + 1, y), indexOf(x - 1, y), indexOf(x, y + 1), indexOf(x, y - 1)}) {
        if (!differ(scene.impl(), pixels_, i, static_cast<std::size_t>(j))) continue;
        edges_.push_back(y * kSide + x);
        break;
      }
    }
  }
  extra_.resize(static_cast<int>(edges_.size()) * samples_per_pixel);
  std::size_t next = 0;
  for (const int edge : edges_) {
    const int x = edge % kSide, y = edge / kSide;
    const auto i = static_cast<std::size_t>(indexOf(x, y));
    const auto left = static_cast<std::size_t>(indexOf(x - 1, y));
    const auto right = static_cast<std::size_t>(indexOf(x + 1, y));
    const auto up = static_cast<std::size_t>(indexOf(x, y - 1));
    const auto down = static_cast<std::size_t>(indexOf(x, y + 1));
    for (int k = 0; k < samples_per_pixel; ++k, ++next) {
      // A rank-1 lattice over the pixel: no two samples share a row or a column.
      const float u = (static_cast<float>(k) + 0.5F) / static_cast<float>(samples_per_pixel) - 0.5F;
      const float turned = 0.618034F * (static_cast<float>(k) + 0.5F);
      const float v = turned - std::floor(turned) - 0.5F;
      auto between = [&](const std::vector<float>& a) {
        return a[i] + u / 2 * (a[right] - a[left]) + v / 2 * (a[down] - a[up]);
      };
      extra_.ox[next] = between(pixels_.ox);
      extra_.oy[next] = between(pixels_.oy);
      extra_.oz[next] = between(pixels_.oz);
      extra_.dx[next] = between(pixels_.dx);
      extra_.dy[next] = between(pixels_.dy);
      extra_.dz[next] = between(pixels_.dz);
    }
  }
  scene.impl().trace(extra_);
  setFootprints(extra_, static_cast<float>(1 / camera.focal));
  scene.impl().shade(extra_);
  next = 0;
  const float share = 1 / static_cast<float>(samples_per_pixel);
  for (const int edge : edges_) {
    float* light =
        &light_[std::size_t{3} * static_cast<std::size_t>(indexOf(edge % kSide, edge / kSide))];
    std::fill_n(light, 3, 0.0F);
    for (int k = 0; k < samples_per_pixel; ++k, ++next) {
      light[0] += share * extra_.blue[next];
      light[1] += share * extra_.green[next];
      light[2] += share * extra_.red[next];
    }
  }
}

void PhotoTile::blur(const TrueCamera& camera, const CameraMotion& motion, double exposure_s) {
  blurred_ = light_;
  const Eigen::Matrix3f R_cam_world = motion.T_world_cam.linear().transpose().cast<float>();
  const Eigen::Vector3f velocity = R_cam_world * motion.velocity_mps.cast<float>();
  const Eigen::Vector3f turn = motion.angular_velocity_radps.cast<float>();
  const bool moves = exposure_s > 0 && !(velocity.isZero() && turn.isZero());
  const auto pixels_moved = static_cast<float>(camera.focal * exposure_s);
  for (int y = 1; y + 1 < kSide; ++y) {
    for (int x = 1; x + 1 < kSide; ++x) {
      const auto i = static_cast<std::size_t>(indexOf(x, y));
      // 3 x 3 weights with the second moments of the lens' spot and of a bar of length (u, v):
      // L²/12.
      float xx = kSpotVariance_px2 / 2, yy = kSpotVariance_px2 / 2, xy = 0;
      if (moves && pixels_.t[i] >= 0) {
        const Eigen::Vector3f n =
            R_cam_world * Eigen::Vector3f(pixels_.dx[i], pixels_.dy[i], pixels_.dz[i]);
        const Eigen::Vector3f flow = -velocity / pixels_.t[i] - turn.cross(n);
        const float u = pixels_moved * (flow.x() - n.x() * flow.z());
        const float v = pixels_moved * (flow.y() - n.y() * flow.z());
        constexpr float kLeast_px = 0.1F;
        if (u * u + v * v > kLeast_px * kLeast_px) {
          xx += u * u / 24;
          yy += v * v / 24;
          xy = u * v / 48;
        }
      }
      const float* middle = &light_[3 * i];
      auto at = [&](int dx, int dy) {
        return &light_[std::size_t{3} * static_cast<std::size_t>(indexOf(x + dx, y + dy))];
      };
      const float *w = at(-1, 0), *e = at(1, 0), *n = at(0, -1), *s = at(0, 1);
      const float *nw = at(-1, -1), *ne = at(1, -1), *sw = at(-1, 1), *se = at(1, 1);
      for (std::size_t c = 0; c < 3; ++c) {
        blurred_[3 * i + c] = middle[c] * (1 - 2 * xx - 2 * yy) + xx * (w[c] + e[c]) +
                              yy * (n[c] + s[c]) + xy * (se[c] + nw[c] - ne[c] - sw[c]);
      }
    }
  }
}

}  // namespace cf
