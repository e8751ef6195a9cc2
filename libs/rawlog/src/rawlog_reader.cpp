// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/rawlog/rawlog_reader.h"

#include <fmt/format.h>

#include "cf/base/error.h"
#include "rawlog_records.h"
#include "recording_builder.h"

namespace cf {

UavRecording readRecording(const std::filesystem::path& rawlog, const RawlogLabels& labels) {
  RawlogRecords records(rawlog);
  RecordingBuilder builder(rawlog, labels);
  while (const auto record = records.next()) builder.add(record);
  if (records.counts().empty())
    throw RunError(
        fmt::format("{} cannot be read: it is no rawlog, or an empty one", rawlog.string()));
  UavRecording recording = builder.finish();
  std::vector<std::string> warnings = records.warnings(builder.ended());
  recording.warnings.insert(recording.warnings.begin(), warnings.begin(), warnings.end());
  return recording;
}

}  // namespace cf
