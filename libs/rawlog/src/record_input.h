// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace cf {

/// The bytes of one record, in the form that MRPT's archives read from.
///
/// MRPT believes every length that it reads: four wrong bytes, and it asks for 4 GB; pixels inside
/// a rawlog it decodes whatever their size. In the records that we hand to it, each read of four
/// bytes is a length, a count, a size in pixels, a small code, or four characters that a length of
/// 4 announces. Read() throws where one exceeds what any record has, at pixels, and at versions of
/// parts whose sizes it could not check.
class RecordInput {
 public:
  RecordInput(const char* begin, std::size_t size) : data_(begin), size_(size) {}

  /// All bytes asked for, or none.
  std::size_t Read(void* to, std::size_t bytes);
  std::size_t Write(const void*, std::size_t) { return 0; }
  std::string getStreamDescription() const { return "record of a rawlog"; }

  std::size_t position() const { return at_; }
  bool ranOut() const { return ran_out_; }            ///< more was asked for than there is
  bool holdsPixels() const { return holds_pixels_; }  ///< an image that is not stored externally

 private:
  enum class Part { kOther, kPose, kCamera, kImage };
  enum class Byte { kAny, kVersion, kStorage };
  void check(const char* bytes, std::size_t count);
  void checkByte(unsigned char byte, Byte meaning);
  void checkNumber(std::uint32_t number, bool announced);
  bool mayBeText() const;

  const char* data_;
  std::size_t size_, at_ = 0;
  // Of the part that is being read.
  Part part_ = Part::kOther;
  int version_ = 0;
  int numbers_ = 0;  ///< reads of four bytes so far
  // What the read before says of the next one.
  std::size_t name_length_ = 0, text_length_ = 0;
  Byte next_byte_ = Byte::kAny;
  bool ran_out_ = false, holds_pixels_ = false;
};

}  // namespace cf
