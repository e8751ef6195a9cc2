// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/serialization/CSerializable.h>
#include <zlib.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace cf {

/// The records of a rawlog that matter to us, one after another: images, GPS, IMU and comments, at
/// the top level or inside sensory frames. Anything else, damage included, is passed over: the next
/// record is found by its header, a byte 0x80 + n and n characters of a class name.
/// Memory is bounded, whatever the file says of itself.
class RawlogRecords {
 public:
  /// Throws RunError if there is no such file.
  explicit RawlogRecords(const std::filesystem::path& rawlog);

  /// Null at the end of what is there. Asked again, it goes on from there, or from a record that
  /// was not complete: the file may have grown.
  mrpt::serialization::CSerializable::Ptr next();

  struct Counts {
    std::size_t read = 0;
    std::size_t damaged = 0;
    std::size_t with_pixels = 0;          ///< images stored inside the rawlog
    std::size_t outdated = 0;             ///< of versions that cannot be read safely
    std::set<std::string> other_classes;  ///< of observations that are not used
    bool breaks_off = false;              ///< known at the end
    bool empty() const { return read + with_pixels + outdated + other_classes.size() == 0; }
  };
  const Counts& counts() const { return counts_; }
  /// What is wrong, as far as counted; `ended`: nothing is missing, whatever the file looks like.
  std::vector<std::string> warnings(bool ended) const;

 private:
  struct CloseFile {
    void operator()(gzFile file) const { gzclose_r(file); }
  };
  struct Header {
    std::string class_name;  ///< without its namespace
    std::size_t size = 0;    ///< [bytes] up to the version
    int version = 0;
  };
  /// Where an incomplete record begins.
  struct Place {
    std::size_t at = 0;
    std::size_t failed_in_a_row = 0;
    Counts counts;
  };
  void lookAgain();
  void fill();
  bool headerHere(Header& header);
  void cutShortHere();
  mrpt::serialization::CSerializable::Ptr parse();

  std::string name_;
  std::unique_ptr<gzFile_s, CloseFile> file_;
  std::vector<char> buffer_;
  std::size_t at_ = 0;   ///< in the buffer
  bool at_end_ = false;  ///< of the file: the buffer holds its rest
  bool stream_broken_ = false;
  std::optional<Place> cut_short_;  ///< the first since the last whole record
  std::size_t failed_in_a_row_ = 0;
  Counts counts_;
};

}  // namespace cf
