// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "cf/config/config.h"
#include "cf/pipeline/run_options.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIntroduction =
    "# Configuration\n\n"
    "One ini for a run. It needs no more than its UAVs, a section `[uav.NAME]` with the key\n"
    "`rawlog` each; everything else has a default. `cf-run -s section.key=value` overrides. Paths\n"
    "count from the folder of the ini. `#`, `;` and `//` begin a comment, at the start of a line "
    "or\n"
    "after a blank. An unknown section or key, a value that is not wholly what it should be, or "
    "one\n"
    "out of range is an error. What a run used stands in its `config.effective.ini`.\n\n"
    "This page is written by `CF_WRITE_REFERENCE=1 build/tests/test_config_reference`.\n\n";

/// docs/config.md tells the options as they are. CF_WRITE_REFERENCE=1 writes it.
TEST(Reference, tellsTheOptionsAsTheyAre) {
  const support::TempFolder folder;
  support::writeText(folder / "run.ini", "[uav.NAME]\nrawlog = x\n");
  Config config = Config::fromFile(folder / "run.ini");
  loadRunOptions(config);
  const std::string expected = kIntroduction + config.referenceMarkdown();

  const fs::path page = fs::path(CF_SOURCE_DIR) / "docs" / "config.md";
  if (std::getenv("CF_WRITE_REFERENCE") != nullptr) support::writeText(page, expected);
  EXPECT_EQ(support::fileText(page), expected)
      << "write docs/config.md anew: CF_WRITE_REFERENCE=1 build/tests/test_config_reference";
}

}  // namespace
}  // namespace cf
