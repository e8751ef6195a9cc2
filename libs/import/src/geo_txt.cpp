// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/geo_txt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "cf/base/error.h"
#include "cf/geodesy/utm.h"
#include "text.h"

namespace cf {
namespace {

struct Crs {
  std::optional<UtmZone> utm;  // none: longitude and latitude
  HeightDatum datum = HeightDatum::kUnknown;
};

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::optional<Crs> crsFrom(const std::string& line) {
  const std::vector<std::string> words = wordsOf(upper(line));
  if (words.size() == 3 && words[0] == "WGS84" && words[1] == "UTM") {
    const Result<UtmZone> zone = utmZoneFromText(words[2]);
    if (zone) return Crs{*zone, HeightDatum::kUnknown};
  }
  if (words.size() != 1 || words[0].rfind("EPSG:", 0) != 0) return std::nullopt;
  const auto code = numberFrom(words[0].substr(5));
  if (!code) return std::nullopt;
  if (*code == 4326) return Crs{};
  if (*code == 4979) return Crs{std::nullopt, HeightDatum::kEllipsoid};
  if (std::abs(*code) > 1e6 || *code != std::floor(*code)) return std::nullopt;
  const Result<UtmZone> zone = utmZoneFromEpsg(static_cast<int>(*code));
  if (!zone) return std::nullopt;
  return Crs{*zone, HeightDatum::kUnknown};
}

Result<Geodetic> positionFrom(const Crs& crs, double x, double y, double z) {
  if (crs.utm) return utmToGeodetic(*crs.utm, x, y, z);
  if (std::abs(y) > 90 || std::abs(x) > 180)
    return Failure{"not_a_place",
                   fmt::format("longitude {} and latitude {} (in this order) are no place", x, y)};
  return Geodetic{y, x, z};
}

Result<GeoEntry> entryFrom(const Crs& crs, const std::vector<std::string>& words) {
  if (words.size() != 4 && words.size() != 6 && words.size() != 7 && words.size() != 9)
    return Failure{"bad_line", "expected 'name x y z [yaw pitch roll] [sigma_h sigma_v]'"};
  std::vector<double> v;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto value = numberFrom(words[i]);
    if (!value) return Failure{"bad_line", "'" + words[i] + "' is not a number"};
    v.push_back(*value);
  }
  const Result<Geodetic> position = positionFrom(crs, v[0], v[1], v[2]);
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
  std::ifstream in(file);
  if (!in) throw UsageError(fmt::format("{} cannot be read: is it there?", file.string()));
  GeoFile geo;
  std::optional<Crs> crs;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";
    if (number == 1 && line.rfind(kByteOrderMark, 0) == 0) line.erase(0, 3);
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    if (!crs) {
      crs = crsFrom(line);
      if (!crs)
        throw UsageError(
            fmt::format("{}:{}: '{}' is no known CRS: use EPSG:4326, EPSG:4979, the "
                        "code of a WGS84 UTM zone, or 'WGS84 UTM 17N'",
                        file.string(), number, line));
      geo.datum = crs->datum;
      continue;
    }
    Result<GeoEntry> entry = entryFrom(*crs, wordsOf(line));
    if (!entry)
      throw UsageError(fmt::format("{}:{}: {}", file.string(), number, entry.failure().detail));
    geo.entries.push_back(std::move(*entry));
  }
  if (geo.entries.empty())
    throw UsageError(fmt::format("{} names no photo: after the CRS, lines 'name x y z' are needed",
                                 file.string()));
  return geo;
}

}  // namespace cf
