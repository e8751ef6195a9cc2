// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/config/reference.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

struct Options {
  double size_m = 0.25;
  int count = 3;
  bool on = false;
  std::string path;
  std::string method = "a";

  void visit(OptionVisitor& v) {
    v.number("size_m", size_m, {0.1, 2}, "edge [m]");
    v.integer("count", count, {}, "how many");
    v.flag("on", on, "a|b");
    v.text("path", path, "where");
    v.choice("method", method, {"a", "b"}, "which");
  }
};

TEST(Reference, oneRowPerOption) {
  EXPECT_EQ(referenceMarkdown<Options>("stage", "What it does."),
            "## [stage]\n\nWhat it does.\n\n"
            "| key | default | allowed | meaning |\n|---|---|---|---|\n"
            "| `size_m` | `0.25` | number, 0.1 to 2 | edge [m] |\n"
            "| `count` | `3` | whole number | how many |\n"
            "| `on` | `false` | true, false | a\\|b |\n"
            "| `path` | (empty) | text | where |\n"
            "| `method` | `a` | a, b | which |\n");
}

}  // namespace
}  // namespace cf
