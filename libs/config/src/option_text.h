// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "cf/base/options.h"
#include "cf/base/result.h"

namespace cf {

// Values of options from and to text. The whole text must be one value; a failure's detail says
// what it should have been ("is not a number").
Result<double> numberFromText(const std::string& text, Range range);
Result<int> integerFromText(const std::string& text, Range range);
Result<bool> flagFromText(const std::string& text);
Result<std::string> choiceFromText(const std::string& text,
                                   const std::vector<std::string>& allowed);

std::string numberText(double value);  ///< shortest text that reads back as the same number
std::string integerText(int value);
std::string flagText(bool value);
std::string rangeText(Range range);  ///< "0.1 to 20", "at least 0", "" if unbounded

}  // namespace cf
