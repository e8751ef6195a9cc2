// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/time.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cctype>
#include <ctime>
#include <limits>

#include "cf/base/error.h"

namespace cf {

std::string timeText(TimeNs t) {
  const bool negative = t < 0;
  const auto bits = static_cast<std::uint64_t>(t);
  const std::uint64_t magnitude = negative ? 0 - bits : bits;  // the most negative time has no -t
  return fmt::format("{}{}.{:09}", negative ? "-" : "", magnitude / kNsPerSecond,
                     magnitude % kNsPerSecond);
}

TimeNs timeFromText(const std::string& text) {
  const auto bad = [&] { return RunError("'" + text + "' is not a time in decimal seconds"); };
  std::size_t i = 0;
  const bool negative = !text.empty() && text[0] == '-';
  if (negative) i = 1;
  TimeNs value = 0;
  std::size_t digits = 0;
  for (; i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])); ++i, ++digits) {
    if (digits >= 10) throw bad();
    value = value * 10 + (text[i] - '0');
  }
  if (digits == 0 || value > std::numeric_limits<TimeNs>::max() / kNsPerSecond - 1) throw bad();
  value *= kNsPerSecond;
  if (i < text.size() && text[i] == '.') {
    ++i;
    TimeNs unit = kNsPerSecond / 10;
    for (; i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])); ++i, unit /= 10)
      value += (text[i] - '0') * unit;
  }
  if (i != text.size()) throw bad();
  return negative ? -value : value;
}

std::string isoText(TimeNs t) {
  const std::time_t whole = static_cast<std::time_t>(t / kNsPerSecond);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(whole));
}

}  // namespace cf
