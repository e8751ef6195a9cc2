// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scene_objects.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "cf/view/render.h"

namespace cf {
namespace {

using mrpt::opengl::CSetOfTriangles;
using mrpt::opengl::TTriangle;
using Rgb = Eigen::Matrix<std::uint8_t, 3, 1>;

mrpt::math::TPoint3Df point(const Eigen::Vector3d& p) {
  const Eigen::Vector3f f = p.cast<float>();
  return {f.x(), f.y(), f.z()};
}

void addTriangle(CSetOfTriangles& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                 const Eigen::Vector3d& c, const Rgb& rgb) {
  TTriangle t(point(a), point(b), point(c));
  t.setColor(mrpt::img::TColor(rgb[0], rgb[1], rgb[2], 255));
  mesh.insertTriangle(t);
}

void addQuad(CSetOfTriangles& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
             const Eigen::Vector3d& c, const Eigen::Vector3d& d, const Rgb& rgb) {
  addTriangle(mesh, a, b, c, rgb);
  addTriangle(mesh, a, c, d, rgb);
}

constexpr int kSides = 10;

// Truncated cone from a to b.
void addTube(CSetOfTriangles& mesh, const Eigen::Vector3d& a, double radius_a,
             const Eigen::Vector3d& b, double radius_b, const Rgb& rgb) {
  const Eigen::Vector3d axis = b - a;
  if (axis.norm() < 1e-6) return;
  const Eigen::Vector3d n = axis.normalized();
  const Eigen::Vector3d x =
      n.cross(std::abs(n.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX())
          .normalized();
  const Eigen::Vector3d y = n.cross(x);
  for (int i = 0; i < kSides; ++i) {
    const double s = 2 * M_PI * i / kSides, t = 2 * M_PI * (i + 1) / kSides;
    const Eigen::Vector3d ds = std::cos(s) * x + std::sin(s) * y;
    const Eigen::Vector3d dt = std::cos(t) * x + std::sin(t) * y;
    addQuad(mesh, a + radius_a * ds, b + radius_b * ds, b + radius_b * dt, a + radius_a * dt, rgb);
  }
}

void addBall(CSetOfTriangles& mesh, const Eigen::Vector3d& centre, double radius, const Rgb& rgb) {
  constexpr int kRings = 6;
  const auto at = [&](int ring, int side) -> Eigen::Vector3d {
    const double polar = M_PI * ring / kRings, turn = 2 * M_PI * side / kSides;
    return centre + radius * Eigen::Vector3d(std::sin(polar) * std::cos(turn),
                                             std::sin(polar) * std::sin(turn), std::cos(polar));
  };
  for (int r = 0; r < kRings; ++r)
    for (int s = 0; s < kSides; ++s)
      addQuad(mesh, at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s + 1), rgb);
}

// Points along the last leg of the track that is long enough to have a direction.
Eigen::Vector3d heading(const std::vector<Eigen::Vector3d>& track, double shortest_m) {
  for (std::size_t i = track.size(); i > 1; --i) {
    const Eigen::Vector3d leg = track.back() - track[i - 2];
    if (leg.norm() > shortest_m) return leg;
  }
  return Eigen::Vector3d::UnitY();
}

void addTrack(CSetOfTriangles& mesh, const UavTrack& track, const Rgb& rgb,
              const LineStyle& style) {
  const auto radius = [&](const Eigen::Vector3d& p) {
    return 0.5 * style.track_px * style.metres_per_pixel(p);
  };
  const auto& p = track.positions_m;
  for (std::size_t i = 0; i < p.size(); ++i) {
    addBall(mesh, p[i], 1.5 * radius(p[i]), rgb);
    if (i > 0) addTube(mesh, p[i - 1], radius(p[i - 1]), p[i], radius(p[i]), rgb);
  }
  const Eigen::Vector3d end = p.back();
  const double length = style.triangle_px * style.metres_per_pixel(end);
  const Eigen::Vector3d leg = heading(p, 0.2 * length);
  Eigen::Vector3d ahead = leg.dot(style.right) * style.right + leg.dot(style.up) * style.up;
  ahead = ahead.norm() > 1e-9 ? ahead.normalized() : style.up;
  const Eigen::Vector3d side = ahead.cross(style.right.cross(style.up));
  addTriangle(mesh, end + 0.75 * length * ahead, end - 0.25 * length * ahead + 0.42 * length * side,
              end - 0.25 * length * ahead - 0.42 * length * side, rgb);
}

}  // namespace

double pointSpacing(const std::vector<ColouredPoint>& cloud) {
  if (cloud.size() < 2) return 1;
  const std::size_t coarse = std::max<std::size_t>(1, cloud.size() / 100'000);
  std::vector<float> xs, ys;
  for (std::size_t i = 0; i < cloud.size(); i += coarse) {
    xs.push_back(cloud[i].position_m.x());
    ys.push_back(cloud[i].position_m.y());
  }
  const auto span = [](std::vector<float>& v) {
    std::sort(v.begin(), v.end());
    return std::max(0.1, static_cast<double>(v[v.size() * 98 / 100] - v[v.size() * 2 / 100]));
  };
  const double cell = 1.5 * std::sqrt(span(xs) * span(ys) / static_cast<double>(cloud.size()));
  using Key = std::uint64_t;
  const auto key = [&](double x, double y) -> Key {
    const auto index = [&](double at) {
      return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(at / cell)));
    };
    return Key{index(x)} << 32 | index(y);
  };
  // The cells around a few samples, and the points in them.
  std::unordered_map<Key, std::vector<std::uint32_t>> grid;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / 2000);
  for (std::size_t i = 0; i < cloud.size(); i += step)
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        grid[key(cloud[i].position_m.x() + dx * cell, cloud[i].position_m.y() + dy * cell)];
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto found = grid.find(key(cloud[i].position_m.x(), cloud[i].position_m.y()));
    if (found != grid.end()) found->second.push_back(static_cast<std::uint32_t>(i));
  }
  // The fourth neighbour of a sample: what a square of points around it would be apart.
  std::vector<double> distances;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    const Eigen::Vector3f& p = cloud[i].position_m;
    std::vector<float> near;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (const auto j : grid.at(key(p.x() + dx * cell, p.y() + dy * cell)))
          if (j != i) near.push_back((cloud[j].position_m - p).norm());
    const std::size_t rank = 3;
    if (near.size() <= rank) continue;
    std::nth_element(near.begin(), near.begin() + rank, near.end());
    distances.push_back(near[rank]);
  }
  if (distances.empty()) return cell;
  std::nth_element(distances.begin(),
                   distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                   distances.end());
  return distances[distances.size() / 2];
}

HeightRange heightRange(const std::vector<ColouredPoint>& cloud) {
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / 200'000);
  std::vector<float> z;
  for (std::size_t i = 0; i < cloud.size(); i += step) z.push_back(cloud[i].position_m.z());
  if (z.empty()) return {};
  std::sort(z.begin(), z.end());
  const auto at = [&](double share) {
    return z[static_cast<std::size_t>(share * static_cast<double>(z.size() - 1))];
  };
  HeightRange range{at(0.02), at(0.98)};
  range.max_m = std::max(range.max_m, range.min_m + 0.1);
  return range;
}

cv::Mat heightRamp() {
  cv::Mat steps(256, 1, CV_8UC1), ramp;
  for (int i = 0; i < 256; ++i) steps.at<std::uint8_t>(i) = static_cast<std::uint8_t>(i);
  cv::applyColorMap(steps, ramp, cv::COLORMAP_VIRIDIS);
  return ramp;
}

mrpt::opengl::CPointCloudColoured::Ptr cloudObject(const std::vector<ColouredPoint>& cloud,
                                                   const HeightRange* by_height) {
  auto object = mrpt::opengl::CPointCloudColoured::Create();
  object->resize(cloud.size());
  const cv::Mat ramp = heightRamp();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const ColouredPoint& p = cloud[i];
    Rgb rgb(p.rgb[0], p.rgb[1], p.rgb[2]);
    if (by_height != nullptr) {
      const double share =
          (p.position_m.z() - by_height->min_m) / (by_height->max_m - by_height->min_m);
      const auto bgr = ramp.at<cv::Vec3b>(cvRound(255 * std::clamp(share, 0.0, 1.0)));
      rgb = {bgr[2], bgr[1], bgr[0]};
    }
    object->setPoint_fast(
        i, mrpt::math::TPointXYZfRGBAu8(p.position_m.x(), p.position_m.y(), p.position_m.z(),
                                        rgb[0], rgb[1], rgb[2]));
  }
  object->markAllPointsAsNew();
  return object;
}

mrpt::opengl::CSetOfTriangles::Ptr voxelObject(const std::vector<Voxel>& voxels,
                                               const ViewCamera& camera) {
  // Light from above and a little from the south-east: one factor for each side of a cube.
  constexpr double kLight[6] = {0.62, 0.80, 0.86, 0.58, 0.40, 1.0};
  const Eigen::Vector3d eye = camera.eye();
  auto object = CSetOfTriangles::Create();
  object->enableLight(false);
  for (const auto& v : voxels)
    for (int face = 0; face < 6; ++face) {
      if ((v.faces & (1 << face)) == 0) continue;
      const int axis = face / 2;
      const double h = 0.5 * static_cast<double>(v.size_m);
      Eigen::Vector3d n = Eigen::Vector3d::Zero(), a = n, b = n;
      n[axis] = face % 2 == 0 ? -h : h;
      const Eigen::Vector3d c = v.centre_m.cast<double>() + n;
      const Eigen::Vector3d sight = camera.orthographic ? camera.forward() : c - eye;
      if (n.dot(sight) >= 0) continue;  // faces away
      a[(axis + 1) % 3] = h;
      b[(axis + 2) % 3] = h;
      Rgb rgb;
      for (int k = 0; k < 3; ++k) rgb[k] = static_cast<std::uint8_t>(kLight[face] * v.rgb[k]);
      addQuad(*object, c - a - b, c + a - b, c + a + b, c - a + b, rgb);
    }
  return object;
}

mrpt::opengl::CSetOfTriangles::Ptr lineObject(const SceneInputs& scene, const LineStyle& style) {
  auto object = CSetOfTriangles::Create();
  object->enableLight(false);
  const Rgb red(255, 30, 30);
  for (const auto& link : scene.links) {
    const double half = 0.5 * style.link_px;
    addTube(*object, link.a_m, half * style.metres_per_pixel(link.a_m), link.b_m,
            half * style.metres_per_pixel(link.b_m), red);
  }
  std::size_t index = 0;
  for (const auto& track : scene.tracks) {
    const Rgb rgb = uavColour(track.central, index);
    if (!track.central) ++index;
    if (!track.positions_m.empty()) addTrack(*object, track, rgb, style);
  }
  return object;
}

}  // namespace cf
