// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "out_path.h"

#include <fmt/format.h>

#include "cf/base/error.h"

namespace cf {

std::filesystem::path outPath(const std::filesystem::path& outdir, const std::string& folder,
                              const std::string& file) {
  const std::filesystem::path directory = folder.empty() ? outdir : outdir / folder;
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error)
    throw RunError(fmt::format("{}: cannot be made: {}", directory.string(), error.message()));
  return directory / file;
}

const UavRecord& uavOf(const RunRecord& run, FrameId id) {
  if (id.uav >= run.uavs.size())
    throw RunError(fmt::format("the run has no UAV number {}", id.uav));
  return run.uavs[id.uav];
}

const PhotoRecord& photoOf(const UavRecord& uav, std::uint32_t index) {
  if (index >= uav.photos.size())
    throw RunError(fmt::format("UAV {} has no photo number {}", uav.name, index));
  return uav.photos[index];
}

const PhotoRecord& photoOf(const RunRecord& run, FrameId id) {
  return photoOf(uavOf(run, id), id.index);
}

}  // namespace cf
