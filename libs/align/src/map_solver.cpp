// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map_solver.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "cf/base/median.h"
#include "homography_alignment.h"
#include "map_extension.h"
#include "relative_poses.h"
#include "seam_points.h"
#include "track_triangulation.h"

namespace cf {
namespace {

/// Photos of one UAV this close in its sequence are matched wherever they are thought to be.
constexpr std::uint32_t kSequenceNeighbours = 3;
/// Rigid segments leave a seam of this size between the photos of one point [px].
constexpr double kRigidThresholdPx = 5;

/// In VO units; 0 where it has no landmark.
double medianDepthOf(const Keyframe& photo) {
  std::vector<float> inverse;
  for (const float value : photo.inverse_depth)
    if (value > 0) inverse.push_back(value);
  if (inverse.empty()) return 0;
  return 1 / static_cast<double>(upperMedian(std::move(inverse)));
}

/// Where a photo is before alignment, as its UAV knows it.
struct Alone {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  double scale = 1, scale_sigma = 0;
  double sigma_m = 0;  ///< horizontal
  bool georeferenced = false;
  int segment = 0;
};

AlignOptions withSharedBias(AlignOptions options) {
  options.relative.bias_horizontal_m = options.joint.bias_sigma_horizontal_m;
  options.relative.bias_vertical_m = options.joint.bias_sigma_vertical_m;
  return options;
}

std::map<FrameId, Alone> aloneOf(const UavKnowledge& known) {
  std::map<FrameId, Alone> alone;
  for (const GeoSegment& segment : known.segments)
    for (const auto& pose : segment.poses) {
      Alone a;
      a.T_world_cam = pose.T_world_cam;
      a.scale = segment.georeferenced ? segment.scale : 1;
      a.scale_sigma = segment.scale_sigma;
      const double estimated = pose.covariance.topLeftCorner<2, 2>().trace() / 2;
      const Eigen::Vector3d& noise = known.quality[segment.id.uav].sigma_m;
      // Two receivers disagree by more than either one's noise tells.
      a.sigma_m = std::sqrt(estimated) + std::max(2.0, noise.head<2>().norm());
      a.georeferenced = segment.georeferenced;
      a.segment = segment.id.segment;
      alone[pose.frame] = a;
    }
  return alone;
}

PairViews viewsOf(const std::map<FrameId, Alone>& alone, const MatchGraph& graph) {
  PairViews views;
  for (const auto& [id, a] : alone)
    views[id] = {&graph.photo(id), a.T_world_cam, a.scale, a.scale_sigma, a.georeferenced};
  return views;
}

std::map<FrameId, Located> locatedBy(const Placement& placement) {
  std::map<FrameId, Located> located;
  for (const auto& [id, placed] : placement.photos)
    if (placed.component == 0) located[id] = {placed.T_world_cam, placed.scale};
  return located;
}

}  // namespace

MapSolver::MapSolver(const AlignOptions& options, std::uint16_t center)
    : options_(withSharedBias(options)), center_(center), graph_(MatchGraphOptions{}) {}

void MapSolver::push(const GeoKeyframe& keyframe) {
  graph_.add(keyframe.keyframe);
  median_depth_[keyframe.keyframe->id] = medianDepthOf(*keyframe.keyframe);
  if (keyframe.fix) fixes_[keyframe.keyframe->id] = *keyframe.fix;
}

Alignment MapSolver::solve(const UavKnowledge& known, bool draft, std::uint32_t version,
                           const PhotoSource& source) {
  const std::map<FrameId, Alone> alone = aloneOf(known);
  const PairViews views = viewsOf(alone, graph_);
  matchNeighbours();
  matchCandidates(footprints(known));

  Alignment out;
  PairObservations observed;  // under the homography method
  const auto place = [&] {
    if (options_.method != "homography") return joinSegments(graph_, known.segments, center_);
    auto placed = placeByRelativePoses(
        graph_, known.segments, weighedFixes(known.quality),
        observePairs(graph_, views, kTwoBest, options_.pair, observed), center_, options_.relative);
    out.gnss_bias_m = std::move(placed.gnss_bias_m);
    return std::move(placed.placement);
  };
  Placement placement = place();
  // Joined photos lie better than GNSS alone could tell: overlaps that it missed show now.
  if (matchCandidates(footprints(known, locatedBy(placement)))) placement = place();

  out.relative = placement.relative;
  out.components = placement.components;
  out.table.cameras = known.cameras;
  out.table.version = version;
  if (options_.method == "homography")
    keepRigid(placement, out);
  else
    adjust(placement, known, draft, source, out);
  addPoses(placement, out);
  if (!draft) {
    addRelativePoses(views, placement, observed, out);
    addSeamPoints(out);
  }
  return out;
}

/// Fixes with the noise that their receiver shows, where that is above what it tags.
std::map<FrameId, GnssPosition> MapSolver::weighedFixes(
    const std::vector<GnssQuality>& quality) const {
  std::map<FrameId, GnssPosition> fixes = fixes_;
  for (auto& [id, fix] : fixes) fix.sigma_m = fix.sigma_m.cwiseMax(quality[id.uav].sigma_m);
  return fixes;
}

void MapSolver::matchNeighbours() {
  std::vector<MatchGraph::Pair> pairs;
  for (const auto& [id, photo] : graph_.photos())
    for (std::uint32_t step = 1; step <= kSequenceNeighbours; ++step) {
      const FrameId next{id.uav, id.index + step};
      if (graph_.photos().count(next) > 0) pairs.emplace_back(id, next);
    }
  graph_.match(pairs);
}

/// Whether any became connected that was not before.
bool MapSolver::matchCandidates(const std::vector<Footprint>& footprints) {
  std::vector<MatchGraph::Pair> pairs;
  for (const CandidatePair& c : findCandidates(footprints, options_.candidates))
    pairs.emplace_back(c.a, c.b);
  return graph_.match(pairs);
}

std::vector<Footprint> MapSolver::footprints(const UavKnowledge& known,
                                             const std::map<FrameId, Located>& located) const {
  std::vector<Footprint> out;
  for (const auto& [id, a] : aloneOf(known)) {
    const CameraModel& camera = graph_.photo(id).camera;
    const auto in_map = located.find(id);
    const double scale = in_map != located.end() ? in_map->second.scale : a.scale;
    const double depth = median_depth_.at(id) * scale;
    if (depth > 0 && in_map != located.end())
      out.push_back(
          predictFootprint(id, a.segment, in_map->second.T_world_cam, camera, depth, 0.05 * depth));
    else if (depth > 0 && a.georeferenced)
      out.push_back(predictFootprint(id, a.segment, a.T_world_cam, camera, depth, a.sigma_m));
    else
      out.push_back(unlocatedFootprint(id, a.segment));
  }
  return out;
}

void MapSolver::adjust(const Placement& placement, const UavKnowledge& known, bool draft,
                       const PhotoSource& source, Alignment& out) const {
  const std::vector<Track> tracks = buildTracks(graph_);
  const std::map<FrameId, GnssPosition> fixes = weighedFixes(known.quality);
  std::set<std::uint16_t> calibrated;
  for (int component = 0; component < placement.components; ++component) {
    JointProblem problem;
    problem.cameras = out.table.cameras;
    problem.draft = draft;
    problem.source = source;
    std::vector<double> depths;
    for (const auto& [id, placed] : placement.photos) {
      if (placed.component != component) continue;
      JointPhoto photo{id, placed.T_world_cam, {}};
      const auto fix = fixes.find(id);
      if (fix != fixes.end() && !placement.relative) photo.fix = fix->second;
      problem.photos.push_back(photo);
      const double depth = median_depth_.at(id) * placed.scale;
      if (depth > 0) depths.push_back(depth);
    }
    if (problem.photos.size() < 2 || depths.empty()) continue;
    problem.median_depth_m = upperMedian(std::move(depths));
    JointSolution solution = adjustJointly(graph_, tracks, problem, options_.joint);
    for (const auto& [id, T] : solution.T_world_cam) {
      const auto covariance = solution.covariance.find(id);
      out.table.poses[id] = {T, {}, component, 0, 0, 0};
      if (covariance != solution.covariance.end())
        out.table.poses[id].covariance = covariance->second;
      // The first, largest component that a UAV is in calibrates its camera.
      if (calibrated.insert(id.uav).second) {
        out.table.cameras[id.uav] = solution.cameras[id.uav];
        out.table.cameras[id.uav].version = out.table.version;
      }
    }
    for (const auto& [uav, bias] : solution.bias_m) out.gnss_bias_m.emplace(uav, bias);
    if (component == 0) out.reprojection_rms_px = solution.reprojection_rms_px;
    std::move(solution.points.begin(), solution.points.end(), std::back_inserter(out.points));
  }
}

/// Points of the map from poses that stay as they are placed.
void MapSolver::keepRigid(const Placement& placement, Alignment& out) const {
  const std::vector<Track> tracks = buildTracks(graph_);
  for (int component = 0; component < placement.components; ++component) {
    std::map<FrameId, PosedPhoto> photos;
    for (const auto& [id, placed] : placement.photos)
      if (placed.component == component) photos[id] = {placed.T_world_cam, graph_.photo(id).camera};
    std::vector<SparsePoint> points = triangulateTracks(graph_, tracks, photos, kRigidThresholdPx);
    if (component == 0) out.reprojection_rms_px = reprojectionRmsPx(graph_, points, photos);
    std::move(points.begin(), points.end(), std::back_inserter(out.points));
  }
}

/// Poses of photos that no adjustment held, and the range of depths of every photo.
void MapSolver::addPoses(const Placement& placement, Alignment& out) const {
  for (const auto& [id, placed] : placement.photos)
    if (out.table.poses.count(id) == 0)
      out.table.poses[id] = {placed.T_world_cam, {}, placed.component, 0, 0, 0};
  setDepths(out.points, out.table);
}

void MapSolver::addSeamPoints(Alignment& out) const {
  std::map<FrameId, PosedPhoto> photos;
  for (const auto& [id, entry] : out.table.poses) {
    const CameraModel& given = graph_.photo(id).camera;
    photos[id] = {entry.T_world_cam, out.table.cameras[id.uav].scaled(given.width, given.height)};
  }
  out.seam_points = seamPoints(graph_, buildTracks(graph_), photos);
}

void MapSolver::addRelativePoses(const PairViews& views, const Placement& placement,
                                 PairObservations& observed, Alignment& out) const {
  const std::map<FrameId, double> scales = scalesInMap(graph_, out.table, out.points);
  const auto scaleOf = [&](FrameId id) {
    const auto measured = scales.find(id);
    return measured != scales.end() ? measured->second : placement.photos.at(id).scale;
  };
  // Seen through the cameras of the map: a refined focal length changes what a photo observes.
  std::map<FrameId, Keyframe> calibrated;
  PairViews refined = views;
  if (options_.method != "homography")
    for (auto& [id, view] : refined) {
      Keyframe& keyframe = calibrated.emplace(id, graph_.photo(id)).first->second;
      keyframe.camera =
          out.table.cameras[id.uav].scaled(keyframe.camera.width, keyframe.camera.height);
      view.keyframe = &keyframe;
    }
  const PairSelection selection = options_.method == "homography" ? kTwoBest : kMutualBest;
  for (const auto& o : observePairs(graph_, refined, selection, options_.pair, observed)) {
    const FrameId a = o.pose.a, b = o.pose.b;
    if (a.uav == b.uav || out.table.poses.count(a) == 0 || out.table.poses.count(b) == 0) continue;
    out.relative_poses.push_back(relativePoseInMap(o, views, out.table, scaleOf(a), scaleOf(b)));
  }
}

}  // namespace cf
