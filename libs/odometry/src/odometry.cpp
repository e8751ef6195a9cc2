// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/odometry/odometry.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "cf/features/match.h"
#include "cf/features/patch_alignment.h"
#include "cf/geometry/pnp.h"
#include "cf/geometry/triangulation.h"
#include "cf/geometry/two_view.h"
#include "chain_alignment.h"
#include "ground_scale.h"
#include "guided_search.h"
#include "keyframe_of.h"
#include "local_adjustment.h"
#include "local_map.h"
#include "photo_pose.h"
#include "self_calibration.h"

namespace cf {
namespace {

/// A new landmark needs this angle between its rays; less says nothing about depth.
constexpr double kMinTriangulationAngle = 0.015;
constexpr double kAlignmentMegapixels = 3;  ///< of the photos that patches are aligned in
/// A guided match may lie so many inlier thresholds from where it is expected: what the pose and
/// the depth are wrong by, and room for others to be compared with.
constexpr double kGuidedMargin = 6;
constexpr double kGuidedRatio = 0.75;  ///< the best of a few must be better than the best of all
constexpr int kFewestForScale = 5;     ///< landmarks that give a baseline its length
/// A resection may leave the photo's corners so uncertain, in inlier thresholds.
constexpr double kMostStray = 3;
/// Photos that share no landmark are far apart.
constexpr double kLeastParallaxOverGround = 0.2;

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

  Keyframe newest() const {
    return keyframeOf(map_, static_cast<PhotoIndex>(map_.photos.size()) - 1);
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
      if (segment >= 0 && poseIn(segment, now, matches_, false)) return true;
    }
    return false;
  }

  /// Where the last photo shares ground with `now` but no landmark (half a photo of overlap, or a
  /// little more): two-view geometry, and the ground under the last photo for the length of the
  /// baseline: one plane through its landmarks on the one half and what both see on the other.
  bool continueOverGround(PhotoIndex now) {
    if (now == 0 || map_.photo(now - 1).segment < 0) return false;
    const TrackedPhoto& last = map_.photo(now - 1);
    TrackedPhoto& target = map_.photo(now);
    const auto view = twoViewOf(last, target, matchesWith(now - 1, now), false);
    if (!view || view->median_parallax_rad < kLeastParallaxOverGround) return false;
    std::vector<GroundSight> known, measured;
    const std::vector<float> inverse_depth = keyframeOf(map_, now - 1).inverse_depth;
    for (std::size_t f = 0; f < inverse_depth.size(); ++f)
      if (inverse_depth[f] > 0)
        known.push_back({last.normalized[f], static_cast<double>(inverse_depth[f])});
    const Matches& matches = matches_[now - 1];
    for (std::size_t k = 0; k < matches.size(); ++k) {
      if (!view->inlier[k]) continue;
      const Eigen::Vector2d& here = last.normalized[static_cast<std::size_t>(matches[k].a)];
      const auto point =
          triangulate({{Eigen::Isometry3d::Identity(), here},
                       {view->T_a_b, target.normalized[static_cast<std::size_t>(matches[k].b)]}});
      if (point && point->max_error < threshold_)
        measured.push_back({here, 1 / point->position.z()});
    }
    const auto scale = scaleByGround(known, measured);
    if (!scale) return false;
    Eigen::Isometry3d T_last_cam = view->T_a_b;
    T_last_cam.translation() *= *scale;
    target.segment = last.segment;
    target.T_local_cam = last.T_local_cam * T_last_cam;
    return true;
  }

  /// Poses a photo on the landmarks that its matches with other photos see. `flipped` where the
  /// photo is the first of its matches.
  bool poseIn(int segment, PhotoIndex photo, const std::map<PhotoIndex, Matches>& matches,
              bool flipped) {
    TrackedPhoto& target = map_.photo(photo);
    const std::vector<LandmarkSight> seen = sightsOf(segment, target, matches, flipped);
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> pixels;
    for (const LandmarkSight& s : seen) {
      points.push_back(s.p_local);
      pixels.push_back(s.normalized);
    }
    const auto resected = resect(points, pixels, {threshold_, options_.min_inliers});
    double stray = std::numeric_limits<double>::infinity();
    if (resected) {
      std::vector<LandmarkSight> inliers;
      for (std::size_t i = 0; i < seen.size(); ++i)
        if (resected->inlier[i]) inliers.push_back(seen[i]);
      const CameraModel& camera = target.frame.camera;
      const Eigen::Vector2d corner(camera.width / (2 * camera.fx), camera.height / (2 * camera.fy));
      stray = strayAtCorners(resected->T_world_cam, inliers, corner, threshold_ / 3);
    }
    std::optional<Eigen::Isometry3d> T_local_cam;
    if (stray > threshold_) T_local_cam = poseByTwoView(segment, target, matches, flipped, seen);
    if (!T_local_cam && stray < kMostStray * threshold_) T_local_cam = resected->T_world_cam;
    if (!T_local_cam) return false;
    target.segment = segment;
    target.T_local_cam = *T_local_cam;
    return true;
  }

  /// Where the photo sees landmarks of the segment; of photos that see the same, the most recent
  /// counts: it sees it most alike.
  std::vector<LandmarkSight> sightsOf(int segment, const TrackedPhoto& target,
                                      const std::map<PhotoIndex, Matches>& matches,
                                      bool flipped) const {
    std::vector<LandmarkSight> seen;
    std::set<int> used;
    for (auto it = matches.rbegin(); it != matches.rend(); ++it) {
      if (map_.photo(it->first).segment != segment) continue;
      for (const FeatureMatch& m : it->second) {
        const int other = flipped ? m.b : m.a, own = flipped ? m.a : m.b;
        const int id = landmarkAt(it->first, other);
        if (id < 0 || !used.insert(own).second) continue;
        seen.push_back({map_.position(map_.landmarks[static_cast<std::size_t>(id)]),
                        target.normalized[static_cast<std::size_t>(own)]});
      }
    }
    return seen;
  }

  /// Where landmarks are too few, or too close together: two-view geometry with the photo of the
  /// segment that has most matches, and the landmarks for the length of the baseline.
  std::optional<Eigen::Isometry3d> poseByTwoView(int segment, const TrackedPhoto& target,
                                                 const std::map<PhotoIndex, Matches>& matches,
                                                 bool flipped,
                                                 const std::vector<LandmarkSight>& seen) const {
    if (static_cast<int>(seen.size()) < kFewestForScale) return std::nullopt;
    PhotoIndex other = -1;
    for (const auto& [i, all] : matches)
      if (map_.photo(i).segment == segment && (other < 0 || all.size() >= matches.at(other).size()))
        other = i;
    const TrackedPhoto& posed = map_.photo(other);
    const auto view = twoViewOf(posed, target, matches.at(other), flipped);
    if (!view) return std::nullopt;
    const auto pose =
        poseByScaledTwoView(posed.T_local_cam, view->T_a_b, seen, threshold_, kFewestForScale);
    if (!pose) return std::nullopt;
    return pose.value();
  }

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
      connect(i, now, matches_[i], false);
    }
  }

  /// Of `target` (b) against `posed` (a); `flipped` where the matches have it the other way round.
  Result<TwoView> twoViewOf(const TrackedPhoto& posed, const TrackedPhoto& target,
                            const Matches& matches, bool flipped) const {
    std::vector<Eigen::Vector2d> a, b;
    for (const FeatureMatch& m : matches) {
      a.push_back(posed.normalized[static_cast<std::size_t>(flipped ? m.b : m.a)]);
      b.push_back(target.normalized[static_cast<std::size_t>(flipped ? m.a : m.b)]);
    }
    return estimateTwoView(a, b, twoViewOptions());
  }

  TwoViewOptions twoViewOptions() const {
    TwoViewOptions options;
    options.threshold = threshold_ / 2;
    options.min_inliers = options_.min_inliers;
    return options;
  }

  /// Two-view geometry with the recent photo of no segment, or alone in one, that fits best.
  void openSegment(PhotoIndex now) {
    PhotoIndex best = -1;
    double best_score = 0;
    TwoView best_view;
    for (PhotoIndex i = firstOfWindow(now); i < now; ++i) {
      if (!isAlone(i)) continue;
      const auto view = twoViewOf(map_.photo(i), map_.photo(now), matchesWith(i, now), false);
      if (!view) continue;
      const double score = view->inliers * std::min(0.3, view->median_parallax_rad);
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
    connect(best, now, consistent, false);
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
      const Matches& matches = matchesWith(i, now);
      if (!poseIn(map_.photo(now).segment, i, {{now, matches}}, true)) continue;
      connect(now, i, matches, true);
      alignToLandmarks(map_, i);
    }
  }

  /// Extends the landmarks of posed photo `i` to posed photo `j`, or triangulates new ones, from
  /// their matches (a in i and b in j; the other way round if flipped).
  void connect(PhotoIndex i, PhotoIndex j, const Matches& matches, bool flipped) {
    TrackedPhoto& pi = map_.photo(i);
    TrackedPhoto& pj = map_.photo(j);
    for (const FeatureMatch& m : matches) {
      const int fi = flipped ? m.b : m.a, fj = flipped ? m.a : m.b;
      int& li = pi.landmark[static_cast<std::size_t>(fi)];
      int& lj = pj.landmark[static_cast<std::size_t>(fj)];
      const Sight si{pi.T_local_cam, pi.normalized[static_cast<std::size_t>(fi)]};
      const Sight sj{pj.T_local_cam, pj.normalized[static_cast<std::size_t>(fj)]};
      if (li >= 0 && lj >= 0) continue;
      if (li < 0 && lj < 0) {
        const auto point = triangulate({si, sj});
        if (!point || point->max_error > threshold_ ||
            point->max_angle_rad < kMinTriangulationAngle)
          continue;
        li = lj = static_cast<int>(map_.landmarks.size());
        const double depth = (pi.T_local_cam.inverse() * point->position).z();
        map_.landmarks.push_back({1 / depth, {{i, fi}, {j, fj}}});
      } else {
        const int id = std::max(li, lj);
        Landmark& landmark = map_.landmarks[static_cast<std::size_t>(id)];
        const bool extend_j = lj < 0;
        if (reprojectionError(extend_j ? sj : si, map_.position(landmark)) > threshold_) continue;
        const LandmarkObservation observation =
            extend_j ? LandmarkObservation{j, fj} : LandmarkObservation{i, fi};
        const bool seen_already =
            std::any_of(landmark.observations.begin(), landmark.observations.end(),
                        [&](const auto& o) { return o.photo == observation.photo; });
        if (seen_already) continue;
        landmark.observations.push_back(observation);
        (extend_j ? lj : li) = id;
      }
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

  int landmarkAt(PhotoIndex photo, int feature) const {
    return map_.photo(photo).landmark[static_cast<std::size_t>(feature)];
  }

  const OdometryOptions options_;
  LensSearch lens_;
  LocalMap map_;
  std::map<PhotoIndex, Matches> matches_;  ///< of the newest photo, by earlier photo
  double threshold_ = 0;                   ///< inlier distance on the normalized plane
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
Keyframe Odometry::newest() const { return tracker_->newest(); }

}  // namespace cf
