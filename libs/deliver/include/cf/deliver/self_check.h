// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cf {

struct RunRecord;

enum class Grade { kGreen, kAmber, kRed, kUntested };
/// "green", "amber", "red", "untested".
const char* name(Grade grade);

/// One question that a run asks of its own result, without any truth (docs/self_check.md).
struct SelfCheck {
  std::string name;             ///< seam, doming, lens, gnss, depth, photos
  std::string title;            ///< for people
  std::optional<double> value;  ///< none: it could not be tested
  std::string unit;
  Grade grade = Grade::kUntested;
  double green = 0, amber = 0;  ///< limits of the value
  bool more_is_better = false;  ///< green is a lower limit
  std::string finding;          ///< a sentence with the figures
  std::string advice;           ///< what can be done; empty where nothing need be
};

/// All checks, in the order in which they should be read.
std::vector<SelfCheck> selfCheck(const RunRecord& run);

/// What is doubtful, a line each; one line saying so where nothing is.
std::vector<std::string> doubts(const std::vector<SelfCheck>& checks);

}  // namespace cf
