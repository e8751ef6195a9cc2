// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <limits>

#include "cf/formats/seam_message.h"
#include "seam.pb.h"
#include "seam_protocol.h"
#include "zstd_bytes.h"

namespace cf {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

/// Thrown inside decode() only.
struct Refusal {
  Failure failure;
};

void demand(bool right, const char* what) {
  if (!right) throw Refusal{{"damaged", what}};
}

std::uint16_t uavOf(std::uint32_t uav) {
  demand(uav <= std::numeric_limits<std::uint16_t>::max(), "a UAV's number is too large");
  return static_cast<std::uint16_t>(uav);
}

template <class Enum>
Enum enumOf(std::uint32_t value, Enum last) {
  demand(value <= static_cast<std::uint32_t>(last), "a choice is unknown");
  return static_cast<Enum>(value);
}

Eigen::Vector3d vectorOf(const Numbers& in) {
  demand(in.size() == 3, "a vector has not 3 numbers");
  return {in[0], in[1], in[2]};
}

Eigen::Isometry3d poseOf(const Numbers& in) {
  demand(in.size() == 12, "a pose has not 12 numbers");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) T(row, column) = in[4 * row + column];
  return T;
}

Eigen::Matrix<double, 6, 6> covarianceOf(const Numbers& in) {
  Eigen::Matrix<double, 6, 6> out = Eigen::Matrix<double, 6, 6>::Zero();
  if (in.empty()) return out;
  const bool symmetric = in.size() == 21;
  demand(symmetric || in.size() == 36, "a covariance has neither 21 nor 36 numbers");
  const double* next = in.data();
  for (int row = 0; row < 6; ++row)
    for (int column = symmetric ? row : 0; column < 6; ++column) {
      out(row, column) = *next++;
      if (symmetric) out(column, row) = out(row, column);
    }
  return out;
}

FrameId idOf(const seam::FrameId& in) { return {uavOf(in.uav()), in.index()}; }

CameraModel cameraOf(const seam::Camera& in) {
  CameraModel c;
  c.width = in.width();
  c.height = in.height();
  c.fx = in.fx();
  c.fy = in.fy();
  c.cx = in.cx();
  c.cy = in.cy();
  c.k1 = in.k1();
  c.k2 = in.k2();
  c.p1 = in.p1();
  c.p2 = in.p2();
  c.k3 = in.k3();
  c.focal_sigma = in.focal_sigma();
  c.k1_sigma = in.k1_sigma();
  c.k2_sigma = in.k2_sigma();
  c.version = in.version();
  return c;
}

GnssQuality qualityOf(const seam::Gnss& in) {
  GnssQuality q;
  q.sigma_m = vectorOf(in.sigma_m());
  q.bias_m = vectorOf(in.bias_m());
  q.fixes = in.fixes();
  q.outliers = in.outliers();
  q.trusted = in.trusted();
  return q;
}

void takeFeatures(const seam::Features& in, Keyframe& out) {
  const auto count = static_cast<std::size_t>(in.scale_px_size());
  const auto as_many = [&](int size) { return static_cast<std::size_t>(size) == count; };
  demand(static_cast<std::size_t>(in.pixel_size()) == 2 * count &&
             in.colour().size() == 3 * count && as_many(in.inverse_depth_size()) &&
             as_many(in.chain_size()),
         "the parts of its features are not equally many");
  FeatureSet f;
  for (int i = 0; i < in.scale_px_size(); ++i)
    f.pixel.emplace_back(in.pixel(2 * i), in.pixel(2 * i + 1));
  f.scale_px.assign(in.scale_px().begin(), in.scale_px().end());
  f.pixel_size = in.reduction();
  demand(zstdUnpress(in.descriptors(), count * FeatureSet::kDescriptorSize, f.descriptor),
         "its descriptors do not fit");
  f.colour.assign(in.colour().begin(), in.colour().end());
  out.features = std::make_shared<const FeatureSet>(std::move(f));
  out.inverse_depth.assign(in.inverse_depth().begin(), in.inverse_depth().end());
  out.chain.assign(in.chain().begin(), in.chain().end());
}

GeoKeyframe keyframeOf(const seam::Keyframe& in) {
  auto k = std::make_shared<Keyframe>();
  k->id = idOf(in.id());
  k->time = in.time_ns();
  k->name = in.name();
  k->segment = in.segment();
  k->T_local_cam = poseOf(in.t_local_cam());
  k->camera = cameraOf(in.camera());
  takeFeatures(in.features(), *k);
  if (in.has_attitude())
    k->attitude = {in.attitude().yaw_deg(), in.attitude().pitch_deg(), in.attitude().roll_deg()};
  if (in.has_height_above_ground_m()) k->height_above_ground_m = in.height_above_ground_m();
  k->matches = in.matches();
  k->inliers = in.inliers();
  GeoKeyframe out{std::move(k), {}};
  if (in.has_fix()) out.fix = {vectorOf(in.fix().position_m()), vectorOf(in.fix().sigma_m())};
  return out;
}

/// Takes the segment out of `known`: no message tells of one twice.
GeoSegment segmentOf(const seam::Segment& in, SegmentsById& known) {
  GeoSegment out;
  out.id = {uavOf(in.uav()), in.segment()};
  if (const GeoSegment* before = segmentIn(known, out.id)) out.poses = before->poses;
  known.erase(out.id);
  out.georeferenced = in.georeferenced();
  out.scale = in.scale();
  out.scale_sigma = in.scale_sigma();
  if (in.poses() < out.poses.size()) out.poses.resize(in.poses());
  for (const seam::Segment::Pose& changed : in.changed()) {
    demand(changed.at() <= out.poses.size(), "a segment lacks a pose");
    if (changed.at() == out.poses.size()) out.poses.emplace_back();
    GeoSegment::Pose& pose = out.poses[changed.at()];
    pose.frame = idOf(changed.frame());
    pose.T_world_cam = poseOf(changed.t_world_cam());
    pose.covariance = covarianceOf(changed.covariance());
  }
  demand(out.poses.size() == in.poses(), "a segment has not as many poses as it says");
  return out;
}

SeamStep stepOf(const seam::Step& in, SegmentsById known) {
  SeamStep message;
  if (in.has_photo())
    message.photo = {in.photo().name(), in.photo().time_ns(), cameraOf(in.photo().camera())};
  message.next_from = in.next_from_ns();
  ChainStep& out = message.step;
  out.uav = uavOf(in.uav());
  for (const seam::Keyframe& keyframe : in.keyframes())
    out.keyframes.push_back(keyframeOf(keyframe));
  if (in.has_segments()) {
    auto segments = std::make_shared<std::vector<GeoSegment>>();
    for (const seam::Segment& segment : in.segments().all())
      segments->push_back(segmentOf(segment, known));
    out.segments = std::move(segments);
  }
  out.gnss = qualityOf(in.gnss());
  out.jpeg = in.jpeg();
  for (const seam::Step::Provisional& photo : in.provisional()) {
    out.provisional.push_back(
        {idOf(photo.photo()), photo.segment(), poseOf(photo.t_local_cam()), {}});
    if (!photo.t_world_cam().empty())
      out.provisional.back().T_world_cam = poseOf(photo.t_world_cam());
  }
  return message;
}

SeamHello helloOf(const seam::Hello& in) {
  if (in.protocol() != kSeamProtocol)
    throw Refusal{{"version", fmt::format("it is of protocol {}, this program's is {}",
                                          in.protocol(), kSeamProtocol)}};
  SeamHello out;
  out.uav = uavOf(in.uav());
  out.name = in.name();
  demand(in.photos() >= -1, "it has fewer than no photos");
  out.next_from = in.next_from_ns();
  if (in.photos() >= 0) out.photos = static_cast<std::size_t>(in.photos());
  if (!in.origin().empty()) out.origin = vectorOf(in.origin());
  out.warnings.assign(in.warnings().begin(), in.warnings().end());
  if (!in.has_first_fix()) return out;
  const seam::Fix& fix = in.first_fix();
  out.first_fix = {
      fix.time_ns(),  fix.latitude_deg(),          fix.longitude_deg(),
      fix.height_m(), vectorOf(fix.sigma_enu_m()), enumOf(fix.datum(), HeightDatum::kMsl)};
  return out;
}

SeamDone doneOf(const seam::Done& in) {
  SeamDone out;
  out.uav = uavOf(in.uav());
  for (const seam::Done::Photo& photo : in.photos())
    out.photos.push_back({photo.name(), photo.time_ns(),
                          enumOf(photo.status(), PhotoStatus::kDamaged), photo.segment(),
                          photo.keypoints(), photo.matches(), photo.inliers(), photo.reason()});
  for (const seam::Done::Pose& pose : in.local_trajectory())
    out.local_trajectory.push_back({pose.photo(), poseOf(pose.t_local_cam())});
  for (const seam::Done::Scale& row : in.scale_history())
    out.scale_history.push_back({row.time_ns(), row.segment(), row.scale(), row.sigma()});
  out.gnss = qualityOf(in.gnss());
  out.segments = in.segments();
  out.pose_graph = in.pose_graph();
  out.warnings.assign(in.warnings().begin(), in.warnings().end());
  return out;
}

SeamMessage messageOf(const seam::Message& in, const std::vector<GeoSegment>* segments) {
  switch (in.kind_case()) {
    case seam::Message::kHello:
      return helloOf(in.hello());
    case seam::Message::kStep:
      return stepOf(in.step(), byId(segments));
    case seam::Message::kDone:
      return doneOf(in.done());
    case seam::Message::KIND_NOT_SET:
      break;
  }
  throw Refusal{{"damaged", "it is of no known kind"}};
}

}  // namespace

Result<SeamMessage> SeamDecoder::decode(std::string_view bytes) {
  seam::Message in;
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()) ||
      !in.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return Failure{"damaged", "it is not a message of the seam"};
  try {
    SeamMessage out = messageOf(in, segments_.get());
    if (std::holds_alternative<SeamHello>(out)) segments_ = nullptr;
    if (const auto* step = std::get_if<SeamStep>(&out); step != nullptr && step->step.segments)
      segments_ = step->step.segments;
    return out;
  } catch (const Refusal& refusal) {
    return refusal.failure;
  }
}

Result<SeamMessage> decodeSeamMessage(std::string_view bytes) {
  return SeamDecoder().decode(bytes);
}

}  // namespace cf
