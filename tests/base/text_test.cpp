// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/base/text.h"

#include <gtest/gtest.h>

#include <clocale>

namespace cf {
namespace {

TEST(Text, TrimsAndSplitsAtAnyWhiteSpace) {
  EXPECT_EQ(trimmed(" \t a b\r\n"), "a b");
  EXPECT_EQ(trimmed(" \n"), "");
  EXPECT_EQ(wordsOf(" a\tbc \n d "), (std::vector<std::string>{"a", "bc", "d"}));
  EXPECT_TRUE(wordsOf(" ").empty());
}

TEST(Text, NumbersAreReadToTheLastDigitWhateverTheLocale) {
  const bool german = std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;  // where it is installed
  EXPECT_EQ(numberFrom("0.1234567890123456"), 0.1234567890123456) << german;
  EXPECT_EQ(numberFrom("+1.5"), 1.5);
  EXPECT_EQ(numberFrom("-3e2"), -300);
  EXPECT_EQ(numberFrom(" 7\r"), 7);
  EXPECT_EQ(numberFrom(".5"), 0.5);
  std::setlocale(LC_ALL, "C");
}

TEST(Text, WhatIsNotOneFiniteNumberIsNone) {
  for (const char* text : {"", " ", "x", "1x", "1 2", "1,5", "+", "-", "+-1", "--1", "1e", "0x10",
                           "nan", "inf", "-infinity", "1e999"})
    EXPECT_FALSE(numberFrom(text)) << "'" << text << "'";
}

TEST(Text, PrintableKeepsAllButControlCharacters) {
  EXPECT_EQ(printable("S\xC3\xBC"
                      "d\n1\x1B\t.jpg"),
            "S\xC3\xBC"
            "d?1??.jpg");
}

}  // namespace
}  // namespace cf
