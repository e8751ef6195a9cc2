// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/candidates.h"

#include <mrpt/math/KDTreeCapable.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace cf {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
  return u.x() * v.y() - u.y() * v.x();
}

double areaOf(const Polygon& p) {
  double twice = 0;
  for (std::size_t i = 0; i < p.size(); ++i) twice += cross(p[i], p[(i + 1) % p.size()]);
  return twice / 2;
}

/// Andrew's monotone chain; counter-clockwise.
Polygon convexHull(Polygon points) {
  std::sort(points.begin(), points.end(), [](const auto& p, const auto& q) {
    return std::tie(p.x(), p.y()) < std::tie(q.x(), q.y());
  });
  Polygon hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= start + 2 &&
             cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Sutherland-Hodgman: the part of a convex polygon inside another.
Polygon intersect(Polygon subject, const Polygon& clip) {
  for (std::size_t e = 0; e < clip.size() && !subject.empty(); ++e) {
    const Eigen::Vector2d origin = clip[e];
    const Eigen::Vector2d edge = clip[(e + 1) % clip.size()] - origin;
    Polygon kept;
    for (std::size_t i = 0; i < subject.size(); ++i) {
      const Eigen::Vector2d &p = subject[i], &q = subject[(i + 1) % subject.size()];
      const double side_p = cross(edge, p - origin), side_q = cross(edge, q - origin);
      if (side_p >= 0) kept.push_back(p);
      if ((side_p >= 0) != (side_q >= 0)) {
        kept.push_back(p + side_p / (side_p - side_q) * (q - p));
      }
    }
    subject = std::move(kept);
  }
  return subject;
}

double radiusOf(const Footprint& f) {
  double radius = 0;
  for (const Eigen::Vector2d& p : f.outline_m) radius = std::max(radius, (p - f.centre_m).norm());
  return radius;
}

std::pair<std::uint16_t, int> segmentOf(const Footprint& f) { return {f.frame.uav, f.segment}; }

bool worthMatching(const Footprint& a, const Footprint& b, const CandidateOptions& options) {
  if (a.frame == b.frame) return false;
  if (segmentOf(a) != segmentOf(b)) return true;
  const auto [low, high] = std::minmax(a.frame.index, b.frame.index);
  return high - low >= static_cast<std::uint32_t>(options.min_frame_gap);
}

bool better(const CandidatePair& p, const CandidatePair& q) {
  // Far beyond the sigma the prediction says nothing: nearer is better then.
  return std::make_tuple(-p.overlap, p.distance_m, p.a.uav, p.a.index, p.b.uav, p.b.index) <
         std::make_tuple(-q.overlap, q.distance_m, q.a.uav, q.a.index, q.b.uav, q.b.index);
}

}  // namespace

void CandidateOptions::visit(OptionVisitor& v) {
  v.number("min_overlap", min_overlap, {0.01, 1},
           "photos are matched if their predicted footprints share this part of the smaller");
  v.number("sigma_factor", sigma_factor, {0, 5},
           "position sigmas by which two footprints may be closer than predicted");
  v.integer("max_pairs_per_photo", max_pairs_per_photo, {1, 1000},
            "pairs that one photo asks for, other UAVs and strips together");
  v.integer("max_unlocated_pairs", max_unlocated_pairs, {0, 1000},
            "pairs that a photo without georeference asks for");
  v.integer("min_frame_gap", min_frame_gap, {1, 1000},
            "photos of one segment closer than this in the sequence are left to odometry");
}

Footprint unlocatedFootprint(FrameId frame, int segment) {
  Footprint f;
  f.frame = frame;
  f.segment = segment;
  f.located = false;
  return f;
}

Footprint predictFootprint(FrameId frame, int segment, const Eigen::Isometry3d& T_world_cam,
                           const CameraModel& camera, double median_depth_m, double sigma_m) {
  Footprint f;
  f.frame = frame;
  f.segment = segment;
  f.sigma_m = sigma_m;
  const Eigen::Vector3d centre = T_world_cam * Eigen::Vector3d(0, 0, median_depth_m);
  f.centre_m = centre.head<2>();
  const Eigen::Vector3d eye = T_world_cam.translation();
  Polygon corners;
  for (const auto& [u, v] : {std::pair{0, 0},
                             {camera.width - 1, 0},
                             {camera.width - 1, camera.height - 1},
                             {0, camera.height - 1}}) {
    const Eigen::Vector3d ray =
        T_world_cam.linear() * camera.undistort({u, v}).homogeneous().normalized();
    const double to_plane = (centre.z() - eye.z()) / ray.z();
    const double limit = 2 * median_depth_m;
    const double length = ray.z() < 0 && to_plane > 0 ? std::min(to_plane, limit) : limit;
    corners.push_back((eye + length * ray).head<2>());
  }
  f.outline_m = convexHull(std::move(corners));
  return f;
}

double overlapOf(const Footprint& a, const Footprint& b, double slack_m) {
  const Eigen::Vector2d apart = a.centre_m - b.centre_m;
  const double distance = apart.norm();
  const double step = std::min(distance, slack_m);
  Polygon moved = b.outline_m;
  if (step > 0) {
    for (Eigen::Vector2d& p : moved) p += step / distance * apart;
  }
  const double smaller = std::min(areaOf(a.outline_m), areaOf(b.outline_m));
  return smaller > 0 ? areaOf(intersect(std::move(moved), a.outline_m)) / smaller : 0;
}

/// The footprints inside and MRPT's KD-tree (nanoflann) over the centres of the located ones. MRPT
/// rebuilds it at the first query after a change: 0.2 ms for a thousand photos, once per keyframe,
/// which an incremental tree of our own would not repay.
struct CandidateIndex::Tree : mrpt::math::KDTreeCapable<CandidateIndex::Tree, double> {
  std::map<FrameId, Footprint> all;
  std::vector<const Footprint*> located;
  std::vector<FrameId> unlocated;
  double max_radius_m = 0, max_sigma_m = 0;

  std::size_t kdtree_get_point_count() const { return located.size(); }
  double kdtree_get_pt(std::size_t i, int dim) const { return located[i]->centre_m[dim]; }
  double kdtree_distance(const double* p, std::size_t i, std::size_t) const {
    return (Eigen::Vector2d(p[0], p[1]) - located[i]->centre_m).squaredNorm();
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

  void add(const Footprint& f) {
    const auto [it, fresh] = all.insert_or_assign(f.frame, f);
    if (!fresh) {
      reindex();
      return;
    }
    index(it->second);
  }
  void index(const Footprint& f) {
    if (f.located) {
      located.push_back(&f);
      max_radius_m = std::max(max_radius_m, radiusOf(f));
      max_sigma_m = std::max(max_sigma_m, f.sigma_m);
    } else {
      unlocated.insert(std::lower_bound(unlocated.begin(), unlocated.end(), f.frame), f.frame);
    }
    kdtree_mark_as_outdated();
  }
  void reindex() {
    located.clear();
    unlocated.clear();
    max_radius_m = max_sigma_m = 0;
    for (const auto& [id, f] : all) index(f);
    kdtree_mark_as_outdated();
  }
};

CandidateIndex::CandidateIndex(const CandidateOptions& options)
    : options_(options), tree_(std::make_unique<Tree>()) {}
CandidateIndex::~CandidateIndex() = default;
CandidateIndex::CandidateIndex(CandidateIndex&&) noexcept = default;
CandidateIndex& CandidateIndex::operator=(CandidateIndex&&) noexcept = default;

std::size_t CandidateIndex::size() const { return tree_->all.size(); }

std::vector<CandidatePair> CandidateIndex::query(const Footprint& footprint) const {
  std::map<std::pair<std::uint16_t, int>, std::vector<CandidatePair>> by_segment;
  const auto propose = [&](const Footprint& other, double overlap, double best, double distance) {
    const auto [a, b] = std::minmax(footprint.frame, other.frame);
    by_segment[segmentOf(other)].push_back({a, b, overlap, best, distance});
  };
  if (footprint.located) {
    std::vector<nanoflann::ResultItem<std::size_t, double>> near;
    const double reach = radiusOf(footprint) + tree_->max_radius_m +
                         options_.sigma_factor * std::hypot(footprint.sigma_m, tree_->max_sigma_m);
    tree_->kdTreeRadiusSearch2D(footprint.centre_m.x(), footprint.centre_m.y(), reach * reach,
                                near);
    for (const auto& item : near) {
      const Footprint& other = *tree_->located[item.first];
      if (!worthMatching(footprint, other, options_)) continue;
      const double slack = options_.sigma_factor * std::hypot(footprint.sigma_m, other.sigma_m);
      const double best = overlapOf(footprint, other, slack);
      if (best < options_.min_overlap) continue;
      propose(other, overlapOf(footprint, other), best,
              (footprint.centre_m - other.centre_m).norm());
    }
  }
  std::vector<CandidatePair> result;
  // Of each segment its best, then of each its second, and so on.
  for (auto& [segment, pairs] : by_segment) std::sort(pairs.begin(), pairs.end(), better);
  const auto wanted = static_cast<std::size_t>(options_.max_pairs_per_photo);
  for (std::size_t rank = 0, found = 1; found > 0 && result.size() < wanted; ++rank) {
    std::vector<CandidatePair> round;
    for (const auto& [segment, pairs] : by_segment) {
      if (rank < pairs.size()) round.push_back(pairs[rank]);
    }
    std::sort(round.begin(), round.end(), better);
    found = round.size();
    result.insert(result.end(), round.begin(), round.end());
  }
  if (result.size() > wanted) result.resize(wanted);

  // Where nothing is known of the place, partners spread evenly over what there is.
  std::vector<FrameId> anywhere;
  if (footprint.located) {
    anywhere = tree_->unlocated;
  } else {
    for (const auto& [id, other] : tree_->all) anywhere.push_back(id);
  }
  anywhere.erase(std::remove_if(anywhere.begin(), anywhere.end(),
                                [&](FrameId id) {
                                  return !worthMatching(footprint, tree_->all.at(id), options_);
                                }),
                 anywhere.end());
  const std::size_t taken =
      std::min(anywhere.size(), static_cast<std::size_t>(options_.max_unlocated_pairs));
  for (std::size_t i = 0; i < taken; ++i) {
    const auto [a, b] = std::minmax(footprint.frame, anywhere[i * anywhere.size() / taken]);
    result.push_back({a, b, 0, 1, -1});
  }
  return result;
}

std::vector<CandidatePair> CandidateIndex::insert(const Footprint& footprint) {
  std::vector<CandidatePair> pairs = query(footprint);
  tree_->add(footprint);
  return pairs;
}

void CandidateIndex::rebuild(const std::vector<Footprint>& footprints) {
  tree_->all.clear();
  for (const Footprint& f : footprints) tree_->all.emplace(f.frame, f);
  tree_->reindex();
}

std::vector<CandidatePair> findCandidates(const std::vector<Footprint>& footprints,
                                          const CandidateOptions& options) {
  CandidateIndex index(options);
  index.rebuild(footprints);
  std::map<std::pair<FrameId, FrameId>, CandidatePair> unique;
  for (const Footprint& f : footprints) {
    for (const CandidatePair& pair : index.query(f))
      unique.emplace(std::pair{pair.a, pair.b}, pair);
  }
  std::vector<CandidatePair> result;
  for (const auto& [key, pair] : unique) result.push_back(pair);
  return result;
}

}  // namespace cf
