// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/temp_folder.h"

namespace cf {

/// What a figure of `cf-eval run`, named by its JSON pointer, has to keep to. "/report/…" is a
/// figure of the run's report.json.
struct Limit {
  std::string figure;
  double lowest;
  double highest;
};
inline Limit exactly(const std::string& figure, double value) { return {figure, value, value}; }
inline Limit atLeast(const std::string& figure, double value) {
  return {figure, value, std::numeric_limits<double>::infinity()};
}
/// The magnitude of an error, signed or not.
inline Limit within(const std::string& figure, double limit) { return {figure, -limit, limit}; }
inline Limit within(const std::string& figure, double limit, double about) {
  return {figure, about - limit, about + limit};
}

/// One simulated flight through the programs as a user runs them: cf-simulate, cf-run, cf-eval.
class AccuracyScene : public ::testing::Test {
 protected:
  /// Flies tests/accuracy/<name>.ini, maps it, and holds every figure to its limit.
  void hold(const std::string& name, const std::vector<Limit>& limits) {
    const nlohmann::json figures = fly(name);
    if (figures.is_null()) return;
    fmt::print("{:<52}{:>12}   allowed\n", name, "reached");
    for (const Limit& limit : limits) {
      const nlohmann::json::json_pointer where(limit.figure);
      const nlohmann::json value = figures.contains(where) ? figures.at(where) : nullptr;
      const double reached = value.is_number() ? value.get<double>() : std::nan("");
      const bool kept = reached >= limit.lowest && reached <= limit.highest;
      const std::string line = fmt::format("{:<52}{:>12.5g}   {}{}", limit.figure, reached,
                                           allowed(limit), kept ? "" : "   FAILED");
      fmt::print("{}\n", line);
      EXPECT_TRUE(kept) << line;
    }
    std::fflush(stdout);
    if (HasFailure()) fmt::print("missing: {}\n", figures["missing"].dump());
  }

 private:
  static std::string allowed(const Limit& limit) {
    if (limit.lowest == limit.highest) return fmt::format("{:g}", limit.highest);
    if (limit.lowest == -limit.highest) return fmt::format("within {:g}", limit.highest);
    if (std::isinf(limit.highest)) return fmt::format("at least {:g}", limit.lowest);
    return fmt::format("{:g} to {:g}", limit.lowest, limit.highest);
  }
  /// What a program prints, unless one has failed before.
  static std::string run(const std::string& command) {
    if (HasFailure()) return "";
    const auto done = support::runCommand(command);
    EXPECT_EQ(done.status, 0) << command << "\n" << done.output;
    return done.output;
  }
  /// All figures, the report among them; null where a program failed.
  nlohmann::json fly(const std::string& name) {
    const std::string bin = CF_BIN_DIR, flight = (folder_ / name).string();
    const std::string out = flight + "/results";
    run(bin + "/cf-simulate '" CF_SOURCE_DIR "/tests/accuracy/" + name + ".ini' -o '" + flight +
        "'");
    run(bin + "/cf-run '" + flight + "/config.ini' -o '" + out +
        "' -s deliver.depth_maps=true -s deliver.html=false -s view.snapshots=false");
    const std::string text = run(bin + "/cf-eval run '" + out + "' '" + flight + "/truth'");
    if (HasFailure()) return nullptr;
    auto figures = nlohmann::json::parse(text);
    figures["report"] = nlohmann::json::parse(support::fileText(out + "/report.json"));
    return figures;
  }

  support::TempFolder folder_;
};

}  // namespace cf
