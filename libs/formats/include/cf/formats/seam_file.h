// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "cf/formats/seam_message.h"

namespace cf {

/// Messages of one UAV in a file: eight bytes that name the format, then for each message its
/// length (u32), the CRC-32 of its bytes (u32), the CRC-32 of these eight (u32), its bytes; little
/// endian. Each message is in the file when write() returns; a reader may follow. Every failure
/// throws RunError naming the path.
class SeamWriter {
 public:
  /// Replaces what was there. Without a path it only counts what it would write.
  explicit SeamWriter(std::filesystem::path path = {});
  /// Goes on with a file that breaks off, if it is there: write() is given all messages again from
  /// the first, and those that the file holds must be the same bytes; of the Hello what it says of
  /// the UAV and its world. Throws RunError where they are not.
  static SeamWriter goOn(const std::filesystem::path& path);

  void write(const SeamMessage& message);
  std::uint64_t bytes() const { return bytes_; }

 private:
  void append(const std::string& bytes);
  void compare(const std::string& bytes) const;
  [[noreturn]] void refuse() const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_{nullptr, &std::fclose};
  SeamEncoder encoder_;
  std::uint64_t bytes_ = 0;
  /// Of a file that is gone on with: how much of it holds, and its first message and where it ends.
  std::uint64_t kept_ = 0;
  std::optional<SeamHello> hello_;
  std::uint64_t hello_end_ = 0;
};

/// Reads such a file, also while it grows.
class SeamReader {
 public:
  /// The file need not be there yet.
  explicit SeamReader(std::filesystem::path path) : path_(std::move(path)) {}

  /// The next message. None if it is not complete yet, or after the last: ended() tells. Throws
  /// RunError naming the file and the byte where it is damaged, became shorter, or goes on after
  /// its end.
  std::optional<SeamMessage> next();
  /// The UAV has said that it is done.
  bool ended() const { return ended_; }
  /// Of the messages read.
  std::uint64_t bytes() const { return offset_; }

 private:
  /// How much of the file is there; none if there is no file yet.
  std::optional<std::uint64_t> size();
  bool begin(std::uint64_t size);
  void read(void* to, std::uint64_t offset, std::size_t bytes) const;
  [[noreturn]] void becameShorter() const;
  [[noreturn]] void fail(const std::string& what,
                         const char* advice = "let its UAV write it again") const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_{nullptr, &std::fclose};
  std::uint64_t offset_ = 0;  ///< of what next() reads
  SeamDecoder decoder_;
  bool ended_ = false;
};

}  // namespace cf
