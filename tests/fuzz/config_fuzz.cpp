// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "cf/config/config.h"
#include "fuzz/fuzz_target.h"

namespace {

struct Options {
  double number = 1;
  int integer = 2;
  bool flag = true;
  std::string text = "text", path = "path", choice = "one";

  void visit(cf::OptionVisitor& v) {
    v.number("number", number, {0, 10}, "a number");
    v.integer("integer", integer, {-5, 5}, "a whole number");
    v.flag("flag", flag, "a flag");
    v.text("text", text, "a text");
    v.path("path", path, "a path");
    v.choice("choice", choice, {"one", "two"}, "a choice");
  }
};

}  // namespace

std::vector<std::string> cf::fuzz::seeds() {
  return {
      "; comment\n[stage]\nnumber = 2.5 // half\ninteger = -3\nflag = yes\ntext = a text\n"
      "path = ../some where/x\nchoice = two\n\n[uav.a]\ntext = a.rawlog\n",
      "[uav.north_0]\r\nnumber = 1e-1\r\n# end\r\n[stage]\r\n",
      "\xEF\xBB\xBF[stage]\ninteger=+4\nflag=0\n"};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cf::fuzz::InputFile file("config.ini");
  const auto& path = file.put(data, size);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    cf::Config config = cf::Config::fromFile(path);
    Options options;
    config.load("stage", options);
    for (const std::string& uav : config.sections("uav.")) {
      Options of_uav;
      config.load(uav, of_uav);
    }
    config.rejectUnknown();
    cf::fuzz::require(options.number >= 0 && options.number <= 10, "numbers in range");
    cf::fuzz::require(options.integer >= -5 && options.integer <= 5, "whole numbers in range");
    cf::fuzz::require(options.choice == "one" || options.choice == "two", "one of the choices");
    cf::fuzz::require(!config.effectiveText().empty(), "an effective configuration");
  });
  return 0;
}
