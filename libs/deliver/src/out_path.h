// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "cf/deliver/run_record.h"

namespace cf {

/// outdir/folder/file, the folders made. RunError if they cannot be.
std::filesystem::path outPath(const std::filesystem::path& outdir, const std::string& folder,
                              const std::string& file);

/// Name of a UAV or a photo by index; RunError if the record has none such.
const UavRecord& uavOf(const RunRecord& run, FrameId id);
const PhotoRecord& photoOf(const RunRecord& run, FrameId id);
const PhotoRecord& photoOf(const UavRecord& uav, std::uint32_t index);

}  // namespace cf
