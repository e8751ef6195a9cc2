// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/atomic_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "cf/base/error.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(AtomicFile, WhatWasThereStaysUntilCommit) {
  const fs::path path = fs::path(testing::TempDir()) / "cf_atomic.txt";
  writeFileAtomically(path, "old");
  {
    AtomicFile file(path);
    file.write(std::string("half"));
    EXPECT_EQ(contentOf(path), "old");
  }
  EXPECT_EQ(contentOf(path), "old");
  EXPECT_FALSE(fs::exists(path.string() + ".tmp"));
  AtomicFile file(path);
  file.write(std::string("new text"));
  file.overwrite(0, "NEW");
  file.write(std::string("!"));
  file.commit();
  EXPECT_EQ(contentOf(path), "NEW text!");
  EXPECT_FALSE(fs::exists(path.string() + ".tmp"));
}

TEST(AtomicFile, FailureNamesThePath) {
  const fs::path path = fs::path(testing::TempDir()) / "cf_no_such_folder" / "x.txt";
  try {
    writeFileAtomically(path, "x");
    FAIL() << "must throw";
  } catch (const RunError& e) {
    EXPECT_NE(std::string(e.what()).find(path.string()), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace cf
