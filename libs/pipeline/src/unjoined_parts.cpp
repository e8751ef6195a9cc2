// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "unjoined_parts.h"

#include <fmt/format.h>

#include <map>
#include <utility>

namespace cf {
namespace {

constexpr std::size_t kFew = 3;

std::string sentence(const UavRecord& uav, const std::vector<const PhotoRecord*>& part,
                     bool placed) {
  const bool whole = part.size() == uav.photos.size();
  return fmt::format(
      "{}: no match joins {} {} photo{} ({} to {}) to the rest: {}; fly with a strip that shares "
      "ground with the other photos, at a similar height and time, and see images/{}.csv",
      uav.name, whole ? "its" : "a part of", part.size(), part.size() == 1 ? "" : "s",
      part.front()->name, part.back()->name,
      placed ? "only GNSS places them, to metres" : "they are left out of the map", uav.name);
}

}  // namespace

std::vector<std::string> unjoinedParts(const std::vector<UavRecord>& uavs, const PoseTable& table) {
  std::vector<std::string> sentences;
  for (std::size_t u = 0; u < uavs.size(); ++u) {
    const UavRecord& uav = uavs[u];
    // Of what GNSS places by component, of what nothing does by segment.
    std::map<std::pair<bool, int>, std::vector<const PhotoRecord*>> parts;
    for (std::size_t i = 0; i < uav.photos.size(); ++i) {
      const PhotoRecord& photo = uav.photos[i];
      const auto entry =
          table.poses.find({static_cast<std::uint16_t>(u), static_cast<std::uint32_t>(i)});
      if (entry == table.poses.end()) {
        if (photo.status == PhotoStatus::kUnjoined) parts[{false, photo.segment}].push_back(&photo);
      } else if (entry->second.component != 0) {
        parts[{true, entry->second.component}].push_back(&photo);
      }
    }
    for (const auto& [key, part] : parts)
      if (part.size() > kFew || part.size() == uav.photos.size())
        sentences.push_back(sentence(uav, part, key.first));
  }
  return sentences;
}

}  // namespace cf
