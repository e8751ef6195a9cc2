// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "trees.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <map>

#include "random_stream.h"

namespace cf {
namespace {

using Eigen::Vector3f;

CrownMesh sphere(int divisions) {
  CrownMesh mesh;
  const float g = (1 + std::sqrt(5.0F)) / 2;
  for (const auto& v : std::array<Vector3f, 12>{{{-1, g, 0},
                                                 {1, g, 0},
                                                 {-1, -g, 0},
                                                 {1, -g, 0},
                                                 {0, -1, g},
                                                 {0, 1, g},
                                                 {0, -1, -g},
                                                 {0, 1, -g},
                                                 {g, 0, -1},
                                                 {g, 0, 1},
                                                 {-g, 0, -1},
                                                 {-g, 0, 1}}}) {
    mesh.vertices.push_back(v.normalized());
  }
  mesh.corners = {0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                  4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                  6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (int d = 0; d < divisions; ++d) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) {
        mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      }
      return it->second;
    };
    std::vector<std::uint32_t> finer;
    for (std::size_t t = 0; t < mesh.corners.size(); t += 3) {
      const auto a = mesh.corners[t], b = mesh.corners[t + 1], c = mesh.corners[t + 2];
      const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca});
    }
    mesh.corners = finer;
  }
  return mesh;
}

Vector3f randomDirection(RandomStream& dice) {
  const double z = dice.uniform(-1, 1), around = dice.uniform(0, 2 * M_PI);
  const double r = std::sqrt(1 - z * z);
  return Eigen::Vector3d(r * std::cos(around), r * std::sin(around), z).cast<float>();
}

struct Lump {
  Vector3f centre;
  float radius;
};

/// How far a ray from the origin goes before it leaves the union of the lumps.
float reach(const Vector3f& direction, const std::vector<Lump>& lumps) {
  float farthest = 0.25F;
  for (const auto& lump : lumps) {
    const float along = direction.dot(lump.centre);
    const float h = along * along - lump.centre.squaredNorm() + lump.radius * lump.radius;
    if (h > 0) farthest = std::max(farthest, along + std::sqrt(h));
  }
  return farthest;
}

/// A round crown: boughs, and twigs upon them.
void shapeBroadleaf(CrownMesh& mesh, RandomStream& dice) {
  std::vector<Lump> boughs, twigs;
  const int count = 14 + dice.below(14);
  for (int k = 0; k < count; ++k) {
    boughs.push_back({static_cast<float>(dice.uniform(0.4, 0.7)) * randomDirection(dice),
                      static_cast<float>(dice.uniform(0.22, 0.42))});
  }
  for (int k = 0; k < 170; ++k) {
    const Vector3f d = randomDirection(dice);
    twigs.push_back({(reach(d, boughs) - 0.06F) * d, static_cast<float>(dice.uniform(0.06, 0.17))});
  }
  boughs.insert(boughs.end(), twigs.begin(), twigs.end());
  for (auto& v : mesh.vertices)
    v *= reach(v, boughs) * static_cast<float>(dice.uniform(0.93, 1.05));
}

/// A cone of whorls: long and short boughs in turn, all around and upwards.
void shapeConifer(CrownMesh& mesh, RandomStream& dice) {
  const double phase = dice.uniform(0, 2 * M_PI);
  for (auto& v : mesh.vertices) {
    const float z = v.z();
    const double around = std::atan2(v.y(), v.x());
    const double whorl = 0.5 + 0.5 * std::cos(9 * M_PI * z);
    const double bough = 0.5 + 0.5 * std::cos(11 * around + phase + 4 * std::floor(4.5 * z));
    const double width =
        (1 - z) / 2 * (0.62 + 0.25 * whorl + 0.25 * bough) * dice.uniform(0.9, 1.06);
    const auto r = static_cast<float>(width / std::max(0.05, std::sqrt(1.0 - z * z)));
    v.x() *= r;
    v.y() *= r;
  }
}

/// A clipped box, long in x.
void shapeHedge(CrownMesh& mesh, RandomStream& dice) {
  for (auto& v : mesh.vertices) {
    const float largest = v.cwiseAbs().maxCoeff();
    v /= largest;
    v.y() *= static_cast<float>(dice.uniform(0.82, 1.1));
    v.z() *= static_cast<float>(dice.uniform(0.85, 1.08));
    v.x() *= static_cast<float>(dice.uniform(0.98, 1.0));
  }
}

}  // namespace

CrownMesh makeCrown(Greenery kind, std::uint64_t seed) {
  constexpr int kDivisions = 5;
  CrownMesh mesh = sphere(kDivisions);
  RandomStream dice(seed);
  switch (kind) {
    case Greenery::kBroadleaf:
      shapeBroadleaf(mesh, dice);
      break;
    case Greenery::kConifer:
      shapeConifer(mesh, dice);
      break;
    case Greenery::kHedge:
      shapeHedge(mesh, dice);
      break;
  }
  return mesh;
}

}  // namespace cf
