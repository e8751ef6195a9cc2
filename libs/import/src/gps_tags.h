// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "cf/import/exif.h"

namespace cf {

/// Position from XMP where it has one (finer than EXIF's rationals), else from EXIF.
std::optional<PhotoPosition> positionFrom(const ExifItems& exif, const std::string& xmp);

PhotoTime timeFrom(const ExifItems& exif);

/// Text of an item, trimmed; empty if absent.
std::string item(const ExifItems& exif, const std::string& name);
/// First number of an item, 0 if absent.
double firstNumber(const ExifItems& exif, const std::string& name);

}  // namespace cf
