// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/camera_ini.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/formats/text_lines.h"

namespace cf {
namespace {

/// Keys and values of one section; comments start with ; or #.
std::map<std::string, double> readSection(const std::filesystem::path& file,
                                          const std::string& wanted) {
  std::map<std::string, double> values;
  std::string section;
  for (const auto& [number, text] : readTextLines(file)) {
    const std::string line = trimmed(text.substr(0, text.find(';')));
    if (line.empty()) continue;
    if (line.front() == '[') {
      section = line;
      continue;
    }
    if (section != "[" + wanted + "]") continue;
    const std::size_t equals = line.find('=');
    const std::string key = trimmed(line.substr(0, equals));
    const auto value =
        equals == std::string::npos ? std::nullopt : numberFrom(line.substr(equals + 1));
    if (!value)
      throw UsageError(
          fmt::format("{}:{}: '{}' should be 'key = number'", file.string(), number, line));
    if (!values.emplace(key, *value).second)
      throw UsageError(fmt::format("{}:{}: {} is given twice", file.string(), number, key));
  }
  return values;
}

}  // namespace

CameraModel readCameraIni(const std::filesystem::path& file, const std::string& section) {
  std::map<std::string, double> values = readSection(file, section);
  const auto take = [&values](const char* key, double otherwise) {
    const auto node = values.extract(key);
    return node.empty() ? otherwise : node.mapped();
  };
  const auto need = [&](const char* key) {
    const double value = take(key, 0);
    constexpr double kMost = 1e6;
    if (!(value > 0 && value < kMost))
      throw UsageError(fmt::format("{}: [{}] needs {} in pixels, above 0 and below 1000000",
                                   file.string(), section, key));
    return value;
  };
  const auto needWhole = [&](const char* key) {
    const double value = need(key);
    if (value != std::floor(value))
      throw UsageError(fmt::format("{}: [{}] {} = {} is not a whole number of pixels",
                                   file.string(), section, key, value));
    return static_cast<int>(value);
  };
  CameraModel camera;
  camera.width = needWhole("width");
  camera.height = needWhole("height");
  camera.fx = need("fx");
  camera.fy = take("fy", camera.fx);
  camera.cx = take("cx", (camera.width - 1) / 2.0);
  camera.cy = take("cy", (camera.height - 1) / 2.0);
  camera.k1 = take("k1", 0);
  camera.k2 = take("k2", 0);
  camera.p1 = take("p1", 0);
  camera.p2 = take("p2", 0);
  camera.k3 = take("k3", 0);
  camera.focal_sigma = take("focal_sigma", 0);
  camera.k1_sigma = take("k1_sigma", 0);
  camera.k2_sigma = take("k2_sigma", 0);
  if (!(camera.fy > 0) || camera.focal_sigma < 0 || camera.k1_sigma < 0 || camera.k2_sigma < 0)
    throw UsageError(
        fmt::format("{}: [{}] fy must be above 0, and no sigma below 0", file.string(), section));
  if (!values.empty())
    throw UsageError(
        fmt::format("{}: [{}] has no key {}: known are width height fx fy cx cy "
                    "k1 k2 p1 p2 k3 focal_sigma k1_sigma k2_sigma",
                    file.string(), section, values.begin()->first));
  return camera;
}

}  // namespace cf
