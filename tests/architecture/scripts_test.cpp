// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace cf {
namespace {

struct Outcome {
  int status;
  std::string said;  ///< stdout and stderr
};

Outcome runScript(const std::string& arguments) {
  const std::string command = "bash '" CF_SOURCE_DIR "/run.sh' " + arguments + " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {-1, "no shell"};
  Outcome outcome{0, {}};
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe))
    outcome.said += static_cast<char>(c);
  outcome.status = WEXITSTATUS(pclose(pipe));
  return outcome;
}

/// Wrong usage ends with status 2 and one line, before anything is installed or built.
void expectUsageError(const std::string& arguments, const std::string& line) {
  const Outcome outcome = runScript(arguments);
  EXPECT_EQ(outcome.status, 2) << arguments;
  EXPECT_EQ(outcome.said, "run.sh: " + line + "\n") << arguments;
}

TEST(RunScript, namesWhatIsWrongWithItsArguments) {
  expectUsageError("nowhere", "'nowhere' is neither a configuration (.ini) nor a folder of photos");
  expectUsageError("nowhere.ini", "nowhere.ini: no such configuration file");
  expectUsageError("a.ini b.ini", "one configuration at a time: a.ini or b.ini");
  expectUsageError("/tmp nowhere.ini", "give a configuration or folders of photos, not both");
  expectUsageError("/tmp --split", "--split needs a value");
  expectUsageError("--output", "--output needs a value");
}

TEST(RunScript, helps) {
  const Outcome outcome = runScript("--help");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.said.rfind("./run.sh CONFIG.ini", 0), 0U);
}

}  // namespace
}  // namespace cf
