// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/temp_folder.h"

namespace cf {

/// One real flight through the programs as a user runs them.
class RealFlight : public ::testing::Test {
 protected:
  using Json = nlohmann::json;

  /// False, with the test marked as skipped, where the photos are not there.
  bool have(const std::string& flight) {
    data_ = std::filesystem::path(CF_REAL_DATA) / flight;
    if (std::filesystem::exists(data_ / "images")) return true;
    [this] { GTEST_SKIP() << data_ << " is not there (set CF_REAL_DATA)"; }();
    return false;
  }
  void import(const std::string& arguments) {
    expectDone(binDir() + "/cf-import " + arguments + " -o '" + (folder_ / "in").string() + "'");
  }
  void play(const std::string& settings) {
    expectDone(binDir() + "/cf-run '" + (folder_ / "in/config.ini").string() + "' -o '" +
               outdir().string() + "' " + settings);
    report_ = Json::parse(support::fileText(outdir() / "report.json"));
  }
  /// cf-eval WHAT OUTDIR reference/
  Json evaluate(const std::string& what, const std::string& arguments) {
    return evaluateWith(what, data_ / "reference", arguments);
  }
  /// cf-eval WHAT OUTDIR REFERENCE
  Json evaluateWith(const std::string& what, const std::filesystem::path& reference,
                    const std::string& arguments) {
    const auto r = support::runCommand(binDir() + "/cf-eval " + what + " '" + outdir().string() +
                                       "' '" + reference.string() + "' " + arguments);
    EXPECT_EQ(r.status, 0) << r.output;
    const Json json = Json::parse(r.output, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << r.output;
    return json;
  }
  std::filesystem::path outdir() const { return folder_ / "out"; }
  std::string images() const { return "'" + (data_ / "images").string() + "'"; }
  static std::string binDir() { return CF_BIN_DIR; }

  std::filesystem::path data_;
  support::TempFolder folder_;
  Json report_;

 private:
  static void expectDone(const std::string& command) {
    const auto r = support::runCommand(command);
    ASSERT_EQ(r.status, 0) << command << "\n" << r.output;
  }
};

}  // namespace cf
