// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "cf/import/exif.h"

namespace cf {

struct FlightTimes {
  std::vector<TimeNs> times;  ///< by photo, all different, whole microseconds
  std::string source;         ///< for people: "GPS", "camera clock taken as UTC"
  std::vector<std::string> warnings;
};

/// Times of the photos of one flight, given in the order of their file names.
/// GPS time where every photo has a fresh one; else the camera's clock, set by the median of GPS
/// minus camera where any photo has both. Photos without a time get one between their neighbours
/// by name. Equal times (one-second clocks) are spread evenly, in order of the names, over what is
/// left to the next photo, one second at most.
FlightTimes flightTimes(const std::vector<PhotoTime>& tags);

}  // namespace cf
