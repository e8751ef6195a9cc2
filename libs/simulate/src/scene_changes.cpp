// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "scene_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "cf/base/error.h"

namespace cf {
namespace {

[[noreturn]] void refuse(const std::string& change, const std::string& why) {
  throw UsageError(fmt::format("[scene] changes: {}: {}", change, why));
}

/// Raze, raise and build with their numbers.
struct Change {
  std::string text, verb;
  std::vector<double> numbers;
};

Change changeFrom(const std::string& text) {
  Change change{text, {}, {}};
  std::istringstream words(text);
  words >> change.verb;
  for (double number = 0; words >> number;) change.numbers.push_back(number);
  const std::size_t wanted = change.verb == "raze"    ? 2
                             : change.verb == "raise" ? 3
                             : change.verb == "build" ? 5
                                                      : 0;
  if (wanted == 0 || !words.eof() || change.numbers.size() != wanted)
    refuse(text,
           "give raze E N, raise E N METRES or build E N WIDTH DEPTH HEIGHT, comma separated");
  return change;
}

BuildingPlan hallOf(const Change& change, const Eigen::Vector2d& place) {
  const Eigen::Vector2d half(change.numbers[2] / 2, change.numbers[3] / 2);
  if (!(half.minCoeff() > 0) || !(change.numbers[4] > 0))
    refuse(change.text, "width, depth and height are above 0");
  BuildingPlan hall;
  hall.box = {place - half, place + half};
  hall.ridge_along_x = half.x() > half.y();
  hall.eaves_m = change.numbers[4];
  hall.roof = Roof::kFlat;
  hall.home = false;
  hall.seed = 1;
  return hall;
}

}  // namespace

void applyChanges(const std::string& changes, const Eigen::Vector2d& middle, TownPlan& plan) {
  std::istringstream list(changes);
  for (std::string text; std::getline(list, text, ',');) {
    const Change change = changeFrom(text);
    const Eigen::Vector2d place =
        plan.turn.inverse() * (Eigen::Vector2d(change.numbers[0], change.numbers[1]) - middle);
    if (change.verb == "build") {
      plan.buildings.push_back(hallOf(change, place));
      continue;
    }
    const auto building =
        std::find_if(plan.buildings.begin(), plan.buildings.end(),
                     [&](const BuildingPlan& b) { return b.box.contains(place); });
    if (building == plan.buildings.end()) refuse(text, "no building stands there");
    if (change.verb == "raze")
      plan.buildings.erase(building);
    else
      building->eaves_m += change.numbers[2];
  }
}

}  // namespace cf
