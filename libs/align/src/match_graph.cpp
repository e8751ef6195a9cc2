// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/match_graph.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "cf/features/match.h"
#include "cf/geometry/triangulation.h"
#include "cf/geometry/two_view.h"

namespace cf {

void MatchGraph::add(std::shared_ptr<const Keyframe> keyframe) {
  const FrameId id = keyframe->id;
  normalized_[id] = normalizedPoints(*keyframe->features, keyframe->camera);
  thresholds_[id] = options_.threshold_px * keyframe->features->pixel_size / keyframe->camera.fx;
  photos_[id] = std::move(keyframe);
}

bool MatchGraph::match(const std::vector<Pair>& pairs) {
  std::vector<Pair> todo;
  for (const Pair& pair : pairs)
    if (tried_.insert(pair).second) todo.push_back(pair);
  std::vector<std::vector<FeatureMatch>> results(todo.size());
  tbb::parallel_for(std::size_t{0}, todo.size(), [&](std::size_t k) {
    const auto& [ia, ib] = todo[k];
    const auto raw =
        matchFeatures(*photo(ia).features, *photo(ib).features, MatchOptions{options_.ratio});
    if (static_cast<int>(raw.size()) < options_.min_inliers) return;
    std::vector<Eigen::Vector2d> a, b;
    for (const FeatureMatch& m : raw) {
      a.push_back(normalized_.at(ia)[static_cast<std::size_t>(m.a)]);
      b.push_back(normalized_.at(ib)[static_cast<std::size_t>(m.b)]);
    }
    const auto keep = consistentMatches(a, b, std::max(threshold(ia), threshold(ib)));
    for (std::size_t i = 0; i < raw.size(); ++i)
      if (keep[i]) results[k].push_back(raw[i]);
  });
  bool connected = false;
  for (std::size_t k = 0; k < todo.size(); ++k)
    if (static_cast<int>(results[k].size()) >= options_.min_inliers) {
      pairs_[todo[k]] = std::move(results[k]);
      connected = true;
    }
  return connected;
}

void MatchGraph::learn(const MatchGraph& copy) {
  tried_.insert(copy.tried_.begin(), copy.tried_.end());
  pairs_.insert(copy.pairs_.begin(), copy.pairs_.end());
}

std::vector<Track> buildTracks(const MatchGraph& graph) {
  std::set<FrameId> photos;
  for (const auto& [id, keyframe] : graph.photos()) photos.insert(id);
  return buildTracks(graph, photos);
}

std::vector<Track> buildTracks(const MatchGraph& graph, const std::set<FrameId>& photos) {
  // Features numbered photo after photo; union-find with the smaller root winning.
  std::map<FrameId, int> first;
  int total = 0;
  for (const FrameId id : photos) {
    first[id] = total;
    total += static_cast<int>(graph.photo(id).features->size());
  }
  std::vector<int> parent(static_cast<std::size_t>(total));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  for (const auto& [pair, matches] : graph.pairs()) {
    const auto a = first.find(pair.first), b = first.find(pair.second);
    if (a == first.end() || b == first.end()) continue;
    for (const FeatureMatch& m : matches) {
      const int ra = root(a->second + m.a), rb = root(b->second + m.b);
      if (ra != rb) parent[static_cast<std::size_t>(std::max(ra, rb))] = std::min(ra, rb);
    }
  }
  std::map<int, Track> components;
  for (const FrameId id : photos)
    for (int f = 0; f < static_cast<int>(graph.photo(id).features->size()); ++f)
      components[root(first.at(id) + f)].push_back({id, f});
  std::vector<Track> tracks;
  for (auto& [key, track] : components) {
    if (track.size() < 2) continue;
    std::map<FrameId, int> count;
    for (const auto& o : track) ++count[o.frame];
    track.erase(std::remove_if(track.begin(), track.end(),
                               [&](const auto& o) { return count[o.frame] > 1; }),
                track.end());
    if (track.size() >= 2) tracks.push_back(std::move(track));
  }
  return tracks;
}

}  // namespace cf
