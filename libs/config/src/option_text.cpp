// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "option_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cf {
namespace {

/// std::from_chars over the whole text, in the C locale; a leading '+' is allowed.
template <class T>
bool parseAll(const std::string& text, T& value) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const char* begin = text.data() + (plus ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc() && stop == end;
}

bool inside(double value, Range range) { return value >= range.min && value <= range.max; }

Failure outOfRange(Range range) {
  return {"out_of_range", "is out of range: it must be " + rangeText(range)};
}

}  // namespace

Result<double> numberFromText(const std::string& text, Range range) {
  double value = 0;
  if (!parseAll(text, value) || !std::isfinite(value))
    return Failure{"not_a_number", "is not a number"};
  if (!inside(value, range)) return outOfRange(range);
  return value;
}

Result<int> integerFromText(const std::string& text, Range range) {
  int value = 0;
  if (!parseAll(text, value)) return Failure{"not_an_integer", "is not a whole number"};
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
