// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "plane.h"

namespace cf::sift {

constexpr int kScales = 3;  ///< per octave (Lowe 2004, section 3.2)
constexpr int kLevels = kScales + 3;

/// An image under kLevels Gaussians, whose sigmas grow by 2^(1/kScales) from level to level.
using Octave = std::array<Plane, kLevels>;

/// Blur of a level, which need not be whole [px of the octave].
double sigmaOfLevel(double level);

/// `in` under a Gaussian; the border is mirrored.
Plane blurred(const Plane& in, double sigma);

/// `image_sigma` is the blur that the image comes with [px].
Octave firstOctave(const Plane& image, double image_sigma);

/// Pixel x of the next octave is pixel 2 x of this one.
Octave nextOctave(const Octave& octave);

}  // namespace cf::sift
