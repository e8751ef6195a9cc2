// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "scene_impl.h"

namespace cf {
namespace {

constexpr int kPacket = 16;
constexpr float kShadowOffset_m = 2e-3F;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Without the flag for coherent rays: with it Embree 3.13.5 never returns from some packets of
// shadow rays among instances.
RTCIntersectContext newContext() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return context;
}

}  // namespace

std::uint32_t Scene::Impl::objectOf(unsigned geometry, unsigned primitive,
                                    unsigned instance) const {
  if (instance != RTC_INVALID_GEOMETRY_ID) {
    return static_cast<std::uint32_t>(1 + parts_.size()) + instance - 2;
  }
  return geometry == 0 ? 0 : 1 + part_of_[primitive];
}

const Scene::Impl::Plant* Scene::Impl::plantOf(std::uint32_t object) const {
  const std::size_t first = 1 + parts_.size();
  return object < first ? nullptr : &plants_[object - first];
}

void Scene::Impl::trace(Samples& s) const {
  RTCIntersectContext context = newContext();
  for (int first = 0; first < s.n; first += kPacket) {
    const int count = std::min(kPacket, s.n - first);
    alignas(64) int valid[kPacket];
    RTCRayHit16 packet;
    for (int k = 0; k < kPacket; ++k) {
      valid[k] = k < count ? -1 : 0;
      const auto i = static_cast<std::size_t>(first + std::min(k, count - 1));
      packet.ray.org_x[k] = s.ox[i], packet.ray.org_y[k] = s.oy[i], packet.ray.org_z[k] = s.oz[i];
      packet.ray.dir_x[k] = s.dx[i], packet.ray.dir_y[k] = s.dy[i], packet.ray.dir_z[k] = s.dz[i];
      packet.ray.tnear[k] = 0;
      packet.ray.tfar[k] = kInfinity;
      packet.ray.time[k] = 0;
      packet.ray.mask[k] = ~0U;
      packet.ray.flags[k] = 0;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scene_.get(), &context, &packet);
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(first + k);
      s.t[i] = -1;
      if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
      const float t = packet.ray.tfar[k];
      s.t[i] = t;
      s.x[i] = s.ox[i] + t * s.dx[i];
      s.y[i] = s.oy[i] + t * s.dy[i];
      s.z[i] = s.oz[i] + t * s.dz[i];
      s.object[i] = objectOf(packet.hit.geomID[k], packet.hit.primID[k], packet.hit.instID[0][k]);
      Eigen::Vector3f normal(packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]);
      if (const Plant* plant = plantOf(s.object[i])) {
        normal = plant->inverse_shape.transpose() * normal;
      }
      normal.normalize();
      if (normal.dot(Eigen::Vector3f(s.dx[i], s.dy[i], s.dz[i])) > 0) normal = -normal;
      s.nx[i] = normal.x(), s.ny[i] = normal.y(), s.nz[i] = normal.z();
    }
  }
}

void Scene::Impl::castShadows(Samples& s) const {
  RTCIntersectContext context = newContext();
  std::vector<std::size_t> lit;
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.n); ++i) {
    if (s.t[i] >= 0 && s.sun[i] > 0) lit.push_back(i);
  }
  for (std::size_t first = 0; first < lit.size(); first += kPacket) {
    const std::size_t count = std::min<std::size_t>(kPacket, lit.size() - first);
    alignas(64) int valid[kPacket];
    RTCRay16 packet;
    for (std::size_t k = 0; k < kPacket; ++k) {
      // Lanes without a ray of their own hold one too: Embree bounds whole packets.
      const std::size_t i = lit[first + std::min(k, count - 1)];
      valid[k] = k < count ? -1 : 0;
      packet.org_x[k] = s.x[i] + kShadowOffset_m * s.nx[i];
      packet.org_y[k] = s.y[i] + kShadowOffset_m * s.ny[i];
      packet.org_z[k] = s.z[i] + kShadowOffset_m * s.nz[i];
      packet.dir_x[k] = to_sun_.x();
      packet.dir_y[k] = to_sun_.y();
      packet.dir_z[k] = to_sun_.z();
      packet.tnear[k] = 0;
      packet.tfar[k] = kInfinity;
      packet.time[k] = 0;
      packet.mask[k] = ~0U;
      packet.flags[k] = 0;
    }
    rtcOccluded16(valid, scene_.get(), &context, &packet);
    for (std::size_t k = 0; k < count; ++k) {
      if (packet.tfar[k] < 0) s.sun[lit[first + k]] = 0;
    }
  }
}

std::optional<SurfaceHit> Scene::Impl::hit(const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction) const {
  RTCIntersectContext context = newContext();
  RTCRayHit ray = {};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tfar = kInfinity;
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  // Again with the plane of the triangle, in double.
  SurfaceHit found;
  found.object = objectOf(ray.hit.geomID, ray.hit.primID, ray.hit.instID[0]);
  const Plant* plant = plantOf(found.object);
  const Mesh& mesh = plant != nullptr ? crowns_[static_cast<std::size_t>(plant->crown)]
                                      : (ray.hit.geomID == 0 ? ground_ : built_);
  auto vertex = [&](std::size_t k) -> Eigen::Vector3d {
    const Eigen::Vector3d v =
        mesh.vertices[mesh.corners[std::size_t{3} * ray.hit.primID + k]].cast<double>();
    if (plant == nullptr) return v;
    return plant->shape.cast<double>() * v + plant->centre.cast<double>();
  };
  const Eigen::Vector3d corner = vertex(0);
  found.normal = (vertex(1) - corner).cross(vertex(2) - corner).normalized();
  if (found.normal.dot(direction) > 0) found.normal = -found.normal;
  found.distance = found.normal.dot(corner - origin) / found.normal.dot(direction);
  // Along a triangle seen edge-on its plane says nothing.
  const double coarse = static_cast<double>(ray.ray.tfar);
  if (!(std::abs(found.distance - coarse) < 1e-3 * coarse)) found.distance = coarse;
  found.position_m = origin + found.distance * direction;
  return found;
}

}  // namespace cf
