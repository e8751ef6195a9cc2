// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "follow_folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <system_error>
#include <thread>

#include "cf/base/disk.h"
#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/base/stopwatch.h"
#include "cf/formats/arriving_file.h"
#include "cf/formats/camera_ini.h"
#include "cf/rawlog/rawlog_writer.h"
#include "flight.h"
#include "photo_files.h"
#include "summary.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr auto kPoll = std::chrono::milliseconds(200);
/// For which a photo waits, so that those that come together are put in order.
constexpr double kSettle_s = 1;
/// A run that follows the rawlogs waits longer than we do: it hears from us that they have ended.
constexpr double kLonger_s = 30;

/// A folder whose photos go into a rawlog as they arrive.
class FollowedFolder {
 public:
  FollowedFolder(std::string name, fs::path folder, const ImportOptions& options,
                 const std::optional<CameraModel>& camera)
      : name_(std::move(name)),
        folder_(std::move(folder)),
        options_(options),
        camera_(camera),
        rawlog_(options.out_dir / (name_ + ".rawlog")) {
    listPhotos(folder_, options.out_dir);  // it is there
    createFolder(imagesFolderOf(rawlog_));
    std::error_code ignored;
    fs::remove(rawlog_, ignored);  // whoever follows an earlier one keeps it
    writer_.emplace(rawlog_, RawlogLabels{"CAMERA", "GPS"}, RawlogWriter::Visible::kAtOnce);
  }

  const fs::path& rawlog() const { return rawlog_; }
  /// Wall time at which a file was last new.
  double grown_s() const { return grown_s_; }

  /// Records what has arrived; `all`: what has not settled, too.
  void look(bool all) {
    const PhotoFiles found = listPhotos(folder_, options_.out_dir);
    others_ = found.others;
    const double now = wallSeconds();
    std::size_t known = tags_.size();
    for (const fs::path& file : found.photos) {
      const auto [arriving, is_new] =
          arriving_.try_emplace(file, Arriving{ArrivingFile(file), now});
      if (is_new) grown_s_ = now;
      if (tags_.count(file) != 0) continue;
      // Those after it by name wait for it.
      if (!arriving->second.file.isWhole() || (!all && now - arriving->second.since_s < kSettle_s))
        break;
      tags_.emplace(file, readPhotoTags(file));
    }
    if (tags_.size() > known) record();
  }

  /// Ends the rawlog and tells of it.
  void finish(ImportSummary& summary) {
    writer_->finish();
    summary.ignored_files += others_;
    for (const auto& [file, arriving] : arriving_)
      if (tags_.count(file) == 0)
        summary.warnings.push_back(file.string() + " was not complete: left out");
    if (tags_.empty()) {
      summary.warnings.push_back(fmt::format("{}: no photo has come", folder_.string()));
      return;
    }
    for (const fs::path& file : late_)
      summary.warnings.push_back(
          fmt::format("{} came after photos that were taken later: left out", file.string()));
    summary.uavs.push_back(describe(flight(summary.warnings), rawlog_));
    summary.uavs.back().photos -= late_.size();
  }

 private:
  struct Arriving {
    ArrivingFile file;
    double since_s;
  };

  /// Of all photos that have arrived.
  Flight flight(std::vector<std::string>& warnings) const {
    TaggedPhotos photos;
    for (const auto& [file, tags] : tags_) photos.files.push_back(file);
    sortNaturally(photos.files);
    for (const fs::path& file : photos.files) photos.tags.push_back(tags_.at(file));
    return flightOf(name_, folder_, std::move(photos), options_, camera_, warnings);
  }

  /// Those of them that the rawlog does not hold yet.
  void record() {
    std::vector<std::string> said_at_the_end;
    for (const ImportedPhoto& photo : flight(said_at_the_end).photos) {
      if (recorded_.count(photo.source) != 0 || late_.count(photo.source) != 0) continue;
      if (photo.frame.time <= last_) {
        late_.insert(photo.source);
        continue;
      }
      ImageFrame frame = photo.frame;
      frame.file = imagesFolderOf(rawlog_) / frame.name;
      linkOrCopy(photo.source, frame.file);
      writer_->write(frame);
      if (photo.fix) writer_->write(*photo.fix);
      writer_->flush();
      last_ = frame.time;
      recorded_.insert(photo.source);
    }
  }

  const std::string name_;
  const fs::path folder_;
  const ImportOptions& options_;
  const std::optional<CameraModel>& camera_;
  const fs::path rawlog_;
  std::optional<RawlogWriter> writer_;
  std::map<fs::path, Arriving> arriving_;  ///< all files ever seen
  std::map<fs::path, PhotoTags> tags_;     ///< of those that are whole
  std::set<fs::path> recorded_, late_;
  TimeNs last_ = std::numeric_limits<TimeNs>::min();
  std::size_t others_ = 0;
  double grown_s_ = wallSeconds();
};

/// Until nothing new has come for long enough, or somebody has had enough.
void followUntilTheEnd(std::deque<FollowedFolder>& folders, const ImportOptions& options) {
  while (!(options.stop && options.stop())) {
    double grown_s = 0;
    for (FollowedFolder& folder : folders) {
      folder.look(false);
      grown_s = std::max(grown_s, folder.grown_s());
    }
    if (wallSeconds() - grown_s >= options.follow_s + kSettle_s) break;
    std::this_thread::sleep_for(kPoll);
  }
  for (FollowedFolder& folder : folders) folder.look(true);
}

}  // namespace

ImportSummary followFolders(const ImportOptions& options) {
  if (!options.split.empty() || !options.geo.empty())
    throw UsageError("--follow_s takes photos as they come: --split and --geo need all of them");
  std::optional<CameraModel> camera;
  if (!options.camera.empty()) camera = readCameraIni(options.camera);
  createFolder(options.out_dir);
  const std::vector<std::string> names = uavNames(options.images);
  std::deque<FollowedFolder> folders;
  std::vector<fs::path> rawlogs;
  for (std::size_t i = 0; i < options.images.size(); ++i) {
    folders.emplace_back(names[i], options.images[i], options, camera);
    rawlogs.push_back(folders.back().rawlog());
  }
  ImportSummary summary;
  summary.config = options.out_dir / "config.ini";
  writeConfig(rawlogs, options.follow_s + kLonger_s, summary.config);
  logInfo(fmt::format("following, for cf-run {} beside it; Ctrl-C ends it in good order",
                      summary.config.string()));
  followUntilTheEnd(folders, options);
  for (FollowedFolder& folder : folders) folder.finish(summary);
  return summary;
}

}  // namespace cf
