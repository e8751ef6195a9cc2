// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "rawlog_records.h"

#include <fmt/format.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <system_error>
#include <utility>

#include "cf/base/error.h"
#include "record_input.h"

namespace cf {
namespace {

constexpr std::size_t kMaxRecordBytes = 1 << 20;
/// In a row: MRPT takes its time to fail, and nothing good follows so many.
constexpr std::size_t kMostFailures = 10'000;
constexpr std::size_t kWindowBytes = 4 * kMaxRecordBytes, kChunkBytes = 1 << 18;
constexpr std::string_view kNamespace = "mrpt::obs::", kObservation = "CObservation";

/// Classes that are read, and from which version on.
constexpr std::pair<std::string_view, int> kClasses[] = {{"CObservationImage", 4},
                                                         {"CObservationGPS", 10},
                                                         {"CObservationIMU", 1},
                                                         {"CObservationComment", 0}};

bool startsWith(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

/// Of an observation, or of as much of its name as there is.
bool mayBeObservation(std::string_view name) {
  if (startsWith(name, kNamespace))
    name.remove_prefix(kNamespace.size());
  else if (startsWith(kNamespace, name))
    return true;
  return startsWith(name, kObservation) || startsWith(kObservation, name);
}

}  // namespace

RawlogRecords::RawlogRecords(const std::filesystem::path& rawlog)
    : name_(rawlog.filename().string()) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(rawlog, ignored)) file_.reset(gzopen(rawlog.c_str(), "rb"));
  if (!file_)
    throw RunError(fmt::format("{} cannot be read: there is no such rawlog", rawlog.string()));
}

/// If all was read: from where something may follow.
void RawlogRecords::lookAgain() {
  if (!at_end_ || at_ < buffer_.size()) return;
  if (cut_short_) {
    at_ = cut_short_->at;
    failed_in_a_row_ = cut_short_->failed_in_a_row;
    counts_ = std::move(cut_short_->counts);
    cut_short_.reset();
  }
  counts_.breaks_off = false;
  gzclearerr(file_.get());
  at_end_ = false;
}

/// A whole record, if it is one, lies in the buffer afterwards.
void RawlogRecords::fill() {
  if (at_end_ || buffer_.size() - at_ >= kMaxRecordBytes) return;
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at_));
  at_ = 0;
  while (!at_end_ && buffer_.size() < kWindowBytes) {
    const std::size_t kept = buffer_.size();
    buffer_.resize(kept + kChunkBytes);
    const std::size_t got = gzfread(buffer_.data() + kept, 1, kChunkBytes, file_.get());
    buffer_.resize(kept + got);
    at_end_ = got < kChunkBytes;
  }
  int code = Z_OK;
  gzerror(file_.get(), &code);
  stream_broken_ = code != Z_OK;
}

/// What begins here may be a record that the file holds a part of.
void RawlogRecords::cutShortHere() {
  if (!cut_short_) cut_short_ = Place{at_, failed_in_a_row_, counts_};
}

bool RawlogRecords::headerHere(Header& header) {
  const auto first = static_cast<unsigned char>(buffer_[at_]);
  const std::size_t length = first & 0x7F;
  if ((first & 0x80) == 0 || length <= kObservation.size()) return false;
  const std::size_t left = buffer_.size() - at_ - 1;
  std::string_view name(buffer_.data() + at_ + 1, std::min(length, left));
  if (!mayBeObservation(name)) return false;
  if (left <= length) {  // the file ends here: no other way to have less than a whole record
    cutShortHere();
    return false;
  }
  if (startsWith(name, kNamespace)) name.remove_prefix(kNamespace.size());
  if (!std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) != 0; }))
    return false;
  header.class_name = name;
  header.size = 1 + length;
  header.version = static_cast<unsigned char>(buffer_[at_ + header.size]);
  return true;
}

mrpt::serialization::CSerializable::Ptr RawlogRecords::parse() {
  RecordInput input(buffer_.data() + at_, std::min(kMaxRecordBytes, buffer_.size() - at_));
  try {
    const auto object = mrpt::serialization::archiveFrom(input).ReadObject();
    at_ += input.position();
    failed_in_a_row_ = 0;
    return object;
  } catch (const std::exception&) {
    if (input.ranOut() && at_end_ && !input.holdsPixels())
      cutShortHere();
    else if (input.holdsPixels())
      ++counts_.with_pixels;
    else
      ++counts_.damaged;
    ++failed_in_a_row_;
    return nullptr;
  }
}

mrpt::serialization::CSerializable::Ptr RawlogRecords::next() {
  lookAgain();
  Header header;
  for (fill(); at_ < buffer_.size(); fill()) {
    if (failed_in_a_row_ == kMostFailures) {
      counts_.breaks_off = true;
      break;
    }
    if (!headerHere(header)) {
      ++at_;
      continue;
    }
    const auto known = std::find_if(std::begin(kClasses), std::end(kClasses),
                                    [&](const auto& c) { return c.first == header.class_name; });
    if (known == std::end(kClasses)) {
      counts_.other_classes.insert(header.class_name);
    } else if (header.version < known->second) {
      ++counts_.outdated;
    } else if (auto object = parse()) {
      if (cut_short_) ++counts_.damaged;  // it was not the end
      cut_short_.reset();
      ++counts_.read;
      return object;
    }
    at_ += header.size;
  }
  counts_.breaks_off |= cut_short_.has_value() || stream_broken_;
  return nullptr;
}

std::vector<std::string> RawlogRecords::warnings(bool ended) const {
  std::vector<std::string> all;
  if (counts_.breaks_off && !ended)
    all.push_back(
        fmt::format("{} breaks off after {} records: the rest is lost", name_, counts_.read));
  if (counts_.damaged != 0)
    all.push_back(fmt::format("{}: {} damaged records are left out", name_, counts_.damaged));
  if (counts_.with_pixels != 0)
    all.push_back(fmt::format(
        "{}: {} images are stored inside the rawlog and left out: store them externally", name_,
        counts_.with_pixels));
  if (counts_.outdated != 0)
    all.push_back(fmt::format(
        "{}: {} records of an MRPT older than 1.4 are left out: write it anew with rawlog-edit",
        name_, counts_.outdated));
  if (!counts_.other_classes.empty())
    all.push_back(fmt::format("{}: records of other classes are not used: {}", name_,
                              fmt::join(counts_.other_classes, ", ")));
  return all;
}

}  // namespace cf
