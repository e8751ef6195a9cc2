// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "cf/types/gnss_fix.h"

namespace cf {

/// What a CObservationImage or CObservationGPS has no field for. Travels as text in a
/// CObservationComment with the time of what it belongs to (MRPT 2.5.8 does not store the sensor
/// label of comments, so that stands in the text): a first line "clusterfusion note 1", then "key =
/// value" lines (docs/rawlog.md). Texts are those of printable(), or a line break in a file name
/// would end theirs.
struct Note {
  std::string sensor;  ///< label of the observation that it belongs to
  // of a photo
  std::string image;  ///< external file name of the photo that it belongs to; empty: of a fix
  std::optional<std::string> name;
  std::optional<double> focal_sigma_px, k1_sigma, k2_sigma;
  std::optional<double> height_above_ground_m;
  std::optional<unsigned> camera_version;
  // of a fix
  std::optional<Eigen::Vector3d> sigma_enu_m;
  std::optional<HeightDatum> datum;
  // of the rawlog
  bool end = false;  ///< nothing follows
};

/// Text of the comment.
std::string noteText(const Note& note);

/// Nothing if the text is no note of ours. Unknown keys are skipped; values that do not parse are
/// left out.
std::optional<Note> noteFromText(const std::string& text);

inline std::string gimbalLabel(const std::string& image_label) { return image_label + "_GIMBAL"; }

}  // namespace cf
