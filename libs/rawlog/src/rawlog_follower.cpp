// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/rawlog/rawlog_follower.h"

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <utility>

#include "rawlog_records.h"
#include "recording_builder.h"

namespace cf {
namespace {

/// From here on it can be told whether it is compressed.
constexpr std::uintmax_t kLeastBytes = 16;
constexpr TimeNs kNever = std::numeric_limits<TimeNs>::min();

}  // namespace

struct RawlogFollower::Impl {
  std::filesystem::path rawlog;
  RecordingBuilder builder;
  std::optional<RawlogRecords> records;
  TimeNs known_until = kNever;

  void read() {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(rawlog, error);
    if (!records && (error || bytes < kLeastBytes)) return;
    if (!records) records.emplace(rawlog);
    while (const auto record = records->next()) builder.add(record);
  }
};

RawlogFollower::RawlogFollower(std::filesystem::path rawlog, RawlogLabels labels)
    : impl_(new Impl{rawlog, RecordingBuilder(rawlog, std::move(labels)), {}, kNever}) {}

RawlogFollower::~RawlogFollower() = default;
RawlogFollower::RawlogFollower(RawlogFollower&&) noexcept = default;

UavRecording RawlogFollower::poll() {
  impl_->read();
  const std::optional<TimeNs> newest = impl_->builder.newest();
  if (!newest) return {};
  impl_->known_until = *newest - 1;
  return impl_->builder.take(impl_->known_until);
}

UavRecording RawlogFollower::finish() {
  impl_->read();
  impl_->known_until = std::numeric_limits<TimeNs>::max();
  UavRecording recording = impl_->builder.finish();
  std::vector<std::string> warnings;
  if (impl_->records && !impl_->records->counts().empty())
    warnings = impl_->records->warnings(ended());
  else
    warnings.push_back(
        fmt::format("{} {}", impl_->rawlog.filename().string(),
                    impl_->records ? "is no rawlog, or an empty one" : "has not come"));
  recording.warnings.insert(recording.warnings.begin(), warnings.begin(), warnings.end());
  return recording;
}

std::size_t RawlogFollower::records() const {
  return impl_->records ? impl_->records->counts().read : 0;
}
TimeNs RawlogFollower::knownUntil() const { return impl_->known_until; }
bool RawlogFollower::ended() const { return impl_->builder.ended(); }

}  // namespace cf
