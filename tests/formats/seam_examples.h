// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "cf/formats/seam_message.h"

/// Messages of the seam with every field set, and whether two are the same bit by bit.
namespace cf::support {

inline Eigen::Isometry3d someIsometry(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                   .normalized()
                   .toRotationMatrix();
  T.translation() << normal(random), -0.0, 1e-310 * normal(random);
  return T;
}

inline CameraModel someCamera() {
  CameraModel c;
  c.width = 4000;
  c.height = 3000;
  c.fx = 2400.1;
  c.fy = 2400.2;
  c.cx = 1999.5;
  c.cy = 1499.25;
  c.k1 = -0.02;
  c.k2 = 1e-3;
  c.p1 = -0.0;
  c.p2 = 1e-5;
  c.k3 = -1e-7;
  c.focal_sigma = 12;
  c.k1_sigma = 0.1;
  c.k2_sigma = 0.2;
  c.version = 4'000'000'000U;
  return c;
}

/// As many features as asked for, their descriptors distributed as RootSIFT's are.
inline GeoKeyframe someKeyframe(FrameId id, std::size_t features, std::mt19937& random) {
  std::uniform_real_distribution<float> anywhere(-0.5F, 3999.5F);
  std::gamma_distribution<float> bin(0.5F);
  FeatureSet f;
  auto k = std::make_shared<Keyframe>();
  for (std::size_t i = 0; i < features; ++i) {
    f.pixel.emplace_back(anywhere(random), anywhere(random));
    f.scale_px.push_back(1 + anywhere(random) / 100);
    float row[FeatureSet::kDescriptorSize], sum = 0;
    for (float& value : row) sum += value = bin(random);
    for (const float value : row)
      f.descriptor.push_back(
          static_cast<std::uint8_t>(std::min(255.0F, 512 * std::sqrt(value / sum))));
    for (int channel = 0; channel < 3; ++channel)
      f.colour.push_back(static_cast<std::uint8_t>(random()));
    k->inverse_depth.push_back(random() % 2 == 0 ? 0 : 1 / anywhere(random));
    k->chain.push_back(random() % 2 == 0 ? -1 : static_cast<int>(random() % 100'000));
  }
  f.pixel_size = 2.75;
  k->id = id;
  k->time = 1'466'699'519'123'456'789;
  k->name = "DJI \xC3\xA9\xFF 1.JPG";  // not UTF-8
  k->segment = 3;
  k->T_local_cam = someIsometry(random);
  k->camera = someCamera();
  k->features = std::make_shared<const FeatureSet>(std::move(f));
  k->attitude = {12.5, -89.9, -0.0};
  k->height_above_ground_m = 0;
  k->matches = 700;
  k->inliers = 650;
  return {std::move(k), GnssPosition{{1, 2, std::numeric_limits<double>::quiet_NaN()}, {3, 4, 5}}};
}

/// One pose more than `before`, its last three moved.
inline GeoSegment grownSegment(const GeoSegment& before, std::mt19937& random) {
  GeoSegment out = before;
  out.id = {2, 3};
  out.georeferenced = true;
  out.scale = 7.25 + static_cast<double>(before.poses.size());
  out.scale_sigma = 0.125;
  out.poses.emplace_back();
  const std::size_t count = out.poses.size();
  for (std::size_t i = count - std::min<std::size_t>(count, 3); i < count; ++i) {
    out.poses[i].frame = {2, static_cast<std::uint32_t>(i)};
    out.poses[i].T_world_cam = someIsometry(random);
    out.poses[i].covariance.setRandom();
    if (i % 2 == 0) {
      const Eigen::Matrix<double, 6, 6> half = out.poses[i].covariance;
      out.poses[i].covariance = half + half.transpose();
    }
  }
  return out;
}

inline GnssQuality someQuality() { return {{0.5, 0.25, 1.5}, {-0.0, 3, -17}, 44, 3, true}; }

inline SeamStep someStep(std::size_t features, std::mt19937& random) {
  SeamStep message;
  ChainStep& step = message.step;
  step.uav = 2;
  step.keyframes = {someKeyframe({2, 70'000}, features, random),
                    someKeyframe({2, 70'001}, 1, random)};
  GeoSegment lost;  // a photo by itself, not georeferenced
  lost.id = {2, 0};
  lost.poses.emplace_back();
  step.segments =
      std::make_shared<const std::vector<GeoSegment>>(2, grownSegment(GeoSegment{}, random));
  auto segments = *step.segments;
  segments[0] = lost;
  step.segments = std::make_shared<const std::vector<GeoSegment>>(segments);
  step.gnss = someQuality();
  step.provisional = {{{2, 70'002}, 3, someIsometry(random), {}},
                      {{2, 70'003}, 3, someIsometry(random), someIsometry(random)}};
  step.jpeg = std::string("\xFF\xD8\0jpeg", 7);
  message.next_from = -2;
  message.photo = {"b \xFF.jpg", -1, someCamera()};
  return message;
}

inline SeamHello someHello() {
  SeamHello hello;
  hello.uav = 2;
  hello.name = "north \xFF";
  hello.photos = 70'003;
  hello.next_from = 1'466'699'519'123'456'789;
  hello.first_fix = GnssFix{77, 51.5, -0.125, 102.5, {1, 2, 3}, HeightDatum::kMsl};
  hello.origin = {51.25, -0.0, 1e-310};
  hello.warnings = {"broken \xFF", ""};
  return hello;
}

inline SeamDone someDone() {
  std::mt19937 random(3);
  SeamDone done;
  done.uav = 2;
  done.photos = {{"a.jpg", 5, PhotoStatus::kUnposed, 1, 2000, 300, 250, ""},
                 {"b.jpg", 6, PhotoStatus::kDamaged, -1, 0, 0, 0, "no JPEG"}};
  done.local_trajectory = {{0, someIsometry(random)}, {7, someIsometry(random)}};
  done.scale_history = {{5, 1, 7.5, 0.25}, {6, 1, 7.25, 0.125}};
  done.gnss = someQuality();
  done.segments = 2;
  done.pose_graph = std::string("VERTEX\0 1\n", 10);
  done.warnings = {"it breaks off", ""};
  return done;
}

/// Every bit of a value, one after the other.
class Bits {
 public:
  template <class... Ts>
  Bits& operator()(const Ts&... values) {
    (add(values), ...);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  template <class T, std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>, int> = 0>
  void add(const T& value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(const std::string& value) {
    add(value.size());
    text_ += value;
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.size());
    for (const T& value : values) add(value);
  }
  template <class T>
  void add(const std::optional<T>& value) {
    add(value.has_value());
    if (value) add(*value);
  }
  template <class Scalar, int rows, int columns>
  void add(const Eigen::Matrix<Scalar, rows, columns>& m) {
    for (Eigen::Index k = 0; k < m.size(); ++k) add(m.data()[k]);
  }
  void add(const Eigen::Isometry3d& T) { add(T.matrix()); }

  void add(FrameId id) { (*this)(id.uav, id.index); }
  void add(const CameraModel& c) {
    (*this)(c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3, c.focal_sigma,
            c.k1_sigma, c.k2_sigma, c.version);
  }
  void add(const GnssQuality& q) { (*this)(q.sigma_m, q.bias_m, q.fixes, q.outliers, q.trusted); }
  void add(const GnssFix& f) {
    (*this)(f.time, f.latitude_deg, f.longitude_deg, f.height_m, f.sigma_enu_m, f.datum);
  }
  void add(const GnssPosition& p) { (*this)(p.position_m, p.sigma_m); }
  void add(const GimbalAttitude& a) { (*this)(a.yaw_deg, a.pitch_deg, a.roll_deg); }
  void add(const FeatureSet& f) {
    (*this)(f.pixel, f.scale_px, f.pixel_size, f.descriptor, f.colour);
  }
  void add(const GeoKeyframe& geo) {
    const Keyframe& k = *geo.keyframe;
    (*this)(k.id, k.time, k.name, k.segment, k.T_local_cam, k.camera, *k.features, k.inverse_depth,
            k.chain, k.attitude, k.height_above_ground_m, k.matches, k.inliers, geo.fix);
  }
  void add(const GeoSegment::Pose& p) { (*this)(p.frame, p.T_world_cam, p.covariance); }
  void add(const GeoSegment& s) {
    (*this)(s.id.uav, s.id.segment, s.georeferenced, s.scale, s.scale_sigma, s.poses);
  }
  void add(const ChainStep::Provisional& n) {
    (*this)(n.photo, n.segment, n.T_local_cam, n.T_world_cam);
  }
  void add(const ChainStep& s) {
    (*this)(s.uav, s.keyframes, s.segments != nullptr, s.gnss, s.provisional, s.jpeg);
    if (s.segments) add(*s.segments);
  }
  void add(const SeamStep::Photo& p) { (*this)(p.name, p.time, p.camera); }
  void add(const SeamStep& s) { (*this)(s.step, s.photo, s.next_from); }
  void add(const SeamHello& h) {
    (*this)(h.uav, h.name, h.photos, h.first_fix, h.origin, h.warnings, h.next_from);
  }
  void add(const PhotoRecord& p) {
    (*this)(p.name, p.time, p.status, p.segment, p.keypoints, p.matches, p.inliers, p.reason);
  }
  void add(const PhotoPose& p) { (*this)(p.photo, p.T_world_cam); }
  void add(const ScaleRow& r) { (*this)(r.t, r.segment, r.scale, r.sigma); }
  void add(const SeamDone& d) {
    (*this)(d.uav, d.photos, d.local_trajectory, d.scale_history, d.gnss, d.segments, d.pose_graph,
            d.warnings);
  }
  void add(const SeamMessage& m) {
    add(m.index());
    std::visit([this](const auto& value) { add(value); }, m);
  }

  std::string text_;
};

inline bool same(const SeamMessage& a, const SeamMessage& b) {
  return Bits()(a).text() == Bits()(b).text();
}

}  // namespace cf::support
