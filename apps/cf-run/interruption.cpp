// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "interruption.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <string>

namespace cf {
namespace {

constexpr int kInterrupted = 130;

/// Made before: a signal's handler may not allocate.
struct Lines {
  std::string folder;  ///< if it is there, something is kept
  std::string kept, nothing;
};
Lines lines;

void say(const std::string& text) {
  if (write(STDERR_FILENO, text.data(), text.size()) < 0) return;
}

extern "C" void interrupted(int) {
  say(access(lines.folder.c_str(), F_OK) == 0 ? lines.kept : lines.nothing);
  _exit(kInterrupted);
}

}  // namespace

void sayWhatAnInterruptionKeeps(const RunArguments& arguments) {
  // In place of progress that may be shown there.
  const std::string begin =
      std::string(isatty(STDERR_FILENO) != 0 ? "\r\033[J" : "") + "cf-run: interrupted: ";
  lines.nothing = begin + "nothing was written yet\n";
  if (arguments.agent) {
    lines.folder = (arguments.agent->seam / (arguments.agent->uav + ".seam")).string();
    lines.kept = fmt::format("{}{} keeps what was sent; the same command with --resume goes on\n",
                             begin, lines.folder);
  } else {
    lines.folder = workFolder(arguments.request.outdir).string();
    lines.kept = fmt::format("{}{} keeps what was done; the same command with --resume goes on\n",
                             begin, arguments.request.outdir.string());
  }
  for (const int number : {SIGINT, SIGTERM}) {
    struct sigaction action {};
    sigaction(number, nullptr, &action);
    if (action.sa_handler == SIG_IGN) continue;  // whoever has started us does not want it
    action.sa_handler = interrupted;
    sigaction(number, &action, nullptr);
  }
}

}  // namespace cf
