// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "cf/config/config.h"
#include "cf/pipeline/run_options.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::fileText;

const fs::path kDemo = fs::path(CF_SOURCE_DIR) / "config.ini";

/// A row of the reference: | `key` | `default` | allowed | meaning |
struct Row {
  std::string section, key, default_value, allowed, help;
};

std::vector<Row> referenceOf(Config& config) {
  const std::regex cells("\\| `(.*?)` \\| (?:`(.*?)`|\\(empty\\)) \\| (.*?) \\| (.*) \\|");
  std::vector<Row> rows;
  std::istringstream lines(config.referenceMarkdown());
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    std::smatch m;
    if (line.rfind("## [", 0) == 0) section = line.substr(3);
    if (std::regex_match(line, m, cells)) rows.push_back({section, m[1], m[2], m[3], m[4]});
  }
  return rows;
}

bool writtenByHand(const Row& row) {
  return row.section == "[world]" || row.section == "[cluster]" ||
         row.section.rfind("[uav.", 0) == 0;
}

/// The sections after the UAVs, every key commented out with its default.
std::string commentedOut(const std::vector<Row>& rows) {
  std::string text, section;
  for (const Row& row : rows) {
    if (writtenByHand(row)) continue;
    if (row.section != section) text += (text.empty() ? "" : "\n") + row.section + "\n";
    section = row.section;
    text += "; " + row.help + " (" + row.allowed + ")\n;   " + row.key + " =" +
            (row.default_value.empty() ? "" : " " + row.default_value) + "\n";
  }
  return text;
}

TEST(DemoConfig, namesRawlogsThatAreThere) {
  Config config = Config::fromFile(kDemo);
  const RunOptions options = loadRunOptions(config);
  EXPECT_GE(options.uavs.size(), 3U);
  for (const UavOptions& uav : options.uavs) EXPECT_TRUE(fs::exists(uav.rawlog)) << uav.rawlog;
}

/// config.ini shows every key there is. CF_WRITE_REFERENCE=1 writes all but its beginning.
TEST(DemoConfig, showsEveryKeyAsItIs) {
  Config config = Config::fromFile(kDemo);
  loadRunOptions(config);
  const std::vector<Row> rows = referenceOf(config);
  ASSERT_GT(rows.size(), 50U);
  const std::string expected = commentedOut(rows);
  const std::string text = fileText(kDemo);
  const std::size_t begin = text.find("[playback]");
  ASSERT_NE(begin, std::string::npos);
  const std::string head = text.substr(0, begin);
  for (const Row& row : rows) {
    if (!writtenByHand(row)) continue;
    EXPECT_NE(head.find(row.key + " ="), std::string::npos) << row.section << " " << row.key;
  }
  if (std::getenv("CF_WRITE_REFERENCE") != nullptr) support::writeText(kDemo, head + expected);
  EXPECT_EQ(fileText(kDemo).substr(begin), expected)
      << "write config.ini anew: CF_WRITE_REFERENCE=1 build/tests/test_config_demo_config";
}

}  // namespace
}  // namespace cf
