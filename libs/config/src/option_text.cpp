// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "option_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include "cf/base/text.h"

namespace cf {
namespace {

bool inside(double value, Range range) { return value >= range.min && value <= range.max; }

Failure outOfRange(Range range) {
  return {"out_of_range", "is out of range: it must be " + rangeText(range)};
}

}  // namespace

Result<double> numberFromText(const std::string& text, Range range) {
  const std::optional<double> value = numberFrom(text);
  if (!value) return Failure{"not_a_number", "is not a number"};
  if (!inside(*value, range)) return outOfRange(range);
  return *value;
}

Result<int> integerFromText(const std::string& text, Range range) {
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const char* end = text.data() + text.size();
  int value = 0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end)
    return Failure{"not_an_integer", "is not a whole number"};
  if (!inside(value, range)) return outOfRange(range);
  return value;
}

Result<bool> flagFromText(const std::string& text) {
  if (text == "true" || text == "yes" || text == "1") return true;
  if (text == "false" || text == "no" || text == "0") return false;
  return Failure{"not_a_flag", "is neither true (yes, 1) nor false (no, 0)"};
}

Result<std::string> choiceFromText(const std::string& text,
                                   const std::vector<std::string>& allowed) {
  if (std::find(allowed.begin(), allowed.end(), text) != allowed.end()) return text;
  return Failure{"not_a_choice", fmt::format("is not one of: {}", fmt::join(allowed, ", "))};
}

std::string numberText(double value) { return fmt::format("{}", value); }

std::string integerText(int value) { return fmt::format("{}", value); }

std::string flagText(bool value) { return value ? "true" : "false"; }

std::string rangeText(Range range) {
  const bool low = std::isfinite(range.min), high = std::isfinite(range.max);
  if (low && high) return fmt::format("{} to {}", range.min, range.max);
  if (low) return fmt::format("at least {}", range.min);
  if (high) return fmt::format("at most {}", range.max);
  return {};
}

}  // namespace cf
