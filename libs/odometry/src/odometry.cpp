// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/odometry/odometry.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "cf/features/match.h"
#include "cf/geometry/pnp.h"
#include "cf/geometry/triangulation.h"
#include "cf/geometry/two_view.h"
#include "local_adjustment.h"
#include "local_map.h"

namespace cf {
namespace {

/// A new landmark needs this angle between its rays; less says nothing about depth.
constexpr double kMinTriangulationAngle = 0.015;

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
}

class Odometry::Tracker {
 public:
  explicit Tracker(const OdometryOptions& options) : options_(options) {}

  std::vector<std::shared_ptr<const Keyframe>> push(const ImageFrame& frame) {
    const PhotoIndex now = add(frame);
    if (!continueSegment(now)) openSegment(now);
    if (map_.photo(now).segment >= 0) {
      adoptUnposed(now);
      adjustLocally(map_, windowOf(now), threshold_);
    }
    forgetOld(now);
    return finalise(now - options_.delay);
  }

  std::vector<std::shared_ptr<const Keyframe>> flush() {
    return finalise(static_cast<PhotoIndex>(map_.photos.size()) - 1);
  }

  Keyframe newest() const { return keyframeOf(static_cast<PhotoIndex>(map_.photos.size()) - 1); }

 private:
  using Matches = std::vector<FeatureMatch>;

  PhotoIndex add(const ImageFrame& frame) {
    TrackedPhoto photo;
    photo.frame = frame;
    photo.frame.image.release();
    photo.features = std::make_shared<const FeatureSet>(extractFeatures(frame, options_.features));
    photo.normalized = normalizedPoints(*photo.features, frame.camera);
    photo.landmark.assign(photo.features->size(), -1);
    threshold_ = options_.inlier_px * photo.features->pixel_size / frame.camera.fx;

    const auto now = static_cast<PhotoIndex>(map_.photos.size());
    matches_.clear();
    for (PhotoIndex i = std::max(0, now - options_.match_window); i < now; ++i) {
      matches_[i] = matchFeatures(*map_.photo(i).features, *photo.features, {options_.match_ratio});
      photo.matches += static_cast<int>(matches_[i].size());
    }
    map_.photos.push_back(std::move(photo));
    return now;
  }

  /// Poses `now` in the recent segment that it shares most landmarks with.
  bool continueSegment(PhotoIndex now) {
    std::map<int, int> shared;
    for (const auto& [i, matches] : matches_)
      for (const FeatureMatch& m : matches)
        if (landmarkAt(i, m.a) >= 0) ++shared[map_.photo(i).segment];
    std::vector<std::pair<int, int>> order;
    for (const auto& [segment, count] : shared) order.emplace_back(count, segment);
    std::sort(order.rbegin(), order.rend());
    for (const auto& [count, segment] : order)
      if (resectInto(segment, now, matches_, false)) return true;
    return false;
  }

  /// Resection of `photo` against the landmarks that its matches (with other photos) see. `flipped`
  /// where the photo is the first of its matches.
  bool resectInto(int segment, PhotoIndex photo, const std::map<PhotoIndex, Matches>& matches,
                  bool flipped) {
    std::vector<Eigen::Vector3d> points;
    std::vector<Eigen::Vector2d> seen;
    std::vector<int> features;
    std::set<int> used;
    TrackedPhoto& target = map_.photo(photo);
    // The most recent photo first: its landmarks are seen most alike.
    for (auto it = matches.rbegin(); it != matches.rend(); ++it) {
      if (map_.photo(it->first).segment != segment) continue;
      for (const FeatureMatch& m : it->second) {
        const int other = flipped ? m.b : m.a, own = flipped ? m.a : m.b;
        const int id = landmarkAt(it->first, other);
        if (id < 0 || !used.insert(own).second) continue;
        points.push_back(map_.position(map_.landmarks[static_cast<std::size_t>(id)]));
        seen.push_back(target.normalized[static_cast<std::size_t>(own)]);
        features.push_back(own);
      }
    }
    const auto pose = resect(points, seen, {threshold_, options_.min_inliers});
    if (!pose) return false;
    target.segment = segment;
    target.T_local_cam = pose->T_world_cam;
    target.inliers = pose->inliers;
    for (const auto& [i, all] : matches)
      if (map_.photo(i).segment == segment) connect(i, photo, all, flipped);
    return true;
  }

  /// Two-view geometry with the recent photo of no segment, or alone in one, that fits best.
  void openSegment(PhotoIndex now) {
    PhotoIndex best = -1;
    double best_score = 0;
    TwoView best_view;
    for (const auto& [i, matches] : matches_) {
      if (!isAlone(i)) continue;
      std::vector<Eigen::Vector2d> a, b;
      for (const FeatureMatch& m : matches) {
        a.push_back(map_.photo(i).normalized[static_cast<std::size_t>(m.a)]);
        b.push_back(map_.photo(now).normalized[static_cast<std::size_t>(m.b)]);
      }
      TwoViewOptions two_view;
      two_view.threshold = threshold_ / 2;
      two_view.min_inliers = options_.min_inliers;
      const auto view = estimateTwoView(a, b, two_view);
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
    first.inliers = std::max(first.inliers, best_view.inliers);
    second.inliers = best_view.inliers;
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
    for (const auto& [i, matches] : matches_)
      if (map_.photo(i).segment < 0 && !map_.photo(i).final)
        resectInto(map_.photo(now).segment, i, {{now, matches}}, true);
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
    if (old >= 0) map_.photo(old).features.reset();
  }

  std::vector<std::shared_ptr<const Keyframe>> finalise(PhotoIndex last) {
    std::vector<std::shared_ptr<const Keyframe>> out;
    for (; finalised_ <= last; ++finalised_) {
      TrackedPhoto& photo = map_.photo(finalised_);
      if (photo.segment < 0) photo.segment = segments_++;
      photo.final = true;
      Keyframe keyframe = keyframeOf(finalised_);
      keepBest(photo, keyframe);
      out.push_back(std::make_shared<const Keyframe>(std::move(keyframe)));
    }
    return out;
  }

  Keyframe keyframeOf(PhotoIndex i) const {
    const TrackedPhoto& photo = map_.photo(i);
    Keyframe k;
    k.id = photo.frame.id;
    k.time = photo.frame.time;
    k.name = photo.frame.name;
    k.segment = photo.segment;
    k.T_local_cam = photo.T_local_cam;
    k.camera = photo.frame.camera;
    k.attitude = photo.frame.attitude;
    k.height_above_ground_m = photo.frame.height_above_ground_m;
    k.matches = photo.matches;
    k.inliers = photo.inliers;
    k.inverse_depth.assign(photo.landmark.size(), 0.0f);
    const Eigen::Isometry3d T_cam_local = photo.T_local_cam.inverse();
    for (std::size_t f = 0; f < photo.landmark.size(); ++f) {
      if (photo.landmark[f] < 0) continue;
      const Landmark& landmark = map_.landmarks[static_cast<std::size_t>(photo.landmark[f])];
      const double depth = (T_cam_local * map_.position(landmark)).z();
      if (depth > 0) k.inverse_depth[f] = static_cast<float>(1 / depth);
    }
    return k;
  }

  /// The features that leave: those seen in most photos first, up to the seam's budget.
  void keepBest(const TrackedPhoto& photo, Keyframe& keyframe) const {
    std::vector<int> order(photo.landmark.size());
    std::iota(order.begin(), order.end(), 0);
    const auto sights = [&](int f) {
      const int id = photo.landmark[static_cast<std::size_t>(f)];
      return id < 0 ? std::size_t{0}
                    : map_.landmarks[static_cast<std::size_t>(id)].observations.size();
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return sights(a) > sights(b); });
    const auto budget = static_cast<std::size_t>(options_.keyframe_features);
    if (order.size() > budget) order.resize(budget);
    std::sort(order.begin(), order.end());
    keyframe.features = std::make_shared<const FeatureSet>(subset(*photo.features, order));
    std::vector<float> inverse_depth;
    for (const int f : order)
      inverse_depth.push_back(keyframe.inverse_depth[static_cast<std::size_t>(f)]);
    keyframe.inverse_depth = std::move(inverse_depth);
  }

  int landmarkAt(PhotoIndex photo, int feature) const {
    return map_.photo(photo).landmark[static_cast<std::size_t>(feature)];
  }

  const OdometryOptions options_;
  LocalMap map_;
  std::map<PhotoIndex, Matches> matches_;  ///< of the newest photo, by earlier photo
  double threshold_ = 0;                   ///< inlier distance on the normalized plane
  int segments_ = 0;
  PhotoIndex finalised_ = 0;
};

Odometry::Odometry(const OdometryOptions& options) : tracker_(std::make_unique<Tracker>(options)) {}
Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;

std::vector<std::shared_ptr<const Keyframe>> Odometry::push(const ImageFrame& frame) {
  return tracker_->push(frame);
}
std::vector<std::shared_ptr<const Keyframe>> Odometry::flush() { return tracker_->flush(); }
Keyframe Odometry::newest() const { return tracker_->newest(); }

}  // namespace cf
