// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "note.h"

#include <fmt/format.h>

#include <sstream>
#include <vector>

#include "cf/base/text.h"

namespace cf {
namespace {

constexpr const char* kFirstLine = "clusterfusion note 1";
// Beyond these a value is damaged.
constexpr double kMost = 1e6, kLeastSigma_m = 1e-5;

std::optional<double> number(const std::string& text, double min, double max) {
  const std::optional<double> value = numberFrom(text);
  return value && *value >= min && *value <= max ? value : std::nullopt;
}

std::optional<Eigen::Vector3d> sigmas(const std::string& text) {
  const std::vector<std::string> words = wordsOf(text);
  if (words.size() != 3) return std::nullopt;
  Eigen::Vector3d out;
  for (int axis = 0; axis < 3; ++axis) {
    const auto sigma = number(words[static_cast<std::size_t>(axis)], kLeastSigma_m, kMost);
    if (!sigma) return std::nullopt;
    out[axis] = *sigma;
  }
  return out;
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
  if (key == "sigma_enu_m") note.sigma_enu_m = sigmas(value);
}

}  // namespace

std::string noteText(const Note& note) {
  std::string text = std::string(kFirstLine) + "\n";
  const auto line = [&text](const char* key, const auto& value) {
    text += fmt::format("{} = {}\n", key, value);  // shortest form that reads back exactly
  };
  if (!note.sensor.empty()) line("sensor", printable(note.sensor));
  if (!note.image.empty()) line("image", printable(note.image));
  if (note.name) line("name", printable(*note.name));
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
