// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "record_input.h"

#include <cstring>
#include <stdexcept>
#include <utility>

namespace cf {
namespace {

constexpr std::uint32_t kMaxNumber = 1 << 20;

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

std::size_t RecordInput::Read(void* to, std::size_t bytes) {
  if (bytes > size_ - at_) {
    ran_out_ = true;
    return 0;
  }
  check(data_ + at_, bytes);
  std::memcpy(to, data_ + at_, bytes);
  at_ += bytes;
  return bytes;
}

void RecordInput::check(const char* bytes, std::size_t count) {
  const std::size_t name_length = std::exchange(name_length_, 0);
  const std::size_t text_length = std::exchange(text_length_, 0);
  const Byte meaning = std::exchange(next_byte_, Byte::kAny);
  if (count == 1) {
    checkByte(static_cast<unsigned char>(*bytes), meaning);
  } else if (count == name_length) {
    const std::string name(bytes, count);
    part_ = endsWith(name, "CPose3D")   ? Part::kPose
            : endsWith(name, "TCamera") ? Part::kCamera
            : endsWith(name, "CImage")  ? Part::kImage
                                        : Part::kOther;
    numbers_ = 0;
    next_byte_ = Byte::kVersion;
  } else if (count == sizeof(std::uint32_t)) {
    std::uint32_t number = 0;
    std::memcpy(&number, bytes, sizeof number);
    checkNumber(number, count == text_length);
  }
}

void RecordInput::checkByte(unsigned char byte, Byte meaning) {
  if (meaning == Byte::kVersion) {
    version_ = byte;
    // Poses before version 1 and images before 6 hold matrices and pixels of any size.
    if ((part_ == Part::kPose && byte < 1) || (part_ == Part::kImage && byte < 6))
      throw std::runtime_error("a version that is too old");
    if (part_ == Part::kImage) next_byte_ = Byte::kStorage;
  } else if (meaning == Byte::kStorage && byte == 0) {
    holds_pixels_ = true;
    throw std::runtime_error("pixels");
  } else if ((byte & 0x80) != 0) {
    name_length_ = byte & 0x7F;
  }
}

void RecordInput::checkNumber(std::uint32_t number, bool announced) {
  ++numbers_;
  if (announced && mayBeText()) return;
  if (number > kMaxNumber) throw std::runtime_error("a length that no record has");
  text_length_ = number;
}

/// Width and height of a camera announce nothing: after them comes the length of its name, which is
/// the only one that it has, from version 5 on.
bool RecordInput::mayBeText() const {
  constexpr int kNumbersBeforeName = 3;
  return part_ != Part::kCamera || (version_ >= 5 && numbers_ == kNumbersBeforeName + 1);
}

}  // namespace cf
