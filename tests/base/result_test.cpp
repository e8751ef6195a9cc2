// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/result.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <variant>

namespace cf {
namespace {

Result<double> root(double x) {
  if (x < 0) return Failure{"negative", "no root"};
  return x * x;
}

TEST(Result, holdsAValue) {
  const auto r = root(3);
  ASSERT_TRUE(r.ok());
  EXPECT_TRUE(static_cast<bool>(r));
  EXPECT_EQ(*r, 9);
  EXPECT_EQ(r.value(), 9);
}

TEST(Result, holdsAFailure) {
  const auto r = root(-1);
  ASSERT_FALSE(r.ok());
  EXPECT_FALSE(static_cast<bool>(r));
  EXPECT_EQ(r.failure().code, "negative");
  EXPECT_EQ(r.failure().detail, "no root");
}

TEST(Result, readingWhatIsNotThereThrows) {
  EXPECT_THROW(static_cast<void>(root(-1).value()), std::bad_variant_access);
  EXPECT_THROW(static_cast<void>(root(1).failure()), std::bad_variant_access);
}

TEST(Result, movesValuesThatCannotBeCopied) {
  Result<std::unique_ptr<std::string>> r(std::make_unique<std::string>("tile"));
  const std::unique_ptr<std::string> taken = std::move(r.value());
  EXPECT_EQ(*taken, "tile");
}

}  // namespace
}  // namespace cf
