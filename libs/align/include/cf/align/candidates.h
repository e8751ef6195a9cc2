// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "cf/base/options.h"
#include "cf/types/camera_model.h"
#include "cf/types/ids.h"

namespace cf {

/// Which pairs of photos are worth matching.
struct CandidateOptions {
  double min_overlap = 0.25;     ///< of the smaller footprint, at best within the position sigma
  double sigma_factor = 2;       ///< how many sigmas two footprints may move towards each other
  int max_pairs_per_photo = 8;   ///< that one photo asks for
  int max_unlocated_pairs = 20;  ///< that a photo without georeference asks for
  int min_frame_gap = 6;         ///< photos of one segment closer than this are odometry's

  void visit(OptionVisitor& v);
};

/// The ground that a photo sees, as predicted from its pose. World frame, metres.
struct Footprint {
  FrameId frame;
  int segment = 0;
  bool located = true;  ///< false: no georeference; `centre_m` and `outline_m` mean nothing
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();  ///< where the optical axis meets the ground
  std::vector<Eigen::Vector2d> outline_m;              ///< convex, counter-clockwise
  double sigma_m = 0;                                  ///< of the horizontal position
};

/// Footprint of a camera at `T_world_cam` whose features have the median depth `median_depth_m`
/// along the optical axis; the ground is taken as level at that depth. Rays that miss this plane or
/// meet it beyond twice the median depth are cut there, so oblique photos stay finite.
Footprint predictFootprint(FrameId frame, int segment, const Eigen::Isometry3d& T_world_cam,
                           const CameraModel& camera, double median_depth_m, double sigma_m);

/// A photo whose segment is not georeferenced: a candidate for every photo.
Footprint unlocatedFootprint(FrameId frame, int segment);

/// Area that two footprints share, divided by the area of the smaller one, after `b` has moved
/// towards `a` by at most `slack_m`.
double overlapOf(const Footprint& a, const Footprint& b, double slack_m = 0);

struct CandidatePair {
  FrameId a, b;             ///< a < b
  double overlap = 0;       ///< of the footprints as predicted
  double best_overlap = 0;  ///< with the slack that the position sigmas allow
  double distance_m = 0;    ///< between the centres; -1 where one is not located
};

/// Grows by one photo at a time. A photo asks for at most `max_pairs_per_photo` partners, taken in
/// turn from each other segment, nearest overlap first, so that one UAV cannot crowd out another.
class CandidateIndex {
 public:
  explicit CandidateIndex(const CandidateOptions& options);
  ~CandidateIndex();
  CandidateIndex(CandidateIndex&&) noexcept;
  CandidateIndex& operator=(CandidateIndex&&) noexcept;

  /// The pairs of the new photo with those inside, best first; then it is inside itself.
  std::vector<CandidatePair> insert(const Footprint& footprint);
  /// The pairs of `footprint` with those inside (itself left out), best first.
  std::vector<CandidatePair> query(const Footprint& footprint) const;
  /// Replaces all that is inside, for poses that a new version has moved.
  void rebuild(const std::vector<Footprint>& footprints);
  std::size_t size() const;

 private:
  struct Tree;
  CandidateOptions options_;
  std::unique_ptr<Tree> tree_;
};

/// All pairs that any of the photos asks for, sorted by (a, b), each once. The result does not
/// depend on the order of `footprints`.
std::vector<CandidatePair> findCandidates(const std::vector<Footprint>& footprints,
                                          const CandidateOptions& options);

}  // namespace cf
