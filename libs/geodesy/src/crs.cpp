// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geodesy/crs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <vector>

#include "cf/base/text.h"

namespace cf {
namespace {

using Words = std::vector<std::string>;

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::optional<Crs> fromZone(const Result<UtmZone>& zone) {
  if (!zone) return std::nullopt;
  return Crs{*zone, HeightDatum::kUnknown};
}

std::optional<Crs> fromEpsg(const std::string& digits) {
  const auto code = numberFrom(digits);
  if (!code || std::abs(*code) > 1e6 || *code != std::floor(*code)) return std::nullopt;
  if (*code == 4326) return Crs{};
  if (*code == 4979) return Crs{std::nullopt, HeightDatum::kEllipsoid};
  return fromZone(utmZoneFromEpsg(static_cast<int>(*code)));
}

/// Parameters of a PROJ string; none where a word is not one.
std::optional<std::map<std::string, std::string>> projParameters(const Words& words) {
  std::map<std::string, std::string> parameters;
  for (const std::string& word : words) {
    if (word.size() < 2 || word[0] != '+') return std::nullopt;
    const std::size_t equals = std::min(word.find('='), word.size());
    parameters[word.substr(1, equals - 1)] = word.substr(std::min(equals + 1, word.size()));
  }
  return parameters;
}

std::optional<Crs> fromProj(const Words& words) {
  auto parameters = projParameters(words);
  if (!parameters) return std::nullopt;
  const auto take = [&](const char* key, const std::string& otherwise) {
    const auto node = parameters->extract(key);
    return node.empty() ? otherwise : node.mapped();
  };
  const std::string projection = take("PROJ", "");
  if (take("DATUM", "WGS84") != "WGS84" || take("ELLPS", "WGS84") != "WGS84") return std::nullopt;
  take("NO_DEFS", "");
  take("TYPE", "");
  std::optional<Crs> crs;
  if (projection == "LONGLAT" || projection == "LATLONG") {
    crs = Crs{};
  } else if (projection == "UTM") {
    const std::string zone = take("ZONE", "");
    const bool south = parameters->erase("SOUTH") > 0;
    if (take("UNITS", "M") == "M") crs = fromZone(utmZoneFromText(zone + (south ? "S" : "N")));
  }
  // What is left (a geoid, another unit, a shift of datum) would change the meaning.
  return parameters->empty() ? crs : std::nullopt;
}

}  // namespace

Result<Crs> crsFromText(const std::string& text) {
  const Words words = wordsOf(upper(text));
  std::optional<Crs> crs;
  if (words.size() == 3 && words[0] == "WGS84" && words[1] == "UTM")
    crs = fromZone(utmZoneFromText(words[2]));
  else if (words.size() == 1 && words[0].rfind("EPSG:", 0) == 0)
    crs = fromEpsg(words[0].substr(5));
  else if (!words.empty() && words[0][0] == '+')
    crs = fromProj(words);
  if (crs) return *crs;
  return Failure{"unknown_crs",
                 fmt::format("'{}' is no known CRS: use EPSG:4326, EPSG:4979, the code of a WGS84 "
                             "UTM zone, 'WGS84 UTM 17N' or '+proj=utm +zone=17 +datum=WGS84'",
                             text)};
}

Result<Geodetic> geodeticFrom(const Crs& crs, const Eigen::Vector3d& p) {
  if (crs.utm) return utmToGeodetic(*crs.utm, p.x(), p.y(), p.z());
  if (std::abs(p.y()) > 90 || std::abs(p.x()) > 180)
    return Failure{
        "not_a_place",
        fmt::format("longitude {} and latitude {} (in this order) are no place", p.x(), p.y())};
  return Geodetic{p.y(), p.x(), p.z()};
}

}  // namespace cf
