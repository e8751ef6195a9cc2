// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <map>

#include "cf/base/error.h"
#include "flight.h"

namespace cf {
namespace {

/// Whether a path ends with these whole components.
bool endsWith(const std::filesystem::path& path, const std::filesystem::path& end) {
  auto p = path.end(), e = end.end();
  while (e != end.begin()) {
    if (p == path.begin()) return false;
    if (*--p != *--e) return false;
  }
  return true;
}

void apply(const GeoEntry& entry, HeightDatum datum, const ImportOptions& options,
           ImportedPhoto& photo) {
  GnssFix fix;
  fix.time = photo.frame.time;
  fix.latitude_deg = entry.position.latitude_deg;
  fix.longitude_deg = entry.position.longitude_deg;
  fix.height_m = entry.position.height_m;
  fix.datum = datum;
  fix.sigma_enu_m =
      entry.sigma_m ? Eigen::Vector3d(entry.sigma_m->x(), entry.sigma_m->x(), entry.sigma_m->y())
                    : defaultSigma(options);
  photo.fix = fix;
  if (entry.attitude) photo.frame.attitude = entry.attitude;
}

}  // namespace

void applyGeo(const GeoFile& geo, const ImportOptions& options, std::vector<Flight>& flights,
              std::vector<std::string>& warnings) {
  std::multimap<std::string, ImportedPhoto*> by_name;
  std::size_t photos = 0;
  for (Flight& flight : flights)
    for (ImportedPhoto& photo : flight.photos) {
      by_name.emplace(photo.source.filename().string(), &photo);
      ++photos;
    }
  std::size_t unknown = 0, placed = 0;
  std::string unknown_name;
  for (const GeoEntry& entry : geo.entries) {
    const std::filesystem::path name(entry.name);
    const auto [begin, end] = by_name.equal_range(name.filename().string());
    std::vector<ImportedPhoto*> hits;
    for (auto it = begin; it != end; ++it)
      if (endsWith(it->second->source, name)) hits.push_back(it->second);
    if (hits.size() > 1)
      throw UsageError(fmt::format("{}: {} fits {} photos: put its folder before the name",
                                   options.geo.string(), entry.name, hits.size()));
    if (hits.empty()) {
      if (unknown++ == 0) unknown_name = entry.name;
      continue;
    }
    apply(entry, geo.datum, options, *hits[0]);
    ++placed;
  }
  if (placed == 0)
    throw UsageError(fmt::format("{} names none of the photos ({} is not there)",
                                 options.geo.string(), unknown_name));
  if (unknown != 0)
    warnings.push_back(fmt::format("{}: {} names fit no photo, the first {}", options.geo.string(),
                                   unknown, unknown_name));
  if (placed < photos)
    warnings.push_back(fmt::format("{}: {} photos are not in it and keep their own positions",
                                   options.geo.string(), photos - placed));
}

}  // namespace cf
