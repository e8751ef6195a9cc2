// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

namespace cf {

/// A file that appears whole or not at all: written as `<path>.tmp`, synced to disk and renamed by
/// commit(). Uncommitted, it is removed again and what was at `path` stays. Every failure throws
/// RunError naming the path.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends.
  void write(const void* data, std::size_t bytes);
  void write(const std::string& text) { write(text.data(), text.size()); }
  /// Replaces bytes written earlier.
  void overwrite(std::uint64_t offset, const std::string& text);
  void commit();
  const std::filesystem::path& path() const { return path_; }

 private:
  [[noreturn]] void fail(const char* action);

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::FILE* file_ = nullptr;
  std::size_t unsent_ = 0;  ///< bytes that the disk was not yet asked to take
};

void writeFileAtomically(const std::filesystem::path& path, const std::string& content);

}  // namespace cf
