// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "gnss_disagreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace cf {
namespace {

constexpr double kUsualHorizontal_m = 12, kUsualVertical_m = 20;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

bool unusual(const Eigen::Vector3d& difference_m) {
  return difference_m.head<2>().norm() > kUsualHorizontal_m ||
         std::abs(difference_m.z()) > kUsualVertical_m;
}

/// What disagrees, and by how much.
std::string describe(const Eigen::Vector3d& difference_m) {
  if (std::abs(difference_m.z()) > kUsualVertical_m)
    return fmt::format("GPS altitude disagrees by {:.0f} m", std::abs(difference_m.z()));
  return fmt::format("GPS position disagrees by {:.0f} m", difference_m.head<2>().norm());
}

}  // namespace

std::vector<std::string> gnssDisagreements(const std::vector<UavRecord>& uavs) {
  std::vector<const UavRecord*> known;
  for (const UavRecord& uav : uavs)
    if (uav.gnss.fixes > 0 && uav.gnss.trusted) known.push_back(&uav);
  constexpr const char* kAdvice = "bias estimated; do all heights count from the same surface?";
  std::vector<std::string> sentences;
  if (known.size() == 2) {
    const Eigen::Vector3d difference = known[0]->gnss.bias_m - known[1]->gnss.bias_m;
    if (unusual(difference))
      sentences.push_back(fmt::format("{} and {}: their {}, and nothing tells which is right; {}",
                                      known[0]->name, known[1]->name, describe(difference),
                                      kAdvice));
  } else if (known.size() > 2) {
    Eigen::Vector3d middle;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      std::vector<double> biases;
      for (const UavRecord* uav : known) biases.push_back(uav->gnss.bias_m[axis]);
      middle[axis] = median(std::move(biases));
    }
    for (const UavRecord* uav : known)
      if (unusual(uav->gnss.bias_m - middle))
        sentences.push_back(fmt::format("{}: its {} with the other UAVs'; {}", uav->name,
                                        describe(uav->gnss.bias_m - middle), kAdvice));
  }
  return sentences;
}

}  // namespace cf
