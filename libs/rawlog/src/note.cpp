// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "note.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <vector>

namespace cf {
namespace {

constexpr const char* kFirstLine = "clusterfusion note 1";
// Beyond these a value is damaged.
constexpr double kMost = 1e6, kLeastSigma_m = 1e-5;

/// All numbers of a text, or none if any part of it is not a finite number.
std::vector<double> numbers(const std::string& text) {
  std::vector<double> values;
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  for (double value = 0; in >> value;) {
    if (!std::isfinite(value)) return {};
    values.push_back(value);
  }
  if (!in.eof()) return {};
  return values;
}

std::optional<double> number(const std::string& text, double min, double max) {
  const std::vector<double> values = numbers(text);
  if (values.size() != 1 || values[0] < min || values[0] > max) return std::nullopt;
  return values[0];
}

std::optional<HeightDatum> datumFromText(const std::string& text) {
  for (const HeightDatum datum :
       {HeightDatum::kUnknown, HeightDatum::kEllipsoid, HeightDatum::kMsl})
    if (text == name(datum)) return datum;
  return std::nullopt;
}

void set(Note& note, const std::string& key, const std::string& value) {
  if (key == "sensor") note.sensor = value;
  if (key == "image") note.image = value;
  if (key == "name") note.name = value;
  if (key == "focal_sigma_px") note.focal_sigma_px = number(value, 0, kMost);
  if (key == "k1_sigma") note.k1_sigma = number(value, 0, kMost);
  if (key == "k2_sigma") note.k2_sigma = number(value, 0, kMost);
  if (key == "height_above_ground_m") note.height_above_ground_m = number(value, -kMost, kMost);
  if (key == "datum") note.datum = datumFromText(value);
  if (key == "end") note.end = value == "1";
  if (key == "camera_version") {
    const std::optional<double> version = number(value, 0, kMost);
    if (version) note.camera_version = static_cast<unsigned>(*version);
  }
  if (key == "sigma_enu_m") {
    const std::vector<double> v = numbers(value);
    if (v.size() == 3 && *std::min_element(v.begin(), v.end()) >= kLeastSigma_m &&
        *std::max_element(v.begin(), v.end()) <= kMost)
      note.sigma_enu_m = Eigen::Vector3d(v[0], v[1], v[2]);
  }
}

}  // namespace

std::string noteText(const Note& note) {
  std::string text = std::string(kFirstLine) + "\n";
  const auto line = [&text](const char* key, const auto& value) {
    text += fmt::format("{} = {}\n", key, value);  // shortest form that reads back exactly
  };
  if (!note.sensor.empty()) line("sensor", note.sensor);
  if (!note.image.empty()) line("image", note.image);
  if (note.name) line("name", *note.name);
  if (note.focal_sigma_px) line("focal_sigma_px", *note.focal_sigma_px);
  if (note.k1_sigma) line("k1_sigma", *note.k1_sigma);
  if (note.k2_sigma) line("k2_sigma", *note.k2_sigma);
  if (note.camera_version) line("camera_version", *note.camera_version);
  if (note.height_above_ground_m) line("height_above_ground_m", *note.height_above_ground_m);
  if (note.sigma_enu_m)
    line("sigma_enu_m", fmt::format("{} {} {}", note.sigma_enu_m->x(), note.sigma_enu_m->y(),
                                    note.sigma_enu_m->z()));
  if (note.datum) line("datum", name(*note.datum));
  if (note.end) line("end", 1);
  return text;
}

std::optional<Note> noteFromText(const std::string& text) {
  std::istringstream in(text);
  std::string line;
  if (!std::getline(in, line) || line != kFirstLine) return std::nullopt;
  Note note;
  while (std::getline(in, line)) {
    const std::size_t equals = line.find(" = ");
    if (equals != std::string::npos) set(note, line.substr(0, equals), line.substr(equals + 3));
  }
  return note;
}

}  // namespace cf
