// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/aligner.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "homography_alignment.h"
#include "map_extension.h"
#include "relative_poses.h"
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
  const auto middle = inverse.begin() + static_cast<long>(inverse.size() / 2);
  std::nth_element(inverse.begin(), middle, inverse.end());
  return 1 / static_cast<double>(*middle);
}

/// Where a photo is in the map, and metres per VO unit there.
struct Located {
  Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
  double scale = 1;
};

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

}  // namespace

void AlignOptions::visit(OptionVisitor& v) {
  v.choice("method", method, {"joint", "homography"},
           "joint: bundle adjustment of all UAVs; homography: the paper's relative poses alone");
  v.integer("update_every", update_every, {0, 10000},
            "keyframes between versions of the map during the flight; 0: none before its end");
  v.number("growth", growth, {1.05, 100},
           "the whole map is solved anew when it has so many times the photos of the last solve");
  candidates.visit(v);
  pair.visit(v);
  joint.visit(v);
  relative.visit(v);
}

class Aligner::State {
 public:
  State(const AlignOptions& options, std::uint16_t center)
      : options_(withSharedBias(options)), center_(center), graph_(MatchGraphOptions{}) {}

  void push(const GeoKeyframe& keyframe) {
    graph_.add(keyframe.keyframe);
    median_depth_[keyframe.keyframe->id] = medianDepthOf(*keyframe.keyframe);
    if (keyframe.fix) fixes_[keyframe.keyframe->id] = *keyframe.fix;
  }

  const PoseTable& update(const std::vector<GeoSegment>& segments,
                          const std::vector<GnssQuality>& quality,
                          const std::vector<CameraModel>& cameras) {
    if (static_cast<double>(graph_.photos().size()) >= options_.growth * solved_photos_) {
      Alignment draft = solve(segments, quality, cameras, true, {});
      map_.scales = scalesInMap(graph_, draft.table, draft.points);
      map_.table = std::move(draft.table);
      solved_photos_ = static_cast<double>(graph_.photos().size());
    } else {
      extend(segments, quality);
    }
    return map_.table;
  }

  std::optional<Sim3> similarity(FrameId photo, int segment) const {
    return similarityInMap(graph_, map_, photo, segment);
  }

  Alignment solve(const std::vector<GeoSegment>& segments, const std::vector<GnssQuality>& quality,
                  const std::vector<CameraModel>& cameras, bool draft, const PhotoSource& source) {
    const std::map<FrameId, Alone> alone = aloneOf(segments, quality);
    const PairViews views = viewsOf(alone);
    matchNeighbours();
    matchCandidates(footprints(alone));

    Alignment out;
    PairObservations observed;  // under the homography method
    const auto place = [&] {
      if (options_.method != "homography") return joinSegments(graph_, segments, center_);
      auto placed =
          placeByRelativePoses(graph_, segments, weighedFixes(quality),
                               observePairs(graph_, views, kTwoBest, options_.pair, observed),
                               center_, options_.relative);
      out.gnss_bias_m = std::move(placed.gnss_bias_m);
      return std::move(placed.placement);
    };
    Placement placement = place();
    // Joined photos lie better than GNSS alone could tell: overlaps that it missed show now.
    if (matchCandidates(footprints(alone, locatedBy(placement)))) placement = place();

    out.relative = placement.relative;
    out.components = placement.components;
    out.table.cameras = cameras;
    out.table.version = ++version_;
    if (options_.method == "homography")
      keepRigid(placement, out);
    else
      adjust(placement, quality, draft, source, out);
    addPoses(placement, out);
    if (!draft) addRelativePoses(views, placement, observed, out);
    return out;
  }

 private:
  std::map<FrameId, Alone> aloneOf(const std::vector<GeoSegment>& segments,
                                   const std::vector<GnssQuality>& quality) const {
    std::map<FrameId, Alone> alone;
    for (const GeoSegment& segment : segments)
      for (const auto& pose : segment.poses) {
        Alone a;
        a.T_world_cam = pose.T_world_cam;
        a.scale = segment.georeferenced ? segment.scale : 1;
        a.scale_sigma = segment.scale_sigma;
        const double estimated = pose.covariance.topLeftCorner<2, 2>().trace() / 2;
        const Eigen::Vector3d& noise = quality[segment.id.uav].sigma_m;
        // Two receivers disagree by more than either one's noise tells.
        a.sigma_m = std::sqrt(estimated) + std::max(2.0, noise.head<2>().norm());
        a.georeferenced = segment.georeferenced;
        a.segment = segment.id.segment;
        alone[pose.frame] = a;
      }
    return alone;
  }

  PairViews viewsOf(const std::map<FrameId, Alone>& alone) const {
    PairViews views;
    for (const auto& [id, a] : alone)
      views[id] = {&graph_.photo(id), a.T_world_cam, a.scale, a.scale_sigma, a.georeferenced};
    return views;
  }

  /// Fixes with the noise that their receiver shows, where that is above what it tags.
  std::map<FrameId, GnssPosition> weighedFixes(const std::vector<GnssQuality>& quality) const {
    std::map<FrameId, GnssPosition> fixes = fixes_;
    for (auto& [id, fix] : fixes) fix.sigma_m = fix.sigma_m.cwiseMax(quality[id.uav].sigma_m);
    return fixes;
  }

  /// Between solves of the whole: photos that have come since.
  void extend(const std::vector<GeoSegment>& segments, const std::vector<GnssQuality>& quality) {
    std::vector<FrameId> fresh;
    for (const auto& [id, photo] : graph_.photos())
      if (map_.table.poses.count(id) == 0) fresh.push_back(id);
    matchNeighbours();
    const std::vector<FrameId> carried = carryOn(graph_, fresh, map_);
    std::map<FrameId, Located> located;
    for (const auto& [id, scale] : map_.scales)
      located[id] = {map_.table.poses.at(id).T_world_cam, scale};
    const std::vector<Footprint> all = footprints(aloneOf(segments, quality), located);
    CandidateIndex index(options_.candidates);
    index.rebuild(all);
    std::vector<MatchGraph::Pair> pairs;
    for (const Footprint& footprint : all)
      if (std::binary_search(carried.begin(), carried.end(), footprint.frame))
        for (const CandidatePair& c : index.query(footprint)) pairs.emplace_back(c.a, c.b);
    graph_.match(pairs);
    if (options_.method == "joint") adjustAround(graph_, carried, options_.joint, map_);
    map_.table.version = ++version_;
  }

  void matchNeighbours() {
    std::vector<MatchGraph::Pair> pairs;
    for (const auto& [id, photo] : graph_.photos())
      for (std::uint32_t step = 1; step <= kSequenceNeighbours; ++step) {
        const FrameId next{id.uav, id.index + step};
        if (graph_.photos().count(next) > 0) pairs.emplace_back(id, next);
      }
    graph_.match(pairs);
  }

  /// Whether any became connected that was not before.
  bool matchCandidates(const std::vector<Footprint>& footprints) {
    std::vector<MatchGraph::Pair> pairs;
    for (const CandidatePair& c : findCandidates(footprints, options_.candidates))
      pairs.emplace_back(c.a, c.b);
    return graph_.match(pairs);
  }

  /// Photos that are `located` in the map lie better than GNSS alone can tell.
  std::vector<Footprint> footprints(const std::map<FrameId, Alone>& alone,
                                    const std::map<FrameId, Located>& located = {}) const {
    std::vector<Footprint> out;
    for (const auto& [id, a] : alone) {
      const CameraModel& camera = graph_.photo(id).camera;
      const auto in_map = located.find(id);
      const double scale = in_map != located.end() ? in_map->second.scale : a.scale;
      const double depth = medianDepth(id) * scale;
      if (depth > 0 && in_map != located.end())
        out.push_back(predictFootprint(id, a.segment, in_map->second.T_world_cam, camera, depth,
                                       0.05 * depth));
      else if (depth > 0 && a.georeferenced)
        out.push_back(predictFootprint(id, a.segment, a.T_world_cam, camera, depth, a.sigma_m));
      else
        out.push_back(unlocatedFootprint(id, a.segment));
    }
    return out;
  }

  static std::map<FrameId, Located> locatedBy(const Placement& placement) {
    std::map<FrameId, Located> located;
    for (const auto& [id, placed] : placement.photos)
      if (placed.component == 0) located[id] = {placed.T_world_cam, placed.scale};
    return located;
  }

  double medianDepth(FrameId id) const { return median_depth_.at(id); }

  void adjust(const Placement& placement, const std::vector<GnssQuality>& quality, bool draft,
              const PhotoSource& source, Alignment& out) {
    const std::vector<Track> tracks = buildTracks(graph_);
    const std::map<FrameId, GnssPosition> fixes = weighedFixes(quality);
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
        const double depth = medianDepth(id) * placed.scale;
        if (depth > 0) depths.push_back(depth);
      }
      if (problem.photos.size() < 2 || depths.empty()) continue;
      std::nth_element(depths.begin(), depths.begin() + static_cast<long>(depths.size() / 2),
                       depths.end());
      problem.median_depth_m = depths[depths.size() / 2];
      JointSolution solution = adjustJointly(graph_, tracks, problem, options_.joint);
      for (const auto& [id, T] : solution.T_world_cam) {
        const auto covariance = solution.covariance.find(id);
        out.table.poses[id] = {T, {}, component, 0, 0, 0};
        if (covariance != solution.covariance.end())
          out.table.poses[id].covariance = covariance->second;
        // The first, largest component that a UAV is in calibrates its camera.
        if (calibrated.insert(id.uav).second) {
          out.table.cameras[id.uav] = solution.cameras[id.uav];
          out.table.cameras[id.uav].version = version_;
        }
      }
      for (const auto& [uav, bias] : solution.bias_m) out.gnss_bias_m.emplace(uav, bias);
      if (component == 0) out.reprojection_rms_px = solution.reprojection_rms_px;
      std::move(solution.points.begin(), solution.points.end(), std::back_inserter(out.points));
    }
  }

  /// Points of the map from poses that stay as they are placed.
  void keepRigid(const Placement& placement, Alignment& out) const {
    const std::vector<Track> tracks = buildTracks(graph_);
    for (int component = 0; component < placement.components; ++component) {
      std::map<FrameId, PosedPhoto> photos;
      for (const auto& [id, placed] : placement.photos)
        if (placed.component == component)
          photos[id] = {placed.T_world_cam, graph_.photo(id).camera};
      std::vector<SparsePoint> points =
          triangulateTracks(graph_, tracks, photos, kRigidThresholdPx);
      if (component == 0) out.reprojection_rms_px = reprojectionRmsPx(graph_, points, photos);
      std::move(points.begin(), points.end(), std::back_inserter(out.points));
    }
  }

  /// Poses of photos that no adjustment held, and the range of depths of every photo.
  void addPoses(const Placement& placement, Alignment& out) const {
    for (const auto& [id, placed] : placement.photos)
      if (out.table.poses.count(id) == 0)
        out.table.poses[id] = {placed.T_world_cam, {}, placed.component, 0, 0, 0};
    setDepths(out.points, out.table);
  }

  void addRelativePoses(const PairViews& views, const Placement& placement,
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
      if (a.uav == b.uav || out.table.poses.count(a) == 0 || out.table.poses.count(b) == 0)
        continue;
      out.relative_poses.push_back(relativePoseInMap(o, views, out.table, scaleOf(a), scaleOf(b)));
    }
  }

  const AlignOptions options_;
  const std::uint16_t center_;
  MatchGraph graph_;
  std::map<FrameId, GnssPosition> fixes_;
  std::map<FrameId, double> median_depth_;  ///< of each photo's landmarks, VO units
  GrowingMap map_;
  double solved_photos_ = 0;  ///< in the graph when the whole was last solved
  std::uint32_t version_ = 0;
};

Aligner::Aligner(const AlignOptions& options, std::uint16_t center)
    : state_(std::make_unique<State>(options, center)) {}
Aligner::~Aligner() = default;
void Aligner::push(const GeoKeyframe& keyframe) { state_->push(keyframe); }
const PoseTable& Aligner::update(const std::vector<GeoSegment>& segments,
                                 const std::vector<GnssQuality>& quality,
                                 const std::vector<CameraModel>& cameras) {
  return state_->update(segments, quality, cameras);
}
std::optional<Sim3> Aligner::similarity(FrameId photo, int segment) const {
  return state_->similarity(photo, segment);
}
Alignment Aligner::solve(const std::vector<GeoSegment>& segments,
                         const std::vector<GnssQuality>& quality,
                         const std::vector<CameraModel>& cameras, const PhotoSource& source) {
  return state_->solve(segments, quality, cameras, false, source);
}

}  // namespace cf
