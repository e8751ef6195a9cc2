// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/seam_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <utility>

#include "cf/base/error.h"

namespace cf {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the file is little endian");

constexpr std::string_view kMagic = "CFSEAM01";

/// In front of each message.
struct Head {
  std::uint32_t length = 0;
  std::uint32_t crc = 0;       ///< of the message
  std::uint32_t head_crc = 0;  ///< of the two above
};
static_assert(sizeof(Head) == 12, "as it stands in the file");

std::uint32_t crcOf(const void* data, std::size_t bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, static_cast<const Bytef*>(data), bytes));
}
std::uint32_t headCrcOf(const Head& head) { return crcOf(&head, offsetof(Head, head_crc)); }

/// As it stands in a file, past any buffer: what was not there a moment ago may be now. How many
/// bytes there were, up to those asked for.
std::size_t readAt(std::FILE* file, const std::filesystem::path& path, void* to,
                   std::uint64_t offset, std::size_t bytes) {
  std::size_t done = 0;
  while (done < bytes) {
    const ssize_t got = pread(fileno(file), static_cast<char*>(to) + done, bytes - done,
                              static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw RunError(path.string() + ": cannot be read: " + std::strerror(errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

/// What a UAV says of itself, whatever is known of its recording.
std::string identityOf(SeamHello hello) {
  hello.photos.reset();
  hello.warnings.clear();
  return SeamEncoder().encode(hello);
}

}  // namespace

SeamWriter::SeamWriter(std::filesystem::path path) : path_(std::move(path)) {
  if (!path_.empty()) file_.reset(std::fopen(path_.c_str(), "wb"));
  if (!path_.empty() && !file_)
    throw RunError(path_.string() + ": cannot be created: " + std::strerror(errno));
  append(std::string(kMagic));
}

SeamWriter SeamWriter::goOn(const std::filesystem::path& path) {
  SeamReader reader(path);
  auto first = reader.next();
  if (!first) return SeamWriter(path);
  SeamWriter writer;
  writer.path_ = path;
  writer.hello_end_ = reader.bytes();
  if (auto* hello = std::get_if<SeamHello>(&*first)) writer.hello_ = std::move(*hello);
  if (!writer.hello_) writer.refuse();
  while (reader.next()) {
  }
  writer.kept_ = reader.bytes();
  std::error_code error;
  std::filesystem::resize_file(path, writer.kept_, error);  // without what is there in part
  writer.file_.reset(error ? nullptr : std::fopen(path.c_str(), "r+b"));
  if (!writer.file_ || std::fseek(writer.file_.get(), 0, SEEK_END) != 0)
    throw RunError(path.string() + ": cannot be written: " + std::strerror(errno));
  return writer;
}

void SeamWriter::write(const SeamMessage& message) {
  if (const auto* hello = std::get_if<SeamHello>(&message); hello != nullptr && hello_) {
    if (identityOf(*hello) != identityOf(*hello_)) refuse();
    (void)encoder_.encode(message);
    hello_.reset();
    bytes_ = hello_end_;
    return;
  }
  const std::string bytes = encoder_.encode(message);
  Head head;
  head.length = static_cast<std::uint32_t>(bytes.size());
  head.crc = crcOf(bytes.data(), bytes.size());
  head.head_crc = headCrcOf(head);
  append(std::string(reinterpret_cast<const char*>(&head), sizeof head) + bytes);
}

void SeamWriter::append(const std::string& bytes) {
  if (bytes_ < kept_)
    compare(bytes);
  else if (file_ && (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size() ||
                     std::fflush(file_.get()) != 0))
    throw RunError(path_.string() + ": cannot be written: " + std::strerror(errno));
  bytes_ += bytes.size();
}

/// With what the file holds there.
void SeamWriter::compare(const std::string& bytes) const {
  std::string there(bytes.size(), '\0');
  if (bytes_ + bytes.size() > kept_ ||
      readAt(file_.get(), path_, there.data(), bytes_, there.size()) != there.size() ||
      there != bytes)
    refuse();
}

void SeamWriter::refuse() const {
  throw RunError(fmt::format(
      "{}: it was begun with other settings or of another recording (seen at byte {}): -w begins "
      "it anew",
      path_.string(), bytes_));
}

std::optional<SeamMessage> SeamReader::next() {
  const auto there = size();
  if (!there) return std::nullopt;
  if (*there < offset_) becameShorter();
  if (!begin(*there)) return std::nullopt;
  const std::uint64_t left = *there - offset_;
  if (ended_ && left > 0) fail("the file goes on after its last message");
  if (left < sizeof(Head)) return std::nullopt;
  Head head;
  read(&head, offset_, sizeof head);
  if (head.head_crc != headCrcOf(head)) fail("the length of a message is damaged");
  if (left - sizeof head < head.length) return std::nullopt;
  std::string bytes(head.length, '\0');
  read(bytes.data(), offset_ + sizeof head, bytes.size());
  if (head.crc != crcOf(bytes.data(), bytes.size())) fail("a message is damaged");
  Result<SeamMessage> message = decoder_.decode(bytes);
  if (!message) fail("a message cannot be understood: " + message.failure().detail);
  offset_ += sizeof head + head.length;
  ended_ = std::holds_alternative<SeamDone>(message.value());
  return std::move(message.value());
}

std::optional<std::uint64_t> SeamReader::size() {
  if (!file_) file_.reset(std::fopen(path_.c_str(), "rb"));
  if (!file_ && errno == ENOENT) return std::nullopt;
  struct stat status {};
  if (!file_ || fstat(fileno(file_.get()), &status) != 0)
    throw RunError(path_.string() + ": cannot be read: " + std::strerror(errno));
  return static_cast<std::uint64_t>(status.st_size);
}

/// Past the bytes that name the format; false if they are not all there yet.
bool SeamReader::begin(std::uint64_t size) {
  if (offset_ > 0) return true;
  std::string start(std::min<std::uint64_t>(size, kMagic.size()), '\0');
  read(start.data(), 0, start.size());
  if (start != kMagic.substr(0, start.size())) fail("this is no seam file of this version");
  if (start.size() < kMagic.size()) return false;
  offset_ = kMagic.size();
  return true;
}

void SeamReader::read(void* to, std::uint64_t offset, std::size_t bytes) const {
  if (readAt(file_.get(), path_, to, offset, bytes) != bytes) becameShorter();
}

void SeamReader::becameShorter() const {
  fail("the file became shorter", "if its agent has begun anew, begin anew here too");
}

void SeamReader::fail(const std::string& what, const char* advice) const {
  throw RunError(fmt::format("{}: {} (at byte {}); {}", path_.string(), what, offset_, advice));
}

}  // namespace cf
