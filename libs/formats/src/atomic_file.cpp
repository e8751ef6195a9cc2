// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "cf/base/error.h"

namespace cf {

namespace {

constexpr std::size_t kSentAtOnce = std::size_t{16} << 20;

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path)
    : path_(std::move(path)), temporary_(path_.string() + ".tmp") {
  file_ = std::fopen(temporary_.c_str(), "wb");
  if (!file_) fail("cannot be created");
}

AtomicFile::~AtomicFile() {
  if (!file_) return;
  std::fclose(file_);
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void AtomicFile::write(const void* data, std::size_t bytes) {
  if (std::fwrite(data, 1, bytes, file_) != bytes) fail("cannot be written");
#ifdef __linux__
  // Large files begin to go to the disk at once: commit() then has little to wait for.
  unsent_ += bytes;
  if (unsent_ < kSentAtOnce) return;
  unsent_ = 0;
  sync_file_range(fileno(file_), 0, 0, SYNC_FILE_RANGE_WRITE);  // no more than a hint
#endif
}

void AtomicFile::overwrite(std::uint64_t offset, const std::string& text) {
  if (fseeko(file_, static_cast<off_t>(offset), SEEK_SET) != 0) fail("cannot be written");
  write(text);
  if (fseeko(file_, 0, SEEK_END) != 0) fail("cannot be written");
}

void AtomicFile::commit() {
  if (std::fflush(file_) != 0 || fsync(fileno(file_)) != 0) fail("cannot be written");
  const bool closed = std::fclose(std::exchange(file_, nullptr)) == 0;
  if (closed && std::rename(temporary_.c_str(), path_.c_str()) == 0) return;
  const int reason = errno;
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
  errno = reason;
  fail(closed ? "cannot be replaced" : "cannot be written");
}

void AtomicFile::fail(const char* action) {
  const std::string reason = std::strerror(errno);
  throw RunError(path_.string() + ": " + action + ": " + reason);
}

void writeFileAtomically(const std::filesystem::path& path, const std::string& content) {
  AtomicFile file(path);
  file.write(content);
  file.commit();
}

}  // namespace cf
