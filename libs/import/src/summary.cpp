// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "cf/formats/atomic_file.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

void describeFixes(const Flight& flight, ImportedUav& uav) {
  std::map<HeightDatum, int> datums;
  std::vector<double> axes[3];
  for (const ImportedPhoto& photo : flight.photos) {
    if (!photo.fix) continue;
    ++uav.fixes;
    ++datums[photo.fix->datum];
    for (int a = 0; a < 3; ++a) axes[a].push_back(photo.fix->sigma_enu_m[a]);
  }
  int most = 0;
  for (const auto& [datum, count] : datums)
    if (count > most) {
      most = count;
      uav.datum = datum;
    }
  for (int a = 0; a < 3; ++a) {
    if (axes[a].empty()) continue;
    const auto middle = axes[a].begin() + static_cast<std::ptrdiff_t>(axes[a].size() / 2);
    std::nth_element(axes[a].begin(), middle, axes[a].end());
    uav.sigma_enu_m[a] = *middle;
  }
}

}  // namespace

ImportedUav describe(const Flight& flight, const fs::path& rawlog) {
  ImportedUav uav;
  uav.name = flight.name;
  uav.rawlog = rawlog;
  uav.photos = flight.photos.size();
  uav.time_source = flight.time_source;
  uav.first = flight.photos.front().frame.time;
  uav.last = flight.photos.back().frame.time;
  std::map<std::tuple<int, int, double>, int> cameras;
  int most = 0;
  for (const ImportedPhoto& photo : flight.photos) {
    if (!photo.readable) ++uav.unreadable;
    const CameraModel& c = photo.frame.camera;
    const int count = ++cameras[{c.width, c.height, c.fx}];
    if (count <= most) continue;
    most = count;
    uav.camera = c;
    uav.focal_source = photo.focal_source;
  }
  describeFixes(flight, uav);
  return uav;
}

void writeConfig(const std::vector<fs::path>& rawlogs, double follow_s, const fs::path& file) {
  std::string text = "; Written by cf-import. Every other setting has a default.\n";
  for (const fs::path& rawlog : rawlogs)
    text += fmt::format("\n[uav.{}]\nrawlog = {}\n", rawlog.stem().string(),
                        rawlog.filename().string());
  if (follow_s > 0) text += fmt::format("\n[playback]\nfollow_s = {}\n", follow_s);
  writeFileAtomically(file, text);
}

}  // namespace cf
