// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/geo_txt.h"

#include <fmt/format.h>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/formats/text_lines.h"
#include "cf/geodesy/crs.h"

namespace cf {
namespace {

Result<GeoEntry> entryFrom(const Crs& crs, const std::vector<std::string>& words) {
  if (words.size() != 4 && words.size() != 6 && words.size() != 7 && words.size() != 9)
    return Failure{"bad_line", "expected 'name x y z [yaw pitch roll] [sigma_h sigma_v]'"};
  std::vector<double> v;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto value = numberFrom(words[i]);
    if (!value) return Failure{"bad_line", "'" + words[i] + "' is not a number"};
    v.push_back(*value);
  }
  const Result<Geodetic> position = geodeticFrom(crs, {v[0], v[1], v[2]});
  if (!position) return position.failure();
  GeoEntry entry;
  entry.name = words[0];
  entry.position = *position;
  if (v.size() >= 6) entry.attitude = GimbalAttitude{v[3], v[4], v[5]};
  if (v.size() == 5 || v.size() == 8) {
    const Eigen::Vector2d sigma(v[v.size() - 2], v[v.size() - 1]);
    if (sigma.minCoeff() <= 0) return Failure{"bad_line", "the sigmas must be above zero"};
    entry.sigma_m = sigma;
  }
  return entry;
}

}  // namespace

GeoFile readGeoTxt(const std::filesystem::path& file) {
  GeoFile geo;
  std::optional<Crs> crs;
  for (const TextLine& line : readTextLines(file)) {
    const auto fail = [&](const Failure& failure) {
      throw UsageError(fmt::format("{}:{}: {}", file.string(), line.number, failure.detail));
    };
    if (!crs) {
      const Result<Crs> named = crsFromText(line.text);
      if (!named) fail(named.failure());
      crs = *named;
      geo.datum = crs->datum;
      continue;
    }
    Result<GeoEntry> entry = entryFrom(*crs, wordsOf(line.text));
    if (!entry) fail(entry.failure());
    geo.entries.push_back(std::move(*entry));
  }
  if (geo.entries.empty())
    throw UsageError(fmt::format("{} names no photo: after the CRS, lines 'name x y z' are needed",
                                 file.string()));
  return geo;
}

}  // namespace cf
