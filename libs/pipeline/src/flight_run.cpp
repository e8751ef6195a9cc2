// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/pipeline/flight_run.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <deque>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <thread>

#include "central_node.h"
#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/deliver/deliver.h"
#include "cf/formats/camera_ini.h"
#include "cf/geodesy/grid_frame.h"
#include "cf/geodesy/local_frame.h"
#include "cf/rawlog/rawlog_reader.h"
#include "cf/view/render.h"
#include "dense_mapping.h"
#include "dense_matching.h"
#include "gnss_disagreement.h"
#include "output_folder.h"
#include "photo_store.h"
#include "playback.h"
#include "uav_chain.h"
#include "unjoined_parts.h"

namespace cf {
namespace fs = std::filesystem;
namespace {

/// Of 3 MP each, 9 MB: the neighbours in the strips that are being matched.
constexpr std::size_t kPhotosInMemory = 12;

UavRecording readUav(const Config& config, const UavOptions& options, std::uint16_t uav) {
  const fs::path rawlog = config.resolve(options.rawlog);
  UavRecording recording = readRecording(rawlog, {options.image_label, options.gnss_label});
  if (!options.sigma.empty()) {
    const auto sigma = parseNumbers(options.sigma, 2, "[uav." + options.name + "] sigma");
    for (GnssFix& fix : recording.fixes) fix.sigma_enu_m = {sigma[0], sigma[0], sigma[1]};
  }
  std::optional<CameraModel> camera;
  if (!options.camera.empty()) camera = readCameraIni(config.resolve(options.camera));
  for (ImageFrame& photo : recording.photos) {
    photo.id.uav = uav;
    if (camera)
      photo.camera = photo.camera.width > 0
                         ? camera->scaled(photo.camera.width, photo.camera.height)
                         : *camera;
    if (!(photo.camera.fx > 0) || photo.camera.width <= 0 || photo.camera.height <= 0)
      throw UsageError(fmt::format("{}: photo {} has no calibration: give [uav.{}] camera = FILE",
                                   rawlog.string(), photo.name, options.name));
  }
  return recording;
}

/// Everything between the configuration and the record of the run.
class FlightRun {
 public:
  FlightRun(const Config& config, const RunOptions& options, const FlightRunRequest& request)
      : options_(options), request_(request) {
    record_.version = request.version;
    for (std::size_t u = 0; u < options.uavs.size(); ++u) {
      const UavOptions& uav = options.uavs[u];
      recordings_.push_back(readUav(config, uav, static_cast<std::uint16_t>(u)));
      for (const std::string& warning : recordings_.back().warnings)
        warn(uav.name + ": " + warning);
      if (recordings_.back().photos.empty()) warn(uav.name + ": the rawlog holds no photo");
      if (uav.name == options.cluster.center) center_ = static_cast<std::uint16_t>(u);
      photos_.push_back(recordings_.back().photos);
    }
    if (photos() == 0) throw RunError("no rawlog of the configuration holds a photo");
    placeWorld();
  }

  std::size_t photos() const {
    std::size_t count = 0;
    for (const auto& of_uav : photos_) count += of_uav.size();
    return count;
  }

  RunRecord run() {
    const double started = wallSeconds();
    const WorkFolders folders{request_.outdir, workFolder(request_.outdir)};
    PhotoStore store(folders.work / "photos", kPhotosInMemory);
    DenseMatching matching(folders.work / "depth", options_.densify, store, times_);
    const Alignment alignment = localise(store, folders);
    const DenseSummary dense =
        mapDensely(photos_, alignment, grid_, options_, folders, matching, store, times_);
    collect(alignment, dense);
    if (matching.found() > 0)
      logInfo(fmt::format("densify: {} pairs were there already", matching.found()));
    record_.wall_s = wallSeconds() - started;
    deliverAll(dense);
    fs::remove_all(folders.work);  // last of all: while it is there, the run can be resumed
    return std::move(record_);
  }

 private:
  void warn(const std::string& line) {
    logWarning(line);
    record_.warnings.push_back(line);
  }

  /// The world's origin: as configured, or the first fix of the central UAV, or of any.
  void placeWorld() {
    const GnssFix* first = nullptr;
    const auto take = [&](std::size_t u) {
      for (const GnssFix& fix : recordings_[u].fixes)
        if (first == nullptr || fix.time < first->time) first = &fix;
    };
    take(center_);
    for (std::size_t u = 0; first == nullptr && u < recordings_.size(); ++u) take(u);
    record_.world.center = options_.uavs[center_].name;
    if (first == nullptr) {
      record_.world.relative = true;
      warn(
          "no photo has a GNSS position: the map is relative, its place, heading and scale "
          "arbitrary");
      return;
    }
    Geodetic origin{first->latitude_deg, first->longitude_deg, first->height_m};
    if (!options_.world.origin.empty()) {
      const auto p = parseNumbers(options_.world.origin, 3, "[world] origin");
      origin = {p[0], p[1], p[2]};
    }
    world_.emplace(origin);
    record_.world.latitude_deg = origin.latitude_deg;
    record_.world.longitude_deg = origin.longitude_deg;
    record_.world.height_m = origin.height_m;
    record_.world.h_datum = first->datum;
    record_.world.utm = world_->utmZone();
    grid_ = GridFrame(*world_, first->datum);
  }

  /// All photos through their UAVs' chains to the centre.
  Alignment localise(PhotoStore& store, const WorkFolders& folders) {
    std::deque<UavChain> chains;
    std::vector<CameraModel> cameras;
    for (std::size_t u = 0; u < recordings_.size(); ++u) {
      const auto& all = recordings_[u].photos;
      cameras.push_back(all.empty() ? CameraModel{} : all.front().camera);
      chains.emplace_back(recordings_[u], options_.uavs[u].name, static_cast<std::uint16_t>(u),
                          world_, options_, times_);
    }
    CentralNode centre(options_.align, center_, cameras, store, times_);
    std::optional<LiveMap> live;
    if (options_.playback.rate > 0 || options_.view.live_every_s > 0)
      live.emplace(options_, center_, photos_, folders.work / "live-tiles", folders.outdir / "live",
                   store, times_);
    played_ = playFlight(recordings_, chains, options_.playback, centre, live ? &*live : nullptr);
    if (live) judgeLive(*live);
    Alignment alignment = centre.finish();
    record_.bytes_over_seam = centre.bytesReceived();
    for (std::size_t u = 0; u < chains.size(); ++u) {
      record_.uavs.push_back(chains[u].record());
      record_.uavs.back().online_trajectory = centre.onlineTrajectories()[u];
      record_.uavs.back().camera_before = cameras[u];
    }
    return alignment;
  }

  /// What a watcher has seen of the flight, and whether we kept up with it.
  void judgeLive(const LiveMap& live) {
    shown_s_ = live.shown();
    if (options_.playback.rate <= 0) return;
    if (played_.most_behind_s > 1)
      warn(fmt::format("playback could not keep up: photos were taken up {:.1f} s late at worst",
                       played_.most_behind_s));
    if (live.leftOut() > 0)
      warn(
          fmt::format("the live map left out {} photos that were more than {:.0f} s late; the "
                      "final map has them",
                      live.leftOut(), options_.playback.max_lag_s));
  }

  void collect(const Alignment& alignment, const DenseSummary& dense) {
    record_.components = alignment.components;
    record_.relative_poses = alignment.relative_poses;
    record_.sparse_points = alignment.points;
    for (std::size_t u = 0; u < record_.uavs.size(); ++u) {
      UavRecord& uav = record_.uavs[u];
      for (std::uint32_t i = 0; i < uav.photos.size(); ++i)
        settle(uav, {static_cast<std::uint16_t>(u), i}, alignment);
      for (const auto& [id, finished] : dense.finished_s)
        if (id.uav == u) {
          const auto shown = shown_s_.find(id);
          record_.latencies_s.push_back((shown == shown_s_.end() ? finished : shown->second) -
                                        played_.taken_s[u][id.index]);
        }
      uav.camera_after = alignment.table.cameras[u];
      const auto bias = alignment.gnss_bias_m.find(static_cast<std::uint16_t>(u));
      if (bias != alignment.gnss_bias_m.end()) uav.gnss.bias_m = bias->second;
      if (world_ && uav.gnss.fixes > 0 && !uav.gnss.trusted)
        warn(
            fmt::format("{}: its GNSS is not trusted: residuals of {:.1f} m horizontally and "
                        "{:.1f} m vertically against the photos",
                        uav.name, uav.gnss.sigma_m.head<2>().norm(), uav.gnss.sigma_m.z()));
    }
    for (const std::string& line : gnssDisagreements(record_.uavs)) warn(line);
    if (alignment.components > 1)
      warn(fmt::format("the photos form {} parts that no match joins: only GNSS ties them together",
                       alignment.components));
    for (const std::string& line : unjoinedParts(record_.uavs, alignment.table)) warn(line);
    for (const auto& [code, count] : dense.failures)
      logInfo(fmt::format("densify: {} pairs without depth: {}", count, code));
  }

  void settle(UavRecord& uav, FrameId id, const Alignment& alignment) const {
    PhotoRecord& photo = uav.photos[id.index];
    if (photo.status == PhotoStatus::kDamaged) return;
    const auto entry = alignment.table.poses.find(id);
    if (entry != alignment.table.poses.end()) {
      photo.status = PhotoStatus::kPosed;
      uav.final_trajectory.push_back({id.index, entry->second.T_world_cam});
      if (!entry->second.covariance.in_world.isZero(0))
        uav.covariances[id.index] = {entry->second.component, entry->second.covariance};
      return;
    }
    const auto alone = std::count_if(uav.photos.begin(), uav.photos.end(),
                                     [&](const auto& p) { return p.segment == photo.segment; });
    photo.status = alone > 1 ? PhotoStatus::kUnjoined : PhotoStatus::kUnposed;
    photo.reason =
        alone > 1 ? "its part of the flight is not tied to the map by matches or GNSS"
                  : fmt::format("{} matches to other photos, too few that agree", photo.matches);
  }

  void deliverAll(const DenseSummary& dense) {
    record_.stages = times_.all();
    record_.peak_rss_mb = peakRssMegabytes();
    deliver(record_, request_.outdir, options_.deliver);
    if (!options_.view.snapshots) return;
    if (dense.points == 0) {
      warn("no snapshots: the dense cloud is empty");
    } else {
      const StageTimes::Scope scope(times_, "view", CpuClock::kProcess);
      renderRun(request_.outdir, parseImageSize(options_.view.size));
    }
    // Once more, with the pictures and their cost.
    record_.stages = times_.all();
    record_.peak_rss_mb = peakRssMegabytes();
    writeReportJson(record_, request_.outdir);
    if (options_.deliver.html) writeReportHtml(record_, request_.outdir);
  }

  const RunOptions& options_;
  const FlightRunRequest& request_;
  std::vector<UavRecording> recordings_;
  std::uint16_t center_ = 0;
  std::vector<std::vector<ImageFrame>> photos_;  ///< by UAV
  std::optional<LocalFrame> world_;
  GridFrame grid_;
  StageTimes times_;
  Played played_;
  std::map<FrameId, double> shown_s_;  ///< wall time of a photo in the live map
  RunRecord record_;
};

}  // namespace

RunRecord runFlight(Config& config, const FlightRunRequest& request) {
  const RunOptions options = loadRunOptions(config);
  const int threads = options.system.threads > 0
                          ? options.system.threads
                          : static_cast<int>(std::thread::hardware_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(std::max(1, threads)));
  // Photos and pairs are worked on side by side; OpenCV's own threads would only get in the way.
  cv::setNumThreads(options.uavs.size() > 1 ? 1 : threads);
  FlightRun run(config, options, request);
  prepareOutput(request, config, options, run.photos());
  return run.run();
}

}  // namespace cf
