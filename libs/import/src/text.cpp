// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "text.h"

#include <optional>

#include "cf/base/text.h"

namespace cf {

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
