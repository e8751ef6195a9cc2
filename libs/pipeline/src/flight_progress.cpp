// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "flight_progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "cf/base/stopwatch.h"

namespace cf {
namespace {

constexpr double kTerminalPause_s = 1, kPlainPause_s = 30;
constexpr std::size_t kLately = 10;  // photos

struct Size {
  std::size_t rows = 24, columns = 80;
};

Size terminalSize() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_col == 0)
    return {};
  return {size.ws_row, size.ws_col};
}

/// What fits, each line on one row.
std::vector<std::string> fitted(std::vector<std::string> lines) {
  const Size size = terminalSize();
  const std::size_t most = std::max<std::size_t>(2, size.rows) - 1;
  if (lines.size() > most) {
    const std::size_t hidden = lines.size() - (most - 1);
    lines.resize(most - 1);
    lines.push_back(fmt::format("and {} more UAVs", hidden));
  }
  for (std::string& line : lines) line.resize(std::min(line.size(), size.columns - 1));
  return lines;
}

}  // namespace

FlightProgress::FlightProgress(const StepSource& source, bool in_real_time)
    : terminal_(isatty(STDERR_FILENO) != 0),
      in_real_time_(in_real_time),
      printed_s_(wallSeconds()) {
  for (const SeamHello& hello : source.hellos()) {
    of_uav_[hello.uav] = uavs_.size();
    Uav& uav = uavs_.emplace_back();
    uav.name = hello.name;
    uav.known = hello.photos.value_or(0);
  }
}

FlightProgress::~FlightProgress() {
  if (std::any_of(uavs_.begin(), uavs_.end(), [](const Uav& uav) { return uav.photos > 0; }))
    print(true);
}

void FlightProgress::advance(const SourceStep& step) {
  if (!step.photo) return;
  const double now = wallSeconds();
  Uav& uav = uavs_[of_uav_.at(step.step.uav)];
  ++uav.photos;
  uav.lately_s.push_back(now);
  if (uav.lately_s.size() > kLately) uav.lately_s.pop_front();
  if (!step.step.keyframes.empty()) uav.inliers = step.step.keyframes.back().keyframe->inliers;
  if (step.step.segments && !step.step.segments->empty()) {
    const GeoSegment& newest = step.step.segments->back();
    uav.scale = newest.georeferenced
                    ? fmt::format("{:.4g} +- {:.2g}", newest.scale, newest.scale_sigma)
                    : "-";
  }
  if (in_real_time_) uav.lag_s = std::max(0.0, now - step.taken_s);
  if (now - printed_s_ < (terminal_ ? kTerminalPause_s : kPlainPause_s)) return;
  printed_s_ = now;
  print(false);
}

std::vector<std::string> FlightProgress::lines() const {
  std::size_t widest = 0;
  for (const Uav& uav : uavs_) widest = std::max(widest, uav.name.size());
  std::vector<std::string> lines;
  for (const Uav& uav : uavs_) {
    const std::string photos =
        uav.known > 0 ? fmt::format("{}/{}", uav.photos, uav.known) : std::to_string(uav.photos);
    const double span = uav.lately_s.empty() ? 0 : uav.lately_s.back() - uav.lately_s.front();
    const std::string rate =
        span > 0 ? fmt::format("{:.2f}/s", static_cast<double>(uav.lately_s.size() - 1) / span)
                 : "-";
    lines.push_back(fmt::format("{:<{}}  {:>7} photos  {:>7}  scale {}  inliers {}  lag {}",
                                uav.name, widest, photos, rate, uav.scale,
                                uav.inliers ? std::to_string(*uav.inliers) : "-",
                                uav.lag_s ? fmt::format("{:.1f} s", *uav.lag_s) : "-"));
  }
  return lines;
}

/// On a terminal the cursor rests above the lines, so that a line of the log replaces them
/// (cf/base/log.h) and they appear below it the next time.
void FlightProgress::print(bool last) {
  std::string text = terminal_ ? "\r\033[J" : "";
  const std::vector<std::string> all = terminal_ ? fitted(lines()) : lines();
  for (const std::string& line : all) text += line + "\n";
  if (terminal_ && !last) text += fmt::format("\033[{}A", all.size());
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace cf
