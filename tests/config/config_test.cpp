// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/config/config.h"

#include <gtest/gtest.h>

#include <clocale>
#include <filesystem>
#include <functional>
#include <string>

#include "cf/base/error.h"
#include "support/temp_folder.h"

namespace cf {
namespace {

struct DensifyOptions {
  double megapixels = 1.5;
  int partners = 2;
  bool bilateral = true;
  std::string matcher = "sgm";

  void visit(OptionVisitor& v) {
    v.number("megapixels", megapixels, {0.1, 20}, "size matched [MP]");
    v.integer("partners", partners, {1, 8}, "pairs of a keyframe");
    v.flag("bilateral", bilateral, "smooth between edges");
    v.choice("matcher", matcher, {"elas", "sgm"}, "a|b");
  }
};

struct SpeckleOptions {
  double speckle_px = 100;
  void visit(OptionVisitor& v) { v.number("speckle_px", speckle_px, {0}, "smallest patch [px]"); }
};

struct UavOptions {
  std::string rawlog;
  void visit(OptionVisitor& v) { v.text("rawlog", rawlog, "path"); }
};

class ConfigTest : public ::testing::Test {
 protected:
  Config config(const std::string& text) {
    support::writeText(file_, text);
    return Config::fromFile(file_);
  }

  /// The message of the UsageError that `body` throws, with the path of the ini as FILE.
  std::string complaint(const std::function<void()>& body) const {
    try {
      body();
    } catch (const UsageError& e) {
      std::string message = e.what();
      const auto at = message.find(file_.string());
      if (at != std::string::npos) message.replace(at, file_.string().size(), "FILE");
      return message;
    }
    return "no UsageError";
  }
  std::string complaintOfFile(const std::string& text) {
    return complaint([&] { config(text); });
  }
  /// What loading and checking DensifyOptions from the lines of [densify] complains of.
  std::string complaintOfDensify(const std::string& lines) {
    return complaint([&] {
      Config c = config("[densify]\n" + lines);
      DensifyOptions options;
      c.load("densify", options);
      c.rejectUnknown();
    });
  }

  const support::TempFolder folder_;
  const std::filesystem::path file_ = folder_ / "flight.ini";
};

TEST_F(ConfigTest, givenFieldsAreReadTheOthersKeepTheirDefaults) {
  Config c = config(
      "\xEF\xBB\xBF# flight\r\n[densify]\r\nmegapixels = 0.75   // half\r\n"
      "; the rest\r\nmatcher=elas # own\r\nbilateral = no ; slow\r\n");
  DensifyOptions o;
  c.load("densify", o);
  c.rejectUnknown();
  EXPECT_EQ(o.megapixels, 0.75);
  EXPECT_EQ(o.partners, 2);
  EXPECT_FALSE(o.bilateral);
  EXPECT_EQ(o.matcher, "elas");
}

TEST_F(ConfigTest, commentMarksInsideAValueStay) {
  Config c = config("[uav.a]\nrawlog = a#b;c//d e.rawlog\n");
  UavOptions o;
  c.load("uav.a", o);
  EXPECT_EQ(o.rawlog, "a#b;c//d e.rawlog");
}

TEST_F(ConfigTest, anAbsentSectionIsAllDefaults) {
  Config c = config("");
  DensifyOptions o;
  c.load("densify", o);
  c.rejectUnknown();
  EXPECT_EQ(o.megapixels, 1.5);
}

TEST_F(ConfigTest, numbersAreReadToTheLastDigitWhateverTheLocale) {
  const char* german = std::setlocale(LC_ALL, "de_DE.UTF-8");  // null where not installed
  for (const char* text : {"0.1234567890123456", "+1.5", "1e-1", "2.5E0", "7"}) {
    Config c = config("[densify]\nmegapixels = " + std::string(text) + "\n");
    DensifyOptions o;
    c.load("densify", o);
    std::setlocale(LC_ALL, "C");
    EXPECT_EQ(o.megapixels, std::stod(text)) << text;
    if (german != nullptr) std::setlocale(LC_ALL, "de_DE.UTF-8");
  }
  std::setlocale(LC_ALL, "C");
}

TEST_F(ConfigTest, valuesMustBeOneWholeToken) {
  for (const char* text : {"abc", "12x", "1,5", "1.5 2", "nan", "inf", "0x10", "+-1", "1e", "--1"})
    EXPECT_EQ(complaintOfDensify("megapixels = " + std::string(text)),
              "FILE:2: [densify] megapixels = " + std::string(text) + " is not a number");
  for (const char* text : {"12x", "2.0", "1e1", "99999999999"})
    EXPECT_EQ(complaintOfDensify("partners = " + std::string(text)),
              "FILE:2: [densify] partners = " + std::string(text) + " is not a whole number");
  for (const char* text : {"maybe", "2", "TRUE", "on"})
    EXPECT_EQ(complaintOfDensify("bilateral = " + std::string(text)),
              "FILE:2: [densify] bilateral = " + std::string(text) +
                  " is neither true (yes, 1) nor false (no, 0)");
  EXPECT_EQ(complaintOfDensify("megapixels ="),
            "FILE:2: [densify] megapixels = (nothing) is not a number");
}

TEST_F(ConfigTest, everyFlagWord) {
  for (const auto& [text, value] :
       std::initializer_list<std::pair<const char*, bool>>{{"true", true},
                                                           {"yes", true},
                                                           {"1", true},
                                                           {"false", false},
                                                           {"no", false},
                                                           {"0", false}}) {
    Config c = config("[densify]\nbilateral = " + std::string(text) + "\n");
    DensifyOptions o;
    o.bilateral = !value;
    c.load("densify", o);
    EXPECT_EQ(o.bilateral, value) << text;
  }
}

TEST_F(ConfigTest, rangesAndChoicesAreClosed) {
  EXPECT_EQ(complaintOfDensify("megapixels = 0.1"), "no UsageError");
  EXPECT_EQ(complaintOfDensify("megapixels = 20"), "no UsageError");
  EXPECT_EQ(complaintOfDensify("megapixels = 20.01"),
            "FILE:2: [densify] megapixels = 20.01 is out of range: it must be 0.1 to 20");
  EXPECT_EQ(complaintOfDensify("partners = 0"),
            "FILE:2: [densify] partners = 0 is out of range: it must be 1 to 8");
  EXPECT_EQ(complaintOfDensify("matcher = bm"),
            "FILE:2: [densify] matcher = bm is not one of: elas, sgm");
  EXPECT_EQ(complaint([&] {
              Config c = config("[densify]\nspeckle_px = -1\n");
              SpeckleOptions o;
              c.load("densify", o);
            }),
            "FILE:2: [densify] speckle_px = -1 is out of range: it must be at least 0");
}

TEST_F(ConfigTest, unknownKeysNameTheNearestKnown) {
  EXPECT_EQ(complaintOfDensify("partners = 2\nmegapixel = 1"),
            "FILE:3: [densify] key 'megapixel' is not known; did you mean 'megapixels'?");
  EXPECT_EQ(complaintOfDensify("Matcher = sgm"),
            "FILE:2: [densify] key 'Matcher' is not known; did you mean 'matcher'?");
  EXPECT_EQ(complaintOfDensify("voxel_m = 1"),
            "FILE:2: [densify] key 'voxel_m' is not known; known are: megapixels, partners, "
            "bilateral, matcher");
}

TEST_F(ConfigTest, unknownSectionsNameTheNearestKnown) {
  EXPECT_EQ(complaintOfDensify("[densfy]\n"),
            "FILE:2: section [densfy] is not known; did you mean 'densify'?");
  EXPECT_EQ(complaint([&] { config("[x]\n").rejectUnknown(); }),
            "FILE:1: section [x] is not known");
}

TEST_F(ConfigTest, linesWithoutMeaningAreErrors) {
  EXPECT_EQ(complaintOfFile("[a]\njunk\n"),
            "FILE:2: 'junk' is neither a [section], a 'key = value' nor a comment");
  EXPECT_EQ(complaintOfFile("[a]\n= 3\n"),
            "FILE:2: '= 3' is neither a [section], a 'key = value' nor a comment");
  EXPECT_EQ(complaintOfFile("\nx = 1\n[a]\n"), "FILE:2: key 'x' stands before the first [section]");
  EXPECT_EQ(complaintOfFile("[a\n"), "FILE:1: '[a' is not a section; write [name]");
  EXPECT_EQ(complaintOfFile("[]\n"), "FILE:1: '[]' is not a section; write [name]");
  EXPECT_EQ(complaintOfFile("[a] b\n"), "FILE:1: '[a] b' is not a section; write [name]");
}

TEST_F(ConfigTest, nothingMayBeGivenTwice) {
  EXPECT_EQ(complaintOfFile("[a]\nx = 1\ny = 2\nx = 3\n"),
            "FILE:4: [a] key 'x' was given before, in line 2");
  EXPECT_EQ(complaintOfFile("[a]\nx = 1\nX = 3\n"),
            "FILE:3: [a] key 'X' was given before, in line 2");
  EXPECT_EQ(complaintOfFile("[a]\nx = 1\n[b]\n[a]\n"),
            "FILE:4: section [a] was begun before, in line 1; put its keys there");
}

TEST_F(ConfigTest, aMissingFileIsNamed) {
  EXPECT_EQ(complaint([&] { Config::fromFile(file_); }),
            "FILE: no such configuration file, or not readable");
  EXPECT_NE(complaint([&] { Config::fromFile(folder_.path()); }), "no UsageError");
}

TEST_F(ConfigTest, overridesReplaceAddAndSplitAtTheLastDot) {
  Config c = config("[densify]\npartners = 3\n[uav.north]\nrawlog = n.rawlog\n");
  c.override("densify.partners=4");
  c.override("densify.megapixels = 2.5");
  c.override("uav.north.rawlog=other.v2.rawlog");
  c.override("uav.south.wing.rawlog=a=b");
  DensifyOptions densify;
  UavOptions north, south;
  c.load("densify", densify);
  c.load("uav.north", north);
  c.load("uav.south.wing", south);
  c.rejectUnknown();
  EXPECT_EQ(densify.partners, 4);
  EXPECT_EQ(densify.megapixels, 2.5);
  EXPECT_EQ(north.rawlog, "other.v2.rawlog");
  EXPECT_EQ(south.rawlog, "a=b");
  EXPECT_EQ(c.sections("uav."), (std::vector<std::string>{"uav.north", "uav.south.wing"}));
}

TEST_F(ConfigTest, faultyOverridesAreNamed) {
  const auto of = [&](const std::string& assignment) {
    return complaint([&] {
      Config c = config("");
      c.override(assignment);
      DensifyOptions o;
      c.load("densify", o);
      c.rejectUnknown();
    });
  };
  for (const char* text :
       {"densify", "densify=3", "densify.partners", ".partners=3", "densify.=3", "=a.b"})
    EXPECT_EQ(of(text), "-s " + std::string(text) + ": write -s section.key=value");
  EXPECT_EQ(of("densify.partners=x"),
            "-s densify.partners=x: [densify] partners = x is not a whole number");
  EXPECT_EQ(of("densify.partner=2"),
            "-s densify.partner=2: [densify] key 'partner' is not known; did you mean 'partners'?");
  EXPECT_EQ(of("densfy.partners=2"),
            "-s densfy.partners=2: section [densfy] is not known; did you mean 'densify'?");
  EXPECT_NE(of("densify.matcher=sgm # x"), "no UsageError");
  EXPECT_NE(of("densify.matcher=sgm\n[x]"), "no UsageError");
}

TEST_F(ConfigTest, theEffectiveTextGivesTheSameOptionsAgain) {
  Config c = config("[uav.a]\nrawlog = dir with blanks/a.rawlog\n[densify]\nmegapixels = 0.1\n");
  c.override("densify.megapixels=0.30000000000000004");
  DensifyOptions densify;
  SpeckleOptions speckle;
  UavOptions uav;
  c.load("densify", densify);
  c.load("uav.a", uav);
  c.load("densify", speckle);  // two structs in one section
  c.rejectUnknown();
  const std::string text = c.effectiveText();
  EXPECT_EQ(text,
            "[densify]\nmegapixels = 0.30000000000000004\npartners = 2\nbilateral = true\n"
            "matcher = sgm\nspeckle_px = 100\n\n[uav.a]\nrawlog = dir with blanks/a.rawlog\n");

  Config again = config(text);
  DensifyOptions densify_again;
  SpeckleOptions speckle_again;
  UavOptions uav_again;
  again.load("densify", densify_again);
  again.load("densify", speckle_again);
  again.load("uav.a", uav_again);
  again.rejectUnknown();
  EXPECT_EQ(densify_again.megapixels, densify.megapixels);
  EXPECT_EQ(again.effectiveText(), text);
}

TEST_F(ConfigTest, theReferenceTellsDefaultsWhateverTheFileGives) {
  Config c = config("[densify]\nmegapixels = 3\n");
  DensifyOptions densify;
  SpeckleOptions speckle;
  UavOptions uav;
  c.load("densify", densify);
  c.load("densify", speckle);
  c.load("uav.NAME", uav);
  EXPECT_EQ(c.referenceMarkdown(),
            "## [densify]\n\n"
            "| key | default | allowed | meaning |\n|---|---|---|---|\n"
            "| `megapixels` | `1.5` | number, 0.1 to 20 | size matched [MP] |\n"
            "| `partners` | `2` | whole number, 1 to 8 | pairs of a keyframe |\n"
            "| `bilateral` | `true` | true, false | smooth between edges |\n"
            "| `matcher` | `sgm` | elas, sgm | a\\|b |\n"
            "| `speckle_px` | `100` | number, at least 0 | smallest patch [px] |\n\n"
            "## [uav.NAME]\n\n"
            "| key | default | allowed | meaning |\n|---|---|---|---|\n"
            "| `rawlog` | (empty) | text | path |\n");
}

TEST_F(ConfigTest, theTopLevelConfigurationIsWellFormed) {
  EXPECT_NO_THROW(Config::fromFile(std::filesystem::path(CF_SOURCE_DIR) / "config.ini"));
}

TEST_F(ConfigTest, pathsCountFromTheFolderOfTheIni) {
  const Config c = config("");
  EXPECT_EQ(c.resolve("sub/../a.rawlog"), folder_ / "a.rawlog");
  EXPECT_EQ(c.resolve("/abs/a.rawlog"), "/abs/a.rawlog");
}

}  // namespace
}  // namespace cf
