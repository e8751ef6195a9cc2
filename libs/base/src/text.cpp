// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/text.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <sstream>
#include <system_error>

namespace cf {

std::string trimmed(const std::string& text) {
  constexpr const char* kBlanks = " \t\r\n\f\v";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string> wordsOf(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::optional<double> numberFrom(const std::string& text) {
  const std::string token = trimmed(text);
  const bool plus = token.size() > 1 && token[0] == '+' && token[1] != '-';
  const char* const end = token.data() + token.size();
  double value = 0;
  const auto [stop, error] = std::from_chars(token.data() + (plus ? 1 : 0), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::string printable(std::string text) {
  for (char& c : text)
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  return text;
}

}  // namespace cf
