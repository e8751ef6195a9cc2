// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace cf {

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      printed_(start_) {}

Progress::~Progress() {
  if (done_ > 0) print({}, true);
}

void Progress::advance(const std::string& note) {
  ++done_;
  const auto pause = terminal_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(5000);
  const auto now = Clock::now();
  if (now - printed_ < pause) return;
  printed_ = now;
  print(note, false);
}

void Progress::print(const std::string& note, bool last) {
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  const double rate = elapsed > 0 ? static_cast<double>(done_) / elapsed : 0;
  const double left = rate > 0 && total_ > done_ ? static_cast<double>(total_ - done_) / rate : 0;
  const std::string line =
      fmt::format("{} {}/{}  {:.2f}/s  {}{}{}", what_, done_, total_, rate,
                  last ? fmt::format("{:.1f} s", elapsed) : fmt::format("{:.0f} s left", left),
                  note.empty() ? "" : "  ", note);
  if (terminal_)
    std::fprintf(stderr, "\r%s\033[K%s", line.c_str(), last ? "\n" : "");
  else
    std::fprintf(stderr, "%s\n", line.c_str());
}

}  // namespace cf
