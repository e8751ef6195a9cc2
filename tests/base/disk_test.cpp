// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/disk.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

TEST(Disk, FoldersAreMadeWithAllAboveThem) {
  const support::TempFolder folder;
  createFolder(folder / "a/b/c");
  createFolder(folder / "a/b");
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b/c"));
}

TEST(Disk, AFileInTheWayIsNamed) {
  const support::TempFolder folder;
  support::writeText(folder / "file", "x");
  for (const char* name : {"file", "file/below"}) {
    try {
      createFolder(folder / name);
      ADD_FAILURE() << name;
    } catch (const RunError& e) {
      EXPECT_EQ(std::string(e.what()).rfind((folder / name).string() + ": cannot be created: ", 0),
                0U)
          << e.what();
    }
  }
}

TEST(Disk, OnlyWhatIsThereCanBeSynced) {
  const support::TempFolder folder;
  support::writeText(folder / "file", "x");
  EXPECT_TRUE(syncFile(folder / "file"));
  EXPECT_FALSE(syncFile(folder / "none"));
}

}  // namespace
}  // namespace cf
