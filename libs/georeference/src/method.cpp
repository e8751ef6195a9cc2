// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "method.h"

#include <algorithm>

#include "cf/base/error.h"

namespace cf {
namespace {
constexpr double kGrowth = 1.1;  ///< of a segment between full solves
}  // namespace

const std::vector<std::string>& georeferenceMethods() {
  static const std::vector<std::string> names = {"two_stage", "global_fusion"};
  return names;
}

std::unique_ptr<GeoreferenceMethod> makeMethod(const GeoreferenceOptions& options) {
  if (options.method == "two_stage") return makeTwoStage(options);
  if (options.method == "global_fusion") return makeGlobalFusion(options);
  throw UsageError("georeference method '" + options.method +
                   "' is none of: two_stage, global_fusion");
}

bool GeoreferenceMethod::isShort(const Segment& segment) const {
  return segment.nodes.size() <= static_cast<std::size_t>(options_.full_solve_keyframes);
}

bool GeoreferenceMethod::fullSolveDue(const Segment& segment) const {
  return isShort(segment) || !segment.solved ||
         static_cast<double>(segment.nodes.size()) >=
             kGrowth * static_cast<double>(segment.full_solve_size);
}

std::size_t GeoreferenceMethod::windowStart(const Segment& segment) const {
  const std::size_t n = segment.nodes.size();
  return n - std::min(n - 1, static_cast<std::size_t>(options_.window_keyframes));
}

}  // namespace cf
