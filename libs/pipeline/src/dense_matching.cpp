// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dense_matching.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "cf/base/error.h"
#include "cf/formats/depth_frame_file.h"

namespace cf {
namespace {

/// To the last bit: a run that is resumed computes the same poses again.
bool fits(const DepthFrame& kept, const StereoPair& pair) {
  const Eigen::Isometry3d T_reference_partner =
      pair.reference.T_world_cam.inverse() * pair.partner.T_world_cam;
  return kept.T_reference_partner.matrix() == T_reference_partner.matrix() &&
         kept.reference_camera == pair.reference.camera &&
         kept.partner_camera == pair.partner.camera;
}

}  // namespace

DenseMatching::DenseMatching(std::filesystem::path folder, const DensifyOptions& options,
                             PhotoStore& photos, StageTimes& times)
    : folder_(std::move(folder)), options_(options), photos_(photos), times_(times) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw RunError(folder_.string() + " cannot be made: " + error.message());
}

Result<DepthFrame> DenseMatching::frame(const StereoPair& pair) {
  const auto photo = [&](FrameId id) {
    const StageTimes::Scope scope(times_, "decode");
    return photos_.get(id);
  };
  const cv::Mat reference = photo(pair.reference.id);
  if (reference.empty()) return Failure{"no_photo", "one of its photos has not come"};
  if (auto kept = tryReadDepthFrame(file(pair)); kept && fits(*kept, pair)) {
    ++found_;
    kept->colour = referenceColour(*kept, reference);
    return std::move(*kept);
  }
  const cv::Mat partner = photo(pair.partner.id);
  if (partner.empty()) return Failure{"no_photo", "one of its photos has not come"};
  const StageTimes::Scope scope(times_, "densify");
  const auto frame = matchPair(pair.reference, reference, pair.partner, partner, options_);
  if (!frame) return frame;
  DepthFrame kept = *frame;
  kept.colour.release();  // the photo tells it again
  writeDepthFrame(file(pair), kept);
  return frame;
}

std::filesystem::path DenseMatching::file(const StereoPair& pair) const {
  const FrameId r = pair.reference.id, p = pair.partner.id;
  return folder_ / fmt::format("{}_{}-{}_{}.depth", r.uav, r.index, p.uav, p.index);
}

}  // namespace cf
