// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "cf/base/error.h"

/// One reader given any bytes whatever. Each tests/fuzz/<reader>_fuzz.cpp defines it and
/// cf::fuzz::seeds(); libFuzzer or driver.cpp calls it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace cf::fuzz {

/// Inputs that the reader accepts, made by our own writers: what mutation starts from.
std::vector<std::string> seeds();

/// A file in memory for readers that take a path.
class InputFile {
 public:
  explicit InputFile(const char* name) : fd_(memfd_create(name, 0)) {
    if (fd_ < 0) throw std::runtime_error("no file in memory");
    path_ = "/proc/self/fd/" + std::to_string(fd_);
  }
  ~InputFile() { close(fd_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& put(const std::uint8_t* data, std::size_t size) {
    if (pwrite(fd_, data, size, 0) != static_cast<ssize_t>(size) ||
        ftruncate(fd_, static_cast<off_t>(size)) != 0)
      throw std::runtime_error("file in memory cannot be written");
    return path_;
  }

 private:
  int fd_;
  std::filesystem::path path_;
};

/// Runs a reader. It may refuse its input by one line that names the file, and by nothing else.
template <class Read>
void expectOneLineAtMost(const std::filesystem::path& file, const Read& read) {
  const auto check = [&](const std::string& line) {
    if (line.find('\n') != std::string::npos)
      throw std::logic_error("an error of several lines: " + line);
    if (line.find(file.string()) == std::string::npos)
      throw std::logic_error("an error that does not name the file: " + line);
  };
  try {
    read();
  } catch (const UsageError& e) {
    check(e.what());
  } catch (const RunError& e) {
    check(e.what());
  }
}

/// What the reader promises of all that it returns.
inline void require(bool kept, const char* promise) {
  if (!kept) throw std::logic_error(std::string("a broken promise: ") + promise);
}

}  // namespace cf::fuzz
