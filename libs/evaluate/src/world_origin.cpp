// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "world_origin.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"

namespace cf {

std::optional<LocalFrame> worldFrameOf(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "world.json";
  if (!std::filesystem::exists(file)) return std::nullopt;
  std::ifstream in(file);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (json.is_discarded() || !json.is_object()) throw RunError(file.string() + ": is not JSON");
  if (!json.contains("origin") || json["origin"].is_null()) return std::nullopt;
  const auto& origin = json["origin"];
  const auto number = [&](const char* key) {
    if (!origin.is_object() || !origin.contains(key) || !origin[key].is_number())
      throw RunError(file.string() + ": origin." + key + " is not a number");
    return origin[key].get<double>();
  };
  return LocalFrame(number("lat"), number("lon"), number("h"));
}

std::optional<Eigen::Isometry3d> transformBetweenWorlds(const std::filesystem::path& est_dir,
                                                        const std::filesystem::path& ref_dir) {
  const auto est = worldFrameOf(est_dir), ref = worldFrameOf(ref_dir);
  if (!est || !ref) return std::nullopt;
  return ref->T_this_other(*est);
}

}  // namespace cf
