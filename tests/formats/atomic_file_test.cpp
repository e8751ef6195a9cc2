// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/atomic_file.h"

#include <gtest/gtest.h>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using support::fileText;

TEST(AtomicFile, WhatWasThereStaysUntilCommit) {
  const support::TempFolder folder;
  const fs::path path = folder / "a.txt";
  writeFileAtomically(path, "old");
  {
    AtomicFile file(path);
    file.write(std::string("half"));
    EXPECT_EQ(fileText(path), "old");
  }
  EXPECT_EQ(fileText(path), "old");
  EXPECT_FALSE(fs::exists(path.string() + ".tmp"));
  AtomicFile file(path);
  file.write(std::string("new text"));
  file.overwrite(0, "NEW");
  file.write(std::string("!"));
  file.commit();
  EXPECT_EQ(fileText(path), "NEW text!");
  EXPECT_FALSE(fs::exists(path.string() + ".tmp"));
}

TEST(AtomicFile, WhatCannotBeRenamedIsNotLeftEither) {
  const support::TempFolder folder;
  fs::create_directory(folder / "a");
  EXPECT_THROW(writeFileAtomically(folder / "a", "x"), RunError);
  EXPECT_FALSE(fs::exists(folder / "a.tmp"));
  EXPECT_TRUE(fs::is_empty(folder / "a"));
}

TEST(AtomicFile, FailureNamesThePath) {
  const support::TempFolder folder;
  const fs::path path = folder / "no such folder/x.txt";
  try {
    writeFileAtomically(path, "x");
    FAIL() << "must throw";
  } catch (const RunError& e) {
    EXPECT_NE(std::string(e.what()).find(path.string()), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace cf
