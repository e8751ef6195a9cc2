// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "text.h"

#include <cmath>
#include <locale>
#include <sstream>

namespace cf {

std::vector<std::string> wordsOf(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::optional<double> numberFrom(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double value = 0;
  if (!(in >> value) || !std::isfinite(value)) return std::nullopt;
  char rest = 0;
  if (in >> rest) return std::nullopt;
  return value;
}

std::vector<double> numbersIn(const std::string& text) {
  std::string plain = text;
  for (char& c : plain)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::vector<double> values;
  for (const std::string& word : wordsOf(plain))
    if (const std::optional<double> value = numberFrom(word)) values.push_back(*value);
  return values;
}

}  // namespace cf
