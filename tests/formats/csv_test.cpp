// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/csv.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

class Csv : public ::testing::Test {
 protected:
  fs::path fileWith(const std::string& name, const std::string& content) const {
    support::writeText(folder_ / name, content);
    return folder_ / name;
  }

  support::TempFolder folder_;
};

TEST_F(Csv, WhatIsWrittenIsRead) {
  const fs::path path = folder_ / "written.csv";
  const std::vector<CsvRow> rows = {
      {"a.jpg", "1.5", ""}, {"a, b.jpg", "say \"hi\"", "two\nlines"}, {"", "", "x"}};
  CsvWriter writer(path, {"image", "t", "reason"});
  for (const CsvRow& row : rows) writer.row(row);
  writer.close();
  const CsvTable table(path);
  EXPECT_EQ(table.rows(), rows);
  EXPECT_EQ(table.column("reason"), 2u);
  EXPECT_THROW(static_cast<void>(table.column("nothing")), RunError);
}

TEST_F(Csv, WindowsLineEndsTabsAndNoFinalNewline) {
  const fs::path path = fileWith("cf_tabs.tsv", "a\t1\r\n\r\nb,c\t\r\nd\t4");
  EXPECT_EQ(readCsvRows(path, '\t'), (std::vector<CsvRow>{{"a", "1"}, {"b,c", ""}, {"d", "4"}}));
}

TEST_F(Csv, BadFilesAreNamed) {
  EXPECT_THROW(CsvTable(fileWith("cf_short.csv", "a,b\n1,2\n3\n")), RunError);
  EXPECT_THROW(CsvTable(fileWith("cf_empty.csv", "")), RunError);
  EXPECT_THROW(static_cast<void>(readCsvRows("/nonexistent.csv")), RunError);
  try {
    static_cast<void>(readCsvRows(fileWith("cf_open.csv", "a,b\n1,\"x\ny\n")));
    FAIL() << "must throw";
  } catch (const RunError& e) {
    EXPECT_NE(std::string(e.what()).find("cf_open.csv: line 2"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace cf
