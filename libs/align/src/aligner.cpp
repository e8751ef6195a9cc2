// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/aligner.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <future>
#include <set>
#include <utility>

#include "map_extension.h"
#include "map_solver.h"
#include "relative_poses.h"

namespace cf {

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
      : options_(options), solver_(options, center) {}

  void push(const GeoKeyframe& keyframe) { solver_.push(keyframe); }

  const PoseTable& update(const UavKnowledge& known) {
    if (draft_.valid()) take(draft_.get());
    const bool first = map_.table.poses.empty();
    const bool joins = canJoin(known.segments);
    for (const GeoSegment& segment : known.segments)
      if (segment.georeferenced) joined_.insert(segment.id.uav);
    const double photos = static_cast<double>(solver_.graph().photos().size());
    if (joins || photos >= options_.growth * solved_photos_) {
      solved_photos_ = photos;
      startDraft(known);
      if (joins || first) take(draft_.get());
    }
    extend(known);
    return map_.table;
  }

  bool canJoin(const std::vector<GeoSegment>& segments) const {
    return std::any_of(segments.begin(), segments.end(), [&](const GeoSegment& segment) {
      return segment.georeferenced && joined_.count(segment.id.uav) == 0;
    });
  }

  std::optional<Sim3> similarity(FrameId photo, int segment) const {
    return similarityInMap(solver_.graph(), map_, photo, segment);
  }

  Alignment solve(const UavKnowledge& known, const PhotoSource& source) {
    if (draft_.valid()) solver_.learn(draft_.get().solver);
    return solver_.solve(known, false, ++version_, source);
  }

 private:
  /// A solve of the whole, and what it was solved by.
  struct Draft {
    MapSolver solver;
    Alignment alignment;
  };

  /// Beside the photos that go on coming, where there is a thread for it: it takes effect at the
  /// next update, however long it takes.
  void startDraft(const UavKnowledge& known) {
    using Control = tbb::global_control;
    const bool alone = Control::active_value(Control::max_allowed_parallelism) == 1;
    draft_ = std::async(alone ? std::launch::deferred : std::launch::async,
                        [solver = solver_, known, version = version_ + 1]() mutable {
                          Alignment alignment = solver.solve(known, true, version, {});
                          return Draft{std::move(solver), std::move(alignment)};
                        });
  }

  void take(Draft draft) {
    solver_.learn(draft.solver);
    map_.scales = scalesInMap(solver_.graph(), draft.alignment.table, draft.alignment.points);
    map_.table = std::move(draft.alignment.table);
  }

  /// Photos that the map has not are carried on, matched, and adjusted with those around them.
  void extend(const UavKnowledge& known) {
    std::vector<FrameId> fresh;
    for (const auto& [id, photo] : solver_.graph().photos())
      if (map_.table.poses.count(id) == 0) fresh.push_back(id);
    solver_.matchNeighbours();
    const std::vector<FrameId> carried = carryOn(solver_.graph(), fresh, map_);
    std::map<FrameId, Located> located;
    for (const auto& [id, scale] : map_.scales)
      located[id] = {map_.table.poses.at(id).T_world_cam, scale};
    const std::vector<Footprint> all = solver_.footprints(known, located);
    CandidateIndex index(options_.candidates);
    index.rebuild(all);
    std::vector<MatchGraph::Pair> pairs;
    for (const Footprint& footprint : all)
      if (std::binary_search(carried.begin(), carried.end(), footprint.frame))
        for (const CandidatePair& c : index.query(footprint)) pairs.emplace_back(c.a, c.b);
    solver_.match(pairs);
    if (options_.method == "joint") adjustAround(solver_.graph(), carried, options_.joint, map_);
    map_.table.version = ++version_;
  }

  const AlignOptions options_;
  MapSolver solver_;
  GrowingMap map_;
  std::future<Draft> draft_;        ///< under way
  std::set<std::uint16_t> joined_;  ///< UAVs that had a georeference in a draft
  double solved_photos_ = 0;        ///< in the graph when the last draft was started
  std::uint32_t version_ = 0;
};

Aligner::Aligner(const AlignOptions& options, std::uint16_t center)
    : state_(std::make_unique<State>(options, center)) {}
Aligner::~Aligner() = default;
void Aligner::push(const GeoKeyframe& keyframe) { state_->push(keyframe); }
bool Aligner::canJoin(const std::vector<GeoSegment>& of_uav) const {
  return state_->canJoin(of_uav);
}
const PoseTable& Aligner::update(const std::vector<GeoSegment>& segments,
                                 const std::vector<GnssQuality>& quality,
                                 const std::vector<CameraModel>& cameras) {
  return state_->update({segments, quality, cameras});
}
std::optional<Sim3> Aligner::similarity(FrameId photo, int segment) const {
  return state_->similarity(photo, segment);
}
Alignment Aligner::solve(const std::vector<GeoSegment>& segments,
                         const std::vector<GnssQuality>& quality,
                         const std::vector<CameraModel>& cameras, const PhotoSource& source) {
  return state_->solve({segments, quality, cameras}, source);
}

}  // namespace cf
