// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// The program itself: exit status, one line of error, JSON on stdout.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "cf/formats/atomic_file.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int status = -1;
  std::string out, err;
};

Outcome run(const std::string& arguments) {
  const fs::path out = fs::path(testing::TempDir()) / "cf_eval.out";
  const fs::path err = fs::path(testing::TempDir()) / "cf_eval.err";
  const std::string command = std::string(CF_BIN_DIR) + "/cf-eval " + arguments + " >" +
                              out.string() + " 2>" + err.string();
  const auto text = [](const fs::path& path) {
    std::ifstream in(path);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  const int raw = std::system(command.c_str());
  return {WIFEXITED(raw) ? WEXITSTATUS(raw) : -1, text(out), text(err)};
}

void expectOneLine(const Outcome& outcome, int status, const std::string& naming) {
  EXPECT_EQ(outcome.status, status) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find(naming), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out, "");
}

TEST(CfEval, ATrajectoryAgainstItself) {
  const fs::path tum = fs::path(testing::TempDir()) / "cf_eval.tum";
  writeFileAtomically(tum, "1 0 0 5 0 0 0 1\n2 9 0 5 0 0 0 1\n3 9 9 5 0 0 0 1\n4 0 9 6 0 0 0 1\n");
  for (const char* align : {"none", "se3", "sim3", "yaw4"}) {
    const Outcome outcome =
        run("trajectory " + tum.string() + " " + tum.string() + " --align " + align);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(json["matched"], 4);
    EXPECT_EQ(json["align"], align);
    EXPECT_NEAR(json["rmse_m"].get<double>(), 0, 1e-9);
  }
}

TEST(CfEval, ErrorsAreOneLineWithTheRightStatus) {
  const fs::path bad = fs::path(testing::TempDir()) / "cf_eval_bad.tum";
  writeFileAtomically(bad, "nonsense\n");
  expectOneLine(run(""), 2, "subcommand");
  expectOneLine(run("cloud x.ply y.ply --gsd -1"), 2, "gsd");
  expectOneLine(run("trajectory /nonexistent /nonexistent"), 2, "/nonexistent");
  expectOneLine(run("trajectory " + bad.string() + " " + bad.string() + " --align sim4"), 2,
                "sim4");
  expectOneLine(run("trajectory " + bad.string() + " " + bad.string()), 1, "cf_eval_bad.tum");
  expectOneLine(run("cloud " + bad.string() + " " + bad.string()), 1, "cf_eval_bad.tum");
  expectOneLine(run("run /nonexistent /nonexistent --table"), 2, "/nonexistent");
  expectOneLine(run("run / /"), 1, "images.tsv");
  expectOneLine(run("gcp / " + bad.string() + " --size 40x"), 2, "size");
  expectOneLine(run("gcp / " + bad.string()), 2, "marks no point");
  EXPECT_EQ(run("--help").status, 0);
  EXPECT_EQ(run("--version").status, 0);
}

}  // namespace
}  // namespace cf
