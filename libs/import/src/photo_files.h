// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cf {

struct PhotoFiles {
  std::vector<std::filesystem::path> photos;  ///< by natural order of their paths: DJI_9 < DJI_10
  std::size_t others = 0;                     ///< files that are no photos
};

/// The photos (by extension: jpg, jpeg, tif, tiff, png) in a folder and all folders below. Hidden
/// files, and what an earlier import wrote into `out_dir`, are not looked at.
/// Throws UsageError if there is no such folder.
PhotoFiles listPhotos(const std::filesystem::path& folder, const std::filesystem::path& out_dir);
/// By natural order of their paths.
void sortNaturally(std::vector<std::filesystem::path>& files);
/// The same as listPhotos(); UsageError too if there is no photo in it.
PhotoFiles findPhotos(const std::filesystem::path& folder, const std::filesystem::path& out_dir);

/// File names for the photos, one each: the base name, where two are equal with the names of
/// the parent folders before it ("101MEDIA_DJI_0001.JPG").
std::vector<std::string> uniqueNames(const std::vector<std::filesystem::path>& photos);

/// Names of UAVs for photo folders: the folder's name, where two are equal (but for case, which an
/// ini does not tell apart) or taken with the parents' names before it; characters that a section
/// of an ini cannot hold become '_'.
std::vector<std::string> uavNames(const std::vector<std::filesystem::path>& folders);

/// Hard link, or else copy, that replaces an earlier `target`. Throws RunError.
void linkOrCopy(const std::filesystem::path& source, const std::filesystem::path& target);

}  // namespace cf
