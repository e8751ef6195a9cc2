// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/odometry/odometry.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "cf/features/match.h"
#include "cf/features/patch_alignment.h"
#include "cf/geometry/triangulation.h"
#include "chain_alignment.h"
#include "connect.h"
#include "guided_search.h"
#include "keyframe_of.h"
#include "local_adjustment.h"
#include "local_map.h"
#include "segment_pose.h"
#include "self_calibration.h"

namespace cf {
namespace {

constexpr double kAlignmentMegapixels = 3;  ///< of the photos that patches are aligned in
/// A guided match may lie so many inlier thresholds from where it is expected: what the pose and
/// the depth are wrong by, and room for others to be compared with.
constexpr double kGuidedMargin = 6;
constexpr double kGuidedRatio = 0.75;  ///< the best of a few must be better than the best of all
/// More parallax than this makes a first baseline no better [rad]: photos begin to differ.
constexpr double kParallaxEnough = 0.3;

std::vector<FeatureMatch> swapped(std::vector<FeatureMatch> matches) {
  for (FeatureMatch& m : matches) std::swap(m.a, m.b);
  return matches;
}

}  // namespace

void OdometryOptions::visit(OptionVisitor& v) {
  features.visit(v);
  v.integer("match_window", match_window, {1, 20}, "earlier photos that each photo is matched to");
  v.number("match_ratio", match_ratio, {0.5, 0.99}, "best over second best descriptor distance");
  v.number("inlier_px", inlier_px, {0.5, 20}, "reprojection threshold at the feature size [px]");
  v.integer("min_inliers", min_inliers, {8, 1000}, "below, a photo is not tracked");
  v.integer("adjustment_window", adjustment_window, {2, 50}, "photos in the local adjustment");
  v.integer("keyframe_features", keyframe_features, {100, 20000},
            "features that a keyframe carries to the central node");
  v.integer("delay", delay, {0, 20}, "photos that must follow before a keyframe is final");
  v.integer("calibration_photos", calibration_photos, {0, 50},
            "first photos that radial distortion is estimated from; 0: the lens stays as given");
}

PreparedPhoto preparePhoto(const ImageFrame& frame, const OdometryOptions& options) {
  return {extractFeatures(frame, options.features),
          greyForAlignment(frame.image, kAlignmentMegapixels)};
}

class Odometry::Tracker {
 public:
  explicit Tracker(const OdometryOptions& options)
      : options_(options), lens_(options.calibration_photos) {}

  std::vector<std::shared_ptr<const Keyframe>> push(const ImageFrame& frame,
                                                    PreparedPhoto prepared) {
    const PhotoIndex now = add(frame, std::move(prepared));
    if (continueSegment(now) || continueOverGround(now))
      matchGuided(now);
    else
      openSegment(now);
    if (map_.photo(now).segment >= 0) {
      adoptUnposed(now);
      alignToLandmarks(map_, now);
      adjustLocally(map_, windowOf(now), threshold_);
    }
    for (const auto& [i, matches] : matches_)
      map_.photo(now).matches += static_cast<int>(matches.size());
    lens_.look(map_, false, threshold_);
    auto keyframes = finalise(lens_.settled() ? now - options_.delay : -1);
    forgetOld(now);
    return keyframes;
  }

  std::vector<std::shared_ptr<const Keyframe>> flush() {
    lens_.look(map_, true, threshold_);
    return finalise(static_cast<PhotoIndex>(map_.photos.size()) - 1);
  }

  std::vector<Keyframe> provisional() const {
    std::vector<Keyframe> out;
    for (PhotoIndex i = finalised_; i < static_cast<PhotoIndex>(map_.photos.size()); ++i)
      out.push_back(keyframeOf(map_, i));
    return out;
  }
  const OdometryOptions& options() const { return options_; }

 private:
  using Matches = std::vector<FeatureMatch>;

  PhotoIndex add(const ImageFrame& frame, PreparedPhoto prepared) {
    TrackedPhoto photo;
    photo.frame = frame;
    photo.frame.image.release();
    photo.frame.camera = lens_.use(frame.camera);
    const CameraModel& camera = photo.frame.camera;
    photo.features = std::make_shared<FeatureSet>(std::move(prepared.features));
    photo.grey = prepared.grey;
    photo.normalized = normalizedPoints(*photo.features, camera);
    photo.landmark.assign(photo.features->size(), -1);
    photo.chain = photo.landmark;
    threshold_ = options_.inlier_px * photo.features->pixel_size / camera.fx;
    if (map_.photos.empty()) lens_.begin(camera, threshold_);
    matches_.clear();
    map_.photos.push_back(std::move(photo));
    return static_cast<PhotoIndex>(map_.photos.size()) - 1;
  }

  PhotoIndex firstOfWindow(PhotoIndex now) const {
    return std::max(0, now - options_.match_window);
  }

  /// Matches of photo i (a) with `now` (b), sought among all features the first time.
  const Matches& matchesWith(PhotoIndex i, PhotoIndex now) {
    const auto found = matches_.find(i);
    if (found != matches_.end()) return found->second;
    return matches_[i] = matchFeatures(*map_.photo(i).features, *map_.photo(now).features,
                                       {options_.match_ratio});
  }

  /// Poses `now` in the segment of the last photo, if that is to be had, or else of one before.
  bool continueSegment(PhotoIndex now) {
    for (PhotoIndex i = now - 1; i >= firstOfWindow(now); --i) {
      matchesWith(i, now);
      const int segment = map_.photo(i).segment;
      if (segment < 0) continue;
      if (take(now, segment, poseInSegment(map_, segment, map_.photo(now), matches_, limits())))
        return true;
    }
    return false;
  }

  bool continueOverGround(PhotoIndex now) {
    if (now == 0 || map_.photo(now - 1).segment < 0) return false;
    return take(
        now, map_.photo(now - 1).segment,
        poseOverGround(map_, now - 1, map_.photo(now), matchesWith(now - 1, now), limits()));
  }

  /// Whether there is a pose.
  bool take(PhotoIndex i, int segment, const std::optional<Eigen::Isometry3d>& T_local_cam) {
    if (!T_local_cam) return false;
    map_.photo(i).segment = segment;
    map_.photo(i).T_local_cam = *T_local_cam;
    return true;
  }

  PoseLimits limits() const { return {threshold_, options_.min_inliers}; }

  /// Once `now` is posed, its matches with the photos of its segment are sought where they must
  /// be: more are found, in far less time.
  void matchGuided(PhotoIndex now) {
    const TrackedPhoto& target = map_.photo(now);
    for (PhotoIndex i = firstOfWindow(now); i < now; ++i) {
      const TrackedPhoto& other = map_.photo(i);
      if (other.segment != target.segment) continue;
      matches_[i] = matchFeaturesWithin(*other.features, *target.features,
                                        searchDiscs(map_, i, now, kGuidedMargin * threshold_),
                                        target.normalized, {kGuidedRatio});
      connect(map_, i, now, matches_[i], threshold_);
    }
  }

  /// Two-view geometry with the recent photo of no segment, or alone in one, that fits best.
  void openSegment(PhotoIndex now) {
    PhotoIndex best = -1;
    double best_score = 0;
    TwoView best_view;
    for (PhotoIndex i = firstOfWindow(now); i < now; ++i) {
      if (!isAlone(i)) continue;
      const auto view = twoViewOf(map_.photo(i), map_.photo(now), matchesWith(i, now), limits());
      if (!view) continue;
      const double score = view->inliers * std::min(kParallaxEnough, view->median_parallax_rad);
      if (score <= best_score) continue;
      best_score = score;
      best = i;
      best_view = *view;
    }
    if (best < 0) return;
    TrackedPhoto& first = map_.photo(best);
    if (first.segment < 0) first.segment = segments_++;
    TrackedPhoto& second = map_.photo(now);
    second.segment = first.segment;
    second.T_local_cam = first.T_local_cam * best_view.T_a_b;
    Matches consistent;
    for (std::size_t k = 0; k < matches_[best].size(); ++k)
      if (best_view.inlier[k]) consistent.push_back(matches_[best][k]);
    connect(map_, best, now, consistent, threshold_);
  }

  bool isAlone(PhotoIndex i) const {
    const int segment = map_.photo(i).segment;
    return segment < 0 || std::count_if(map_.photos.begin(), map_.photos.end(),
                                        [&](const auto& p) { return p.segment == segment; }) == 1;
  }

  /// Photos that came before `now` without a pose (too little parallax then, say) get a second
  /// chance on the landmarks of `now`.
  void adoptUnposed(PhotoIndex now) {
    for (PhotoIndex i = firstOfWindow(now); i < now; ++i) {
      if (map_.photo(i).segment >= 0 || map_.photo(i).final) continue;
      const int segment = map_.photo(now).segment;
      const MatchesByPhoto matches = {{now, swapped(matchesWith(i, now))}};
      if (!take(i, segment, poseInSegment(map_, segment, map_.photo(i), matches, limits())))
        continue;
      connect(map_, now, i, matches.at(now), threshold_);
      alignToLandmarks(map_, i);
    }
  }

  std::vector<PhotoIndex> windowOf(PhotoIndex now) const {
    std::vector<PhotoIndex> window;
    for (PhotoIndex i = std::max(0, now - options_.adjustment_window + 1); i <= now; ++i)
      if (map_.photo(i).segment == map_.photo(now).segment) window.push_back(i);
    return window;
  }

  void forgetOld(PhotoIndex now) {
    const PhotoIndex old = now - std::max(options_.match_window, options_.delay) - 1;
    if (old >= 0) map_.photo(old).grey.release();
    for (; forgotten_ <= old && map_.photo(forgotten_).final; ++forgotten_)
      map_.photo(forgotten_).features.reset();
  }

  std::vector<std::shared_ptr<const Keyframe>> finalise(PhotoIndex last) {
    std::vector<std::shared_ptr<const Keyframe>> out;
    for (; finalised_ <= last; ++finalised_) {
      TrackedPhoto& photo = map_.photo(finalised_);
      if (photo.segment < 0) photo.segment = segments_++;
      photo.final = true;
      out.push_back(std::make_shared<const Keyframe>(
          withBestFeatures(keyframeOf(map_, finalised_), map_, finalised_,
                           static_cast<std::size_t>(options_.keyframe_features))));
    }
    return out;
  }

  const OdometryOptions options_;
  LensSearch lens_;
  LocalMap map_;
  MatchesByPhoto matches_;  ///< of the newest photo
  double threshold_ = 0;    ///< inlier distance on the normalized plane
  int segments_ = 0;
  PhotoIndex finalised_ = 0;
  PhotoIndex forgotten_ = 0;  ///< photos without their features any more
};

Odometry::Odometry(const OdometryOptions& options) : tracker_(std::make_unique<Tracker>(options)) {}
Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;

std::vector<std::shared_ptr<const Keyframe>> Odometry::push(const ImageFrame& frame) {
  return push(frame, preparePhoto(frame, tracker_->options()));
}
std::vector<std::shared_ptr<const Keyframe>> Odometry::push(const ImageFrame& frame,
                                                            PreparedPhoto photo) {
  return tracker_->push(frame, std::move(photo));
}
std::vector<std::shared_ptr<const Keyframe>> Odometry::flush() { return tracker_->flush(); }
std::vector<Keyframe> Odometry::provisional() const { return tracker_->provisional(); }

}  // namespace cf
