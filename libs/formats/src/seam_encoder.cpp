// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "cf/base/error.h"
#include "cf/formats/seam_message.h"
#include "seam.pb.h"
#include "seam_protocol.h"
#include "zstd_bytes.h"

namespace cf {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

void put(const Eigen::Vector3d& v, Numbers& out) { out.Add(v.data(), v.data() + 3); }

void put(const Eigen::Isometry3d& T, Numbers& out) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) out.Add(T(row, column));
}

bool sameBits(const double* a, const double* b, std::size_t count) {
  return std::memcmp(a, b, count * sizeof *a) == 0;
}

void putCovariance(const Eigen::Matrix<double, 6, 6>& matrix, Numbers& out) {
  const Eigen::Matrix<double, 6, 6> transposed = matrix.transpose();
  const Eigen::Matrix<double, 6, 6> zero = Eigen::Matrix<double, 6, 6>::Zero();
  if (sameBits(matrix.data(), zero.data(), 36)) return;
  const bool symmetric = sameBits(matrix.data(), transposed.data(), 36);
  for (int row = 0; row < 6; ++row)
    for (int column = symmetric ? row : 0; column < 6; ++column) out.Add(matrix(row, column));
}

void put(FrameId id, seam::FrameId& out) {
  out.set_uav(id.uav);
  out.set_index(id.index);
}

void put(const CameraModel& c, seam::Camera& out) {
  out.set_width(c.width);
  out.set_height(c.height);
  out.set_fx(c.fx);
  out.set_fy(c.fy);
  out.set_cx(c.cx);
  out.set_cy(c.cy);
  out.set_k1(c.k1);
  out.set_k2(c.k2);
  out.set_p1(c.p1);
  out.set_p2(c.p2);
  out.set_k3(c.k3);
  out.set_focal_sigma(c.focal_sigma);
  out.set_k1_sigma(c.k1_sigma);
  out.set_k2_sigma(c.k2_sigma);
  out.set_version(c.version);
}

void put(const GnssQuality& q, seam::Gnss& out) {
  put(q.sigma_m, *out.mutable_sigma_m());
  put(q.bias_m, *out.mutable_bias_m());
  out.set_fixes(q.fixes);
  out.set_outliers(q.outliers);
  out.set_trusted(q.trusted);
}

void putFeatures(const Keyframe& keyframe, seam::Features& out) {
  const FeatureSet& f = *keyframe.features;
  const std::size_t n = f.size();
  if (f.scale_px.size() != n || f.descriptor.size() != n * FeatureSet::kDescriptorSize ||
      f.colour.size() != 3 * n || keyframe.inverse_depth.size() != n || keyframe.chain.size() != n)
    throw RunError("photo " + keyframe.name + ": the parts of its features are not equally many");
  for (const Eigen::Vector2f& pixel : f.pixel)
    out.mutable_pixel()->Add(pixel.data(), pixel.data() + 2);
  out.mutable_scale_px()->Add(f.scale_px.begin(), f.scale_px.end());
  out.set_reduction(f.pixel_size);
  out.set_descriptors(zstdPressed(f.descriptor));
  out.set_colour(f.colour.data(), f.colour.size());
  out.mutable_inverse_depth()->Add(keyframe.inverse_depth.begin(), keyframe.inverse_depth.end());
  out.mutable_chain()->Add(keyframe.chain.begin(), keyframe.chain.end());
}

void put(const GeoKeyframe& geo, seam::Keyframe& out) {
  const Keyframe& k = *geo.keyframe;
  put(k.id, *out.mutable_id());
  out.set_time_ns(k.time);
  out.set_name(k.name);
  out.set_segment(k.segment);
  put(k.T_local_cam, *out.mutable_t_local_cam());
  put(k.camera, *out.mutable_camera());
  putFeatures(k, *out.mutable_features());
  if (k.attitude) {
    out.mutable_attitude()->set_yaw_deg(k.attitude->yaw_deg);
    out.mutable_attitude()->set_pitch_deg(k.attitude->pitch_deg);
    out.mutable_attitude()->set_roll_deg(k.attitude->roll_deg);
  }
  if (k.height_above_ground_m) out.set_height_above_ground_m(*k.height_above_ground_m);
  out.set_matches(k.matches);
  out.set_inliers(k.inliers);
  if (!geo.fix) return;
  put(geo.fix->position_m, *out.mutable_fix()->mutable_position_m());
  put(geo.fix->sigma_m, *out.mutable_fix()->mutable_sigma_m());
}

bool same(const GeoSegment::Pose& a, const GeoSegment::Pose& b) {
  return a.frame == b.frame && sameBits(a.T_world_cam.data(), b.T_world_cam.data(), 16) &&
         sameBits(a.covariance.data(), b.covariance.data(), 36);
}

void put(const GeoSegment& segment, const GeoSegment* before, seam::Segment& out) {
  out.set_uav(segment.id.uav);
  out.set_segment(segment.id.segment);
  out.set_georeferenced(segment.georeferenced);
  out.set_scale(segment.scale);
  out.set_scale_sigma(segment.scale_sigma);
  out.set_poses(static_cast<std::uint32_t>(segment.poses.size()));
  for (std::size_t at = 0; at < segment.poses.size(); ++at) {
    const GeoSegment::Pose& pose = segment.poses[at];
    if (before != nullptr && at < before->poses.size() && same(pose, before->poses[at])) continue;
    seam::Segment::Pose& changed = *out.add_changed();
    changed.set_at(static_cast<std::uint32_t>(at));
    put(pose.frame, *changed.mutable_frame());
    put(pose.T_world_cam, *changed.mutable_t_world_cam());
    putCovariance(pose.covariance, *changed.mutable_covariance());
  }
}

void put(const SeamStep& message, const SegmentsById& before, seam::Step& out) {
  const ChainStep& step = message.step;
  out.set_uav(step.uav);
  for (const GeoKeyframe& keyframe : step.keyframes) put(keyframe, *out.add_keyframes());
  if (step.segments) {
    seam::Step::Segments& segments = *out.mutable_segments();
    for (const GeoSegment& segment : *step.segments)
      put(segment, segmentIn(before, segment.id), *segments.add_all());
  }
  put(step.gnss, *out.mutable_gnss());
  out.set_jpeg(step.jpeg);
  out.set_next_from_ns(message.next_from);
  if (message.photo) {
    seam::Step::Photo& photo = *out.mutable_photo();
    photo.set_name(message.photo->name);
    photo.set_time_ns(message.photo->time);
    put(message.photo->camera, *photo.mutable_camera());
  }
  for (const ChainStep::Provisional& photo : step.provisional) {
    seam::Step::Provisional& to = *out.add_provisional();
    put(photo.photo, *to.mutable_photo());
    to.set_segment(photo.segment);
    put(photo.T_local_cam, *to.mutable_t_local_cam());
    if (photo.T_world_cam) put(*photo.T_world_cam, *to.mutable_t_world_cam());
  }
}

void put(const SeamHello& hello, seam::Hello& out) {
  out.set_protocol(kSeamProtocol);
  out.set_uav(hello.uav);
  out.set_name(hello.name);
  out.set_next_from_ns(hello.next_from);
  out.set_photos(hello.photos ? static_cast<std::int32_t>(*hello.photos) : -1);
  if (hello.origin) put(*hello.origin, *out.mutable_origin());
  for (const std::string& warning : hello.warnings) out.add_warnings(warning);
  if (!hello.first_fix) return;
  seam::Fix& fix = *out.mutable_first_fix();
  fix.set_time_ns(hello.first_fix->time);
  fix.set_latitude_deg(hello.first_fix->latitude_deg);
  fix.set_longitude_deg(hello.first_fix->longitude_deg);
  fix.set_height_m(hello.first_fix->height_m);
  put(hello.first_fix->sigma_enu_m, *fix.mutable_sigma_enu_m());
  fix.set_datum(static_cast<std::uint32_t>(hello.first_fix->datum));
}

void put(const SeamDone& done, seam::Done& out) {
  out.set_uav(done.uav);
  for (const PhotoRecord& photo : done.photos) {
    seam::Done::Photo& to = *out.add_photos();
    to.set_name(photo.name);
    to.set_time_ns(photo.time);
    to.set_status(static_cast<std::uint32_t>(photo.status));
    to.set_segment(photo.segment);
    to.set_keypoints(photo.keypoints);
    to.set_matches(photo.matches);
    to.set_inliers(photo.inliers);
    to.set_reason(photo.reason);
  }
  for (const PhotoPose& pose : done.local_trajectory) {
    seam::Done::Pose& to = *out.add_local_trajectory();
    to.set_photo(pose.photo);
    put(pose.T_world_cam, *to.mutable_t_local_cam());
  }
  for (const ScaleRow& row : done.scale_history) {
    seam::Done::Scale& to = *out.add_scale_history();
    to.set_time_ns(row.t);
    to.set_segment(row.segment);
    to.set_scale(row.scale);
    to.set_sigma(row.sigma);
  }
  put(done.gnss, *out.mutable_gnss());
  out.set_segments(done.segments);
  out.set_pose_graph(done.pose_graph);
  for (const std::string& warning : done.warnings) out.add_warnings(warning);
}

}  // namespace

std::string SeamEncoder::encode(const SeamMessage& message) {
  seam::Message out;
  if (const auto* hello = std::get_if<SeamHello>(&message)) {
    put(*hello, *out.mutable_hello());
    segments_ = nullptr;
  } else if (const auto* step = std::get_if<SeamStep>(&message)) {
    put(*step, byId(segments_.get()), *out.mutable_step());
    if (step->step.segments) segments_ = step->step.segments;
  } else {
    put(std::get<SeamDone>(message), *out.mutable_done());
  }
  if (out.ByteSizeLong() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw RunError(
        fmt::format("a message of {} bytes is too long for the seam", out.ByteSizeLong()));
  return out.SerializeAsString();
}

}  // namespace cf
