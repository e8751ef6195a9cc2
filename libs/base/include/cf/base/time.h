// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace cf {

/// Nanoseconds since 1970-01-01T00:00:00 UTC (leap seconds not counted).
using TimeNs = std::int64_t;

inline constexpr TimeNs kNsPerSecond = 1'000'000'000;

inline double seconds(TimeNs t) { return static_cast<double>(t) * 1e-9; }

/// Decimal seconds with nine digits, exact: "1466699519.000000000". The one text form of a time in
/// every file that we write.
std::string timeText(TimeNs t);

/// Seconds in decimal text to nanoseconds, exact to the ninth decimal, later ones dropped; throws
/// RunError on anything else.
TimeNs timeFromText(const std::string& text);

/// "2016-06-23T16:31:59Z", for people.
std::string isoText(TimeNs t);

}  // namespace cf
