// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/georeference/georeferencer.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "fix_track.h"
#include "method.h"

namespace cf {
namespace {

constexpr int kFewestJudged = 4;       ///< fixes below which noise is not judged
constexpr double kMostOutliers = 0.3;  ///< share above which the receiver is not trusted

/// 1 % quantile of chi-square with n degrees of freedom, over n (Wilson and Hilferty 1931).
double lowChiSquareRatio(double n) {
  const double c = 2 / (9 * n);
  return std::pow(std::max(0.0, 1 - c - 2.326 * std::sqrt(c)), 3);
}

}  // namespace

void GeoreferenceOptions::visit(OptionVisitor& v) {
  v.choice("method", method, georeferenceMethods(),
           "two_stage: the paper's, the scale is a state; global_fusion: the baseline without one, "
           "after VINS-Fusion");
  v.number("vo_rotation_sigma", vo_rotation_sigma_deg, {1e-4, 10},
           "rotation error of one odometry step [deg]");
  v.number("vo_step_sigma", vo_step_sigma, {1e-5, 1},
           "translation error of one odometry step, fraction of its length");
  v.number("vo_depth_sigma", vo_depth_sigma, {0, 1},
           "translation error of one odometry step, fraction of the median depth, added");
  v.number("max_gap", max_gap_s, {0, 3600}, "longest gap between fixes to interpolate over [s]");
  v.number("acceleration_sigma", acceleration_sigma_mps2, {0, 100},
           "acceleration of the UAV, for the error of interpolated fixes [m/s^2]");
  v.integer("max_wait", max_wait_keyframes, {0, 1000}, "photos that one waits for its fix");
  v.number("prior_dof", prior_dof, {0.1, 1000},
           "weight of the tagged sigma when the noise is estimated, in fixes");
  v.number("common_error", common_error, {0, 100},
           "error common to all fixes of a flight, in tagged sigmas; widens the covariances");
  v.number("junk_factor", junk_factor, {1, 1000},
           "horizontal noise beyond this many tagged sigmas, and beyond junk_sigma, is junk");
  v.number("junk_sigma", junk_sigma_m, {0, 1e4}, "see junk_factor [m]");
  v.number("gimbal_tilt_sigma", gimbal_tilt_sigma_deg, {0.01, 180}, "tagged pitch and roll [deg]");
  v.number("gimbal_yaw_sigma", gimbal_yaw_sigma_deg, {0.01, 180}, "tagged yaw [deg]");
  v.number("nadir_sigma", nadir_sigma_deg, {0.1, 180},
           "camera axis against straight down, where no attitude is tagged [deg]");
  v.number("ground_sigma", ground_sigma_deg, {0.1, 180}, "slope of the ground [deg]");
  v.number("height_tag_sigma", height_tag_sigma, {0.01, 10},
           "tagged height against median depth, fraction");
  v.number("max_scale_sigma", max_scale_sigma, {0.001, 10},
           "relative scale sigma above which a segment stays in its local frame");
  v.number("max_yaw_sigma", max_yaw_sigma_deg, {0.1, 180},
           "heading sigma above which a segment stays in its local frame [deg]");
  v.integer("full_solve", full_solve_keyframes, {1, 100000},
            "up to this many photos each one re-solves its whole segment");
  v.integer("window", window_keyframes, {2, 100000},
            "in longer segments, photos solved at each new one; all of them when grown by a tenth");
  v.number("fusion_rotation_sigma", fusion_rotation_sigma_deg, {1e-4, 90},
           "global_fusion: rotation error of one odometry step [deg]");
  v.number("fusion_step_sigma", fusion_step_sigma_m, {1e-5, 1000},
           "global_fusion: translation error of one odometry step [m]");
  v.integer("fusion_start_fixes", fusion_start_fixes, {2, 100000},
            "global_fusion: with so many fixes the scale is set for good");
}

class Georeferencer::Impl {
 public:
  Impl(std::uint16_t uav, const GeoreferenceOptions& options, FixToWorld fix_to_world)
      : uav_(uav),
        options_(options),
        fix_to_world_(std::move(fix_to_world)),
        track_(options.max_gap_s, options.acceleration_sigma_mps2),
        method_(makeMethod(options)) {}

  void addFix(const GnssFix& fix) {
    const GnssPosition position{fix_to_world_(fix), fix.sigma_enu_m};
    const bool usable = position.position_m.allFinite() && position.sigma_m.allFinite() &&
                        (position.sigma_m.array() > 0).all();
    if (usable) track_.add(fix.time, position);
  }

  std::vector<GeoKeyframe> push(std::shared_ptr<const Keyframe> keyframe) {
    waiting_.push_back(std::move(keyframe));
    return release(false);
  }

  std::vector<GeoKeyframe> flush() {
    std::vector<GeoKeyframe> out = release(true);
    method_->finish(segments_);
    for (const Segment& segment : segments_) publish(segment);
    return out;
  }

  GnssQuality quality() const {
    GnssQuality q;
    Eigen::Vector3d tagged = Eigen::Vector3d::Zero();
    for (const Segment& segment : segments_)
      for (const Node& node : segment.nodes)
        if (node.fix) {
          ++q.fixes;
          q.outliers += node.horizontal_outlier || node.vertical_outlier ? 1 : 0;
          tagged += node.fix->sigma_m.cwiseAbs2();
        }
    if (q.fixes == 0) return q;
    tagged = (tagged / q.fixes).cwiseSqrt();
    q.sigma_m = tagged.cwiseProduct(measuredNoise(segments_, options_).factor);
    q.trusted = trusted(q, tagged);
    return q;
  }

  std::string graphText() const { return poseGraphText(segments_, published_, *method_); }

  const std::vector<GeoSegment>& published() const { return published_; }
  const std::vector<ScaleSample>& history() const { return history_; }

 private:
  std::vector<GeoKeyframe> release(bool all) {
    std::vector<GeoKeyframe> out;
    while (!waiting_.empty() &&
           (all || track_.reaches(waiting_.front()->time) ||
            waiting_.size() > static_cast<std::size_t>(options_.max_wait_keyframes))) {
      out.push_back({waiting_.front(), track_.at(waiting_.front()->time)});
      waiting_.pop_front();
      track_.forgetBefore(out.back().keyframe->time);
      take(out.back());
    }
    return out;
  }

  void take(const GeoKeyframe& geo) {
    Segment& segment = segmentOf(geo.keyframe->segment);
    Node node;
    node.keyframe = geo.keyframe;
    node.fix = geo.fix;
    measureGround(node, options_);
    if (!segment.nodes.empty())
      segment.longest_step =
          std::max(segment.longest_step, (geo.keyframe->T_local_cam.translation() -
                                          segment.nodes.back().keyframe->T_local_cam.translation())
                                             .norm());
    segment.nodes.push_back(std::move(node));
    method_->update(segments_, static_cast<std::size_t>(&segment - segments_.data()));
    publish(segment);
    const GeoSegment& p = published_[static_cast<std::size_t>(&segment - segments_.data())];
    history_.push_back(
        {geo.keyframe->time, segment.number, p.scale, p.scale_sigma, p.georeferenced});
  }

  Segment& segmentOf(int number) {
    const auto it = std::lower_bound(segments_.begin(), segments_.end(), number,
                                     [](const Segment& s, int n) { return s.number < n; });
    if (it != segments_.end() && it->number == number) return *it;
    const auto at = it - segments_.begin();
    segments_.insert(it, Segment{})->number = number;
    published_.insert(published_.begin() + at, GeoSegment{})->id = {uav_, number};
    return segments_[static_cast<std::size_t>(at)];
  }

  bool trusted(const GnssQuality& q, const Eigen::Vector3d& tagged) const {
    const double good = q.fixes - q.outliers;
    if (q.fixes < kFewestJudged) return true;
    if (q.outliers > kMostOutliers * q.fixes) return false;
    // 99 % sure that the true sigma of one horizontal axis is above the limit.
    for (int k = 0; k < 2; ++k) {
      const double limit = std::max(options_.junk_factor * tagged[k], options_.junk_sigma_m);
      if (q.sigma_m[k] * q.sigma_m[k] * lowChiSquareRatio(good) > limit * limit) return false;
    }
    return true;
  }

  bool accepted(const Segment& segment) const {
    if (!segment.solved) return false;
    if (segment.nodes.size() > 1 && segment.log_scale_sigma > options_.max_scale_sigma)
      return false;
    const double worst = options_.max_yaw_sigma_deg * kRadPerDeg;
    return std::all_of(segment.nodes.begin(), segment.nodes.end(),
                       [&](const Node& node) { return node.covariance(5, 5) < worst * worst; });
  }

  void publish(const Segment& segment) {
    GeoSegment& out = published_[static_cast<std::size_t>(&segment - segments_.data())];
    out.georeferenced = accepted(segment);
    out.scale = out.georeferenced ? method_->scaleOf(segment) : 1;
    out.scale_sigma = out.georeferenced ? out.scale * segment.log_scale_sigma : 0;
    out.poses.clear();
    const Eigen::Matrix3d common_error = commonError(segment);
    for (const Node& node : segment.nodes) {
      GeoSegment::Pose pose;
      pose.frame = node.keyframe->id;
      pose.T_world_cam = out.georeferenced ? node.T_world_cam : node.keyframe->T_local_cam;
      if (out.georeferenced) {
        pose.covariance = node.covariance;
        pose.covariance.topLeftCorner<3, 3>() += common_error;
      }
      out.poses.push_back(pose);
    }
  }

  /// What residuals cannot show: all fixes of a flight off together. Zero without fixes.
  Eigen::Matrix3d commonError(const Segment& segment) const {
    Eigen::Vector3d square = Eigen::Vector3d::Zero();
    for (const Node& node : segment.nodes)
      if (node.fix) square += node.fix->sigma_m.cwiseAbs2();
    square *= options_.common_error * options_.common_error / std::max(1, segment.fixes());
    return square.asDiagonal();
  }

  std::uint16_t uav_;
  const GeoreferenceOptions options_;
  FixToWorld fix_to_world_;
  FixTrack track_;
  std::unique_ptr<GeoreferenceMethod> method_;
  std::deque<std::shared_ptr<const Keyframe>> waiting_;
  std::vector<Segment> segments_;  ///< by number
  std::vector<GeoSegment> published_;
  std::vector<ScaleSample> history_;
};

Georeferencer::Georeferencer(std::uint16_t uav, const GeoreferenceOptions& options,
                             FixToWorld fix_to_world)
    : impl_(std::make_unique<Impl>(uav, options, std::move(fix_to_world))) {}
Georeferencer::~Georeferencer() = default;
Georeferencer::Georeferencer(Georeferencer&&) noexcept = default;
Georeferencer& Georeferencer::operator=(Georeferencer&&) noexcept = default;

void Georeferencer::addFix(const GnssFix& fix) { impl_->addFix(fix); }
std::vector<GeoKeyframe> Georeferencer::push(std::shared_ptr<const Keyframe> keyframe) {
  return impl_->push(std::move(keyframe));
}
std::vector<GeoKeyframe> Georeferencer::flush() { return impl_->flush(); }
const std::vector<GeoSegment>& Georeferencer::segments() const { return impl_->published(); }
GnssQuality Georeferencer::quality() const { return impl_->quality(); }
const std::vector<ScaleSample>& Georeferencer::scaleHistory() const { return impl_->history(); }
std::string Georeferencer::graphText() const { return impl_->graphText(); }

}  // namespace cf
