// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "track_parts.h"

#include <algorithm>
#include <map>
#include <utility>

namespace cf {
namespace {

using ChainId = std::pair<std::uint16_t, int>;  ///< UAV and chain

ChainId chainOf(const MatchGraph& graph, const SparseObservation& o) {
  const std::vector<int>& chain = graph.photo(o.frame).chain;
  const auto f = static_cast<std::size_t>(o.feature);
  return {o.frame.uav, f < chain.size() ? chain[f] : -1};
}

}  // namespace

TrackParts takeApart(const MatchGraph& graph, const std::vector<Track>& tracks) {
  TrackParts parts;
  for (const Track& track : tracks) {
    std::map<ChainId, Track> chains;
    Track link, detections;
    for (const SparseObservation& o : track) {
      const ChainId chain = chainOf(graph, o);
      if (chain.second < 0) {
        link.push_back(o);
        detections.push_back(o);
      } else
        chains[chain].push_back(o);
    }
    const bool linked = chains.size() + link.size() > 1;
    for (auto& [id, chain] : chains) {
      if (linked) {
        link.push_back(chain.front());
        detections.push_back(chain.front());
        if (chain.size() > 1) link.push_back(chain.back());
      }
      if (chain.size() > 1) parts.chains.push_back(std::move(chain));
    }
    if (!linked) continue;
    parts.links.push_back(std::move(link));
    parts.detections.push_back(std::move(detections));
  }
  return parts;
}

int sharedDetection(const MatchGraph& graph, const Track& link, const SparseObservation& o) {
  const ChainId chain = chainOf(graph, o);
  if (chain.second < 0) return 1;
  return static_cast<int>(std::count_if(link.begin(), link.end(),
                                        [&](const auto& x) { return chainOf(graph, x) == chain; }));
}

}  // namespace cf
