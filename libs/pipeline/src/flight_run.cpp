// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/pipeline/flight_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "central_node.h"
#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/deliver/deliver.h"
#include "cf/rawlog/rawlog_writer.h"
#include "cf/view/render.h"
#include "chain_steps.h"
#include "dense_mapping.h"
#include "dense_matching.h"
#include "free_memory.h"
#include "ground_survey.h"
#include "judgement.h"
#include "memory_plan.h"
#include "memory_trace.h"
#include "output_folder.h"
#include "photo_store.h"
#include "playback.h"
#include "seam_steps.h"
#include "thread_limit.h"
#include "world.h"

namespace cf {
namespace fs = std::filesystem;
namespace {

/// Everything between the configuration and the record of the run.
class FlightRun {
 public:
  FlightRun(const Config& config, const RunOptions& options, const FlightRunRequest& request)
      : options_(options), request_(request) {
    record_.version = request.version;
    for (const UavOptions& uav : options.uavs)
      photo_folders_.push_back(imagesFolderOf(config.resolve(uav.rawlog)));
    if (!options.gcp.file.empty()) survey_.emplace(config.resolve(options.gcp.file), options.gcp);
    if (request.seam.empty())
      playRecordings(config);
    else
      followAgents();
    for (const SeamHello& hello : source_->hellos()) {
      for (const std::string& warning : hello.warnings) warn(record_, hello.name + ": " + warning);
      if (hello.photos == 0U && options_.playback.follow_s == 0)
        warn(record_, hello.name + ": it has no photo");
    }
    if (photos() == 0) throw RunError("no UAV of the configuration has a photo");
    if (!world_.frame && !(survey_ && survey_->controls()))
      warn(record_,
           "no photo has a GNSS position: the map is relative, its place, heading and scale "
           "arbitrary");
    size_.photos = photos();
    memory_plan_ = planMemory(options, size_);
    const std::string objection = objectionTo(memory_plan_, options, size_);
    if (objection.empty()) return;
    if (options.system.max_memory_mb > 0) throw UsageError(objection);
    warn(record_, objection);
  }

  std::size_t photos() const { return source_->photoCount(); }

  RunRecord run() {
    started_s_ = wallSeconds();
    const WorkFolders folders{request_.outdir, workFolder(request_.outdir)};
    PhotoStore store(folders.work / "photos", memory_plan_.photos_in_memory);
    DenseMatching matching(folders.work / "depth", options_.densify, store, times_);
    Alignment alignment = localise(store, folders);
    if (survey_) survey_->apply(world_, alignment, record_);
    record_.world = world_.record;
    mapDensely(photos_, alignment, world_.grid, options_, memory_plan_, folders, matching, store,
               times_, [&](const DenseSummary& dense) {
                 judge(alignment, record_);
                 collect(dense);
                 if (matching.found() > 0)
                   logInfo(fmt::format("densify: {} pairs were there already", matching.found()));
                 deliverAll(dense);
               });
    stopTheClock();
    writeReportJson(record_, request_.outdir);
    if (options_.deliver.html) writeReportHtml(record_, request_.outdir);
    fs::remove_all(folders.work);  // last of all: while it is there, the run can be resumed
    return std::move(record_);
  }

 private:
  void playRecordings(const Config& config) {
    std::vector<UavInput> inputs;
    for (std::size_t u = 0; u < options_.uavs.size(); ++u)
      inputs.emplace_back(config, options_, static_cast<std::uint16_t>(u));
    PhotoFeed feed(std::move(inputs), options_.playback);
    if (feed.follows())
      feed.awaitStart(centralUav(options_));
    else if (survey_)
      survey_->checkPhotos(feed.inputs());
    std::vector<std::optional<GnssFix>> first_fixes;
    for (const UavInput& input : feed.inputs()) {
      first_fixes.push_back(input.firstFix());
      for (const UavInput::Waiting& waiting : input.photos()) size_.add(waiting.photo);
    }
    world_ = placeWorld(options_, first_fixes);
    source_ = std::make_unique<ChainSteps>(std::move(feed), options_, world_.frame, times_);
  }

  void followAgents() {
    auto agents = std::make_unique<SeamSteps>(request_.seam, options_);
    std::vector<std::optional<GnssFix>> first_fixes;
    for (const SeamHello& hello : agents->hellos()) first_fixes.push_back(hello.first_fix);
    world_ = placeWorld(options_, first_fixes);
    if (world_.frame) agents->requireOrigin(world_.frame->origin());
    source_ = std::move(agents);
  }

  /// All photos through their UAVs' chains to the centre.
  Alignment localise(PhotoStore& store, const WorkFolders& folders) {
    photos_.resize(options_.uavs.size());
    const std::uint16_t center = centralUav(options_);
    CentralNode centre(options_.align, center, photos_.size(), store, times_);
    std::optional<LiveMap> live;
    if (options_.playback.inRealTime() || options_.view.live_every_s > 0)
      live.emplace(options_, center, photos_, folders.work / "live-tiles", folders.outdir / "live",
                   store, times_);
    playFlight(*source_, options_.playback, memory_plan_, centre, live ? &*live : nullptr, photos_,
               photo_times_);
    for (auto& of_uav : photos_)
      for (ImageFrame& photo : of_uav)
        if (photo.file.empty()) photo.file = store.file(photo.id);
    record_.warnings.insert(record_.warnings.end(), source_->warnings().begin(),
                            source_->warnings().end());
    if (live) judgeLive(*live);
    record_.bytes_over_seam = source_->bytes();
    std::vector<SeamDone> done = source_->done();
    source_.reset();  // chains and all that they remember
    Alignment alignment = centre.finish();
    if (options_.deliver.handover || options_.deliver.html)
      record_.sparse_pixels = centre.pixelsOf(alignment.points);
    for (std::size_t u = 0; u < done.size(); ++u) {
      UavRecord& uav = record_.uavs.emplace_back();
      uav.name = options_.uavs[u].name;
      uav.photos = std::move(done[u].photos);
      uav.local_trajectory = std::move(done[u].local_trajectory);
      uav.scale_history = std::move(done[u].scale_history);
      uav.gnss = done[u].gnss;
      uav.segments = done[u].segments;
      uav.pose_graph = std::move(done[u].pose_graph);
      uav.online_trajectory = centre.onlineTrajectories()[u];
      uav.camera_before = centre.cameras()[u];
      uav.photo_folder = photo_folders_[u];
      for (const auto& [id, fix] : centre.fixes())
        if (id.uav == u) uav.fixes[id.index] = fix;
      if (options_.playback.follow_s > 0 && uav.photos.empty())
        warn(record_, uav.name + ": it has no photo");
    }
    return alignment;
  }

  /// What a watcher has seen of the flight, and whether we kept up with it.
  void judgeLive(const LiveMap& live) {
    shown_s_ = live.shown();
    if (!options_.playback.inRealTime()) return;
    record_.real_time = RealTimeRecord{source_->mostBehind_s(), live.leftOut()};
    if (source_->mostBehind_s() > 1)
      warn(record_,
           fmt::format("playback could not keep up: photos were taken up {:.1f} s late at worst",
                       source_->mostBehind_s()));
    if (live.leftOut() > 0)
      warn(record_,
           fmt::format("the live map left out {} photos that were more than {:.0f} s late; the "
                       "final map has them",
                       live.leftOut(), options_.playback.max_lag_s));
  }

  void collect(const DenseSummary& dense) {
    for (const auto& [id, finished] : dense.finished_s) {
      const auto shown = shown_s_.find(id);
      const double taken_s = photo_times_.of(id).taken_s;
      record_.latencies.push_back({id, taken_s - started_s_,
                                   (shown == shown_s_.end() ? finished : shown->second) - taken_s});
    }
    record_.cloud = dense.cloud;
    record_.self_check = selfCheck(record_);
    for (const auto& [code, count] : dense.failures)
      logInfo(fmt::format("densify: {} pairs without depth: {}", count, code));
  }

  void deliverAll(const DenseSummary& dense) {
    stopTheClock();
    deliver(record_, request_.outdir, options_.deliver);
    if (!options_.view.snapshots) return;
    if (dense.points == 0) {
      warn(record_, "no snapshots: the dense cloud is empty");
    } else {
      const StageTimes::Scope scope(times_, "view", CpuClock::kProcess);
      releaseFreeMemory();
      renderRun(request_.outdir, parseImageSize(options_.view.size), memory_plan_.side_by_side);
    }
  }

  void stopTheClock() {
    record_.stages = times_.all();
    record_.peak_rss_mb = peakRssMegabytes();
    record_.wall_s = wallSeconds() - started_s_;
    record_.memory = memory_.samples();
  }

  const RunOptions& options_;
  const FlightRunRequest& request_;
  StageTimes times_;
  MemoryTrace memory_;
  double started_s_ = 0;
  FlightSize size_;
  MemoryPlan memory_plan_;
  World world_;
  std::optional<GroundSurvey> survey_;
  std::vector<fs::path> photo_folders_;  ///< by UAV
  std::unique_ptr<StepSource> source_;
  std::vector<std::vector<ImageFrame>> photos_;  ///< by UAV
  PhotoTimes photo_times_;
  std::map<FrameId, double> shown_s_;  ///< wall time of a photo in the live map
  RunRecord record_;
};

}  // namespace

RunRecord runFlight(Config& config, const FlightRunRequest& request) {
  const RunOptions options = loadRunOptions(config);
  checkOutput(request, config, options);
  const ThreadLimit limit(options);
  FlightRun run(config, options, request);
  prepareOutput(request, config, options, run.photos());
  return run.run();
}

}  // namespace cf
