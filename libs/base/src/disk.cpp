// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/disk.h"

#include <fcntl.h>
#include <unistd.h>

#include <system_error>

#include "cf/base/error.h"

namespace cf {

bool syncFile(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool synced = fsync(descriptor) == 0;
  return close(descriptor) == 0 && synced;
}

void createFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && std::filesystem::is_directory(folder, error)) return;
  throw RunError(folder.string() +
                 ": cannot be created: " + (error ? error.message() : "it is a file"));
}

}  // namespace cf
