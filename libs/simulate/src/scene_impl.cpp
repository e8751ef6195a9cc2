// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scene_impl.h"

#include <cmath>
#include <limits>

#include "cf/base/error.h"
#include "texture_noise.h"

namespace cf {
namespace {

constexpr int kPacket = 16;
constexpr float kShadowOffset_m = 2e-3F;

Eigen::Vector3f sunDirection(const SceneOptions& options) {
  const double azimuth = options.sun_azimuth_deg * M_PI / 180;
  const double elevation = options.sun_elevation_deg * M_PI / 180;
  return Eigen::Vector3d(std::sin(azimuth) * std::cos(elevation),
                         std::cos(azimuth) * std::cos(elevation), std::sin(elevation))
      .cast<float>();
}

/// What the terrain must cover beyond the area, so that no oblique ray looks over its edge.
Eigen::Vector2d halfExtent(const Eigen::AlignedBox2d& area) {
  return area.sizes() / 2 + Eigen::Vector2d::Constant(40);
}

RTCGeometry newMesh(RTCDevice device, const std::vector<Eigen::Vector3f>& vertices,
                    const std::vector<std::uint32_t>& corners) {
  RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(
      mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices.size()));
  for (const auto& p : vertices) {
    *v++ = p.x();
    *v++ = p.y();
    *v++ = p.z();
  }
  auto* c = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), corners.size() / 3));
  std::copy(corners.begin(), corners.end(), c);
  rtcCommitGeometry(mesh);
  return mesh;
}

}  // namespace

Scene::Impl::Impl(const SceneOptions& options, const Eigen::AlignedBox2d& area, std::uint64_t seed)
    : area_(area),
      offset_(area.center().x(), area.center().y(), 0),
      seed_(seed),
      terrain_(options.terrain == "hills", options.relief_m, halfExtent(area), seed),
      to_sun_(sunDirection(options)) {
  if (area.isEmpty()) throw UsageError("the scene's area is empty");
  // One thread: the tree, and so which of two triangles a ray through their common edge hits, does
  // not depend on the number of cores.
  device_ = rtcNewDevice("threads=1");
  if (device_ == nullptr) throw RunError("Embree does not start on this machine");
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  addGround();
  rtcCommitScene(scene_);
}

Scene::Impl::~Impl() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  if (device_ != nullptr) rtcReleaseDevice(device_);
}

void Scene::Impl::addGround() {
  std::vector<Eigen::Vector3f> vertices;
  for (int r = 0; r < terrain_.rows(); ++r) {
    for (int c = 0; c < terrain_.columns(); ++c) vertices.push_back(terrain_.vertex(c, r));
  }
  RTCGeometry mesh = newMesh(device_, vertices, terrain_.triangles());
  rtcAttachGeometry(scene_, mesh);
  rtcReleaseGeometry(mesh);
}

void Scene::Impl::trace(Samples& s) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
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
      packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
      packet.ray.time[k] = 0;
      packet.ray.mask[k] = ~0U;
      packet.ray.flags[k] = 0;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scene_, &context, &packet);
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(first + k);
      s.t[i] = -1;
      if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
      const float t = packet.ray.tfar[k];
      s.t[i] = t;
      s.x[i] = s.ox[i] + t * s.dx[i];
      s.y[i] = s.oy[i] + t * s.dy[i];
      s.z[i] = s.oz[i] + t * s.dz[i];
      Eigen::Vector3f normal(packet.hit.Ng_x[k], packet.hit.Ng_y[k], packet.hit.Ng_z[k]);
      normal.normalize();
      if (normal.dot(Eigen::Vector3f(s.dx[i], s.dy[i], s.dz[i])) > 0) normal = -normal;
      s.nx[i] = normal.x(), s.ny[i] = normal.y(), s.nz[i] = normal.z();
      s.object[i] = 0;
    }
  }
}

void Scene::Impl::castShadows(Samples& s) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  int next = 0;
  while (next < s.n) {
    alignas(64) int valid[kPacket] = {};
    int sample[kPacket];
    RTCRay16 packet;
    int count = 0;
    for (; next < s.n && count < kPacket; ++next) {
      const auto i = static_cast<std::size_t>(next);
      if (s.t[i] < 0 || s.sun[i] <= 0) continue;
      packet.org_x[count] = s.x[i] + kShadowOffset_m * s.nx[i];
      packet.org_y[count] = s.y[i] + kShadowOffset_m * s.ny[i];
      packet.org_z[count] = s.z[i] + kShadowOffset_m * s.nz[i];
      packet.dir_x[count] = to_sun_.x();
      packet.dir_y[count] = to_sun_.y();
      packet.dir_z[count] = to_sun_.z();
      packet.tnear[count] = 0;
      packet.tfar[count] = std::numeric_limits<float>::infinity();
      packet.time[count] = 0;
      packet.mask[count] = ~0U;
      packet.flags[count] = 0;
      valid[count] = -1;
      sample[count++] = next;
    }
    rtcOccluded16(valid, scene_, &context, &packet);
    for (int k = 0; k < count; ++k) {
      if (packet.tfar[k] < 0) s.sun[static_cast<std::size_t>(sample[k])] = 0;
    }
  }
}

void Scene::Impl::shade(Samples& s) const {
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.n); ++i) {
    s.sun[i] = 0;
    if (s.t[i] < 0) continue;
    Eigen::Vector3f normal(s.nx[i], s.ny[i], s.nz[i]);
    if (s.object[i] == 0) normal = terrain_.normal(s.x[i], s.y[i]);
    s.sun[i] = std::max(0.0F, normal.dot(to_sun_));
  }
  castShadows(s);
  std::vector<float> value(static_cast<std::size_t>(s.n), 0.0F);
  Spectrum spectrum;
  spectrum.fill(0.16F);
  addNoise(s.n, s.x.data(), s.y.data(), s.footprint.data(), spectrum,
           static_cast<std::uint32_t>(seed_), value.data());
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.n); ++i) {
    const float light = 1.25F * s.sun[i] + 0.28F;
    const float shade = light * std::max(0.1F, 1 + value[i]);
    s.blue[i] = 0.05F * shade, s.green[i] = 0.11F * shade, s.red[i] = 0.09F * shade;
    if (s.t[i] < 0) s.blue[i] = 0.8F, s.green[i] = 0.7F, s.red[i] = 0.6F;
  }
}

std::optional<SurfaceHit> Scene::Impl::hit(const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray = {};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  // Again with the plane of the triangle, in double.
  RTCGeometry mesh = rtcGetGeometry(scene_, ray.hit.geomID);
  const auto* vertices =
      static_cast<const float*>(rtcGetGeometryBufferData(mesh, RTC_BUFFER_TYPE_VERTEX, 0));
  const auto* corners =
      static_cast<const std::uint32_t*>(rtcGetGeometryBufferData(mesh, RTC_BUFFER_TYPE_INDEX, 0)) +
      std::size_t{3} * ray.hit.primID;
  auto vertex = [&](int k) -> Eigen::Vector3d {
    return Eigen::Map<const Eigen::Vector3f>(vertices + std::size_t{3} * corners[k]).cast<double>();
  };
  SurfaceHit found;
  found.normal = (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0)).normalized();
  if (found.normal.dot(direction) > 0) found.normal = -found.normal;
  found.distance = found.normal.dot(vertex(0) - origin) / found.normal.dot(direction);
  found.position_m = origin + found.distance * direction;
  return found;
}

}  // namespace cf
