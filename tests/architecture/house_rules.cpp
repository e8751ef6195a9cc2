// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "architecture/house_rules.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>

namespace cf {
namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;
using Lines = std::vector<std::string>;

constexpr int kTypesFloor = 1;
constexpr int kAppFloor = 5;
constexpr int kMaxMainLines = 25;

struct Lib {
  int floor;
  Names outside;  ///< besides fmt, and from types up Eigen and OpenCV core, which all may use
};

// The table of docs/architecture.md.
const std::map<std::string, Lib> kLibs = {
    {"base", {0, {"spdlog"}}},
    {"types", {1, {}}},
    {"features", {2, {"opencv"}}},
    {"geometry", {2, {"opencv", "ceres"}}},
    {"geodesy", {2, {"geographiclib"}}},
    {"rawlog", {2, {"mrpt", "zlib"}}},
    {"formats", {2, {"opencv", "pcl", "gdal", "json", "protobuf", "zlib", "zstd", "jpeg"}}},
    {"config", {2, {"mrpt", "json"}}},
    {"odometry", {3, {"ceres"}}},
    {"georeference", {3, {"ceres", "mrpt"}}},
    {"densify", {3, {"opencv"}}},
    {"align", {3, {"opencv", "ceres", "mrpt", "tbb"}}},
    {"fuse", {3, {"octomap", "tbb"}}},
    {"import", {3, {"gdal", "opencv", "tbb"}}},
    {"deliver", {3, {"opencv", "json", "tbb"}}},
    {"view", {3, {"mrpt", "opencv", "octomap", "json", "tbb"}}},
    {"evaluate", {3, {"opencv", "json", "tbb"}}},
    {"simulate", {3, {"embree", "opencv", "json", "tbb"}}},
    {"pipeline", {4, {"tbb", "opencv", "json"}}},
};
const Names kAppOutside = {"cli11"};

// What an include or a CMake target belongs to; the first pattern that matches.
struct Origin {
  std::regex pattern;
  std::string name;
};
const std::vector<Origin> kIncludes = {
    {std::regex("[a-z_0-9]+"), "standard"},
    {std::regex("(sys|linux|bits)/.*"), "standard"},
    {std::regex("[a-z]mmintrin\\.h"), "standard"},  // the compiler's own
    {std::regex("zlib\\.h"), "zlib"},
    {std::regex("zstd\\.h"), "zstd"},
    {std::regex("jpeglib\\.h"), "jpeg"},
    {std::regex("google/protobuf/.*"), "protobuf"},
    {std::regex(
         "(dirent|dlfcn|fcntl|malloc|poll|pthread|sched|signal|stdlib|string|time|unistd)\\.h"),
     "standard"},
    {std::regex("Eigen/.*"), "eigen"},
    {std::regex("opencv2/core(\\.hpp|/.*)"), "opencv_core"},
    {std::regex("opencv2/.*"), "opencv"},
    {std::regex("ceres/.*"), "ceres"},
    {std::regex("fmt/.*"), "fmt"},
    {std::regex("spdlog/.*"), "spdlog"},
    {std::regex("nlohmann/.*"), "json"},
    {std::regex("GeographicLib/.*"), "geographiclib"},
    {std::regex("mrpt/.*"), "mrpt"},
    {std::regex("pcl/.*"), "pcl"},
    {std::regex("(octomap|octomath)/.*"), "octomap"},
    {std::regex("(gdal/)?(gdal|cpl|ogr|vrt)[a-z_0-9]*\\.h"), "gdal"},
    {std::regex("(oneapi/)?tbb/.*"), "tbb"},
    {std::regex("embree3/.*"), "embree"},
    {std::regex("CLI/.*"), "cli11"},
};
const std::vector<Origin> kTargets = {
    {std::regex("Eigen3::Eigen"), "eigen"},
    {std::regex("Threads::Threads"), "standard"},
    {std::regex("cf_opencv"), "opencv_core"},  // one target for all; the includes tell the modules
    {std::regex("Ceres::ceres"), "ceres"},
    {std::regex("fmt::fmt"), "fmt"},
    {std::regex("spdlog::spdlog"), "spdlog"},
    {std::regex("nlohmann_json::nlohmann_json"), "json"},
    {std::regex("cf_geographiclib"), "geographiclib"},
    {std::regex("mrpt::.*"), "mrpt"},
    {std::regex("cf_pcl"), "pcl"},
    {std::regex("cf_octomap"), "octomap"},
    {std::regex("GDAL::GDAL"), "gdal"},
    {std::regex("TBB::tbb"), "tbb"},
    {std::regex("CLI11::CLI11"), "cli11"},
    {std::regex("ZLIB::ZLIB"), "zlib"},
    {std::regex("cf_zstd"), "zstd"},
    {std::regex("JPEG::JPEG"), "jpeg"},
    {std::regex("protobuf::.*"), "protobuf"},
    {std::regex("embree"), "embree"},
};

std::string originOf(const std::string& text, const std::vector<Origin>& origins) {
  for (const auto& origin : origins)
    if (std::regex_match(text, origin.pattern)) return origin.name;
  return {};
}

Lines linesOf(const fs::path& file) {
  std::ifstream in(file);
  Lines lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

class Inspection {
 public:
  explicit Inspection(fs::path root) : root_(std::move(root)) {}

  Lines run() {
    for (const auto& folder : foldersOf("libs")) inspectLib(folder);
    for (const auto& folder : foldersOf("apps")) inspectApp(folder);
    for (const char* part : {"libs", "apps", "tests"})
      for (const auto& file : filesOf(root_ / part)) inspectForm(file);
    inspectFlags(root_ / "CMakeLists.txt");
    for (const char* part : {"libs", "apps", "tests", "cmake"})
      for (const auto& file : filesOf(root_ / part))
        if (isCMake(file)) inspectFlags(file);
    std::sort(breaches_.begin(), breaches_.end());
    return std::move(breaches_);
  }

 private:
  /// Who includes or links: a floor, the outside libraries allowed, and a name.
  struct User {
    std::string name;
    int floor;
    Names outside;
  };

  static bool isSource(const fs::path& file) {
    return file.extension() == ".h" || file.extension() == ".cpp";
  }
  static bool isCMake(const fs::path& file) {
    return file.filename() == "CMakeLists.txt" || file.extension() == ".cmake";
  }

  std::vector<fs::path> foldersOf(const char* part) const {
    std::vector<fs::path> folders;
    if (fs::is_directory(root_ / part))
      for (const auto& entry : fs::directory_iterator(root_ / part))
        if (entry.is_directory()) folders.push_back(entry.path());
    return folders;
  }
  static std::vector<fs::path> filesOf(const fs::path& folder) {
    std::vector<fs::path> files;
    if (fs::is_directory(folder))
      for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
  }

  void breach(const fs::path& file, const std::string& what) {
    breaches_.push_back(fs::relative(file, root_).generic_string() + ": " + what);
  }

  void inspectLib(const fs::path& folder) {
    const std::string name = folder.filename();
    const auto lib = kLibs.find(name);
    if (lib == kLibs.end()) return breach(folder, "is not in the table of floors");
    inspectUser(folder, {name, lib->second.floor, lib->second.outside});
  }

  void inspectApp(const fs::path& folder) {
    inspectUser(folder, {{}, kAppFloor, kAppOutside});
    int lines = 0;
    static const std::regex kNoCode("\\s*(//.*|#include.*)?");
    for (const auto& line : linesOf(folder / "main.cpp"))
      if (!std::regex_match(line, kNoCode)) ++lines;
    if (lines > kMaxMainLines)
      breach(folder / "main.cpp", "has " + std::to_string(lines) + " lines of code, " +
                                      std::to_string(kMaxMainLines) + " are allowed");
  }

  void inspectUser(const fs::path& folder, const User& user) {
    for (const auto& file : filesOf(folder)) {
      if (isSource(file)) inspectIncludes(file, user);
      if (isCMake(file)) inspectLinks(file, user);
    }
  }

  void inspectIncludes(const fs::path& file, const User& user) {
    static const std::regex kOwn("\\s*#\\s*include\\s*[<\"]cf/([^/\"]+)/.*");
    static const std::regex kOutside("\\s*#\\s*include\\s*<([^>]+)>.*");
    static const std::regex kQuotedPath("\\s*#\\s*include\\s*\"[^\"]*\\.\\./.*");
    for (const auto& line : linesOf(file)) {
      std::smatch match;
      if (std::regex_match(line, match, kOwn)) {
        judgeLib(file, user, "includes", match[1]);
      } else if (std::regex_match(line, kQuotedPath)) {
        breach(file, "includes by a path with ../");
      } else if (std::regex_match(line, match, kOutside)) {
        const std::string origin = originOf(match[1], kIncludes);
        judgeOutside(file, user, "includes", match[1], origin);
        const bool is_public = fs::relative(file, root_ / "libs" / user.name / "include")
                                   .generic_string()
                                   .find("..") == std::string::npos;
        static const Names kPublic = {"standard", "eigen", "opencv_core"};
        if (!user.name.empty() && is_public && kPublic.count(origin) == 0)
          breach(file, "is a public header and includes " + match[1].str());
      }
    }
  }

  void inspectLinks(const fs::path& file, const User& user) {
    static const std::regex kToken("[A-Za-z0-9_:]+");
    static const std::regex kOwn("cf(::|_)([a-z]+)");
    static const Names kCommands = {"cf_library", "cf_application", "cf_test"};
    for (std::string line : linesOf(file)) {
      line = line.substr(0, line.find('#'));
      for (std::sregex_iterator it(line.begin(), line.end(), kToken), end; it != end; ++it) {
        const std::string token = it->str();
        std::smatch match;
        if (kCommands.count(token) > 0 || token == "cf_" + user.name) continue;
        const std::string origin = originOf(token, kTargets);
        if (!origin.empty())
          judgeOutside(file, user, "links", token, origin);
        else if (std::regex_match(token, match, kOwn))
          judgeLib(file, user, "links", match[2]);
        else if (token.find("::") != std::string::npos)
          breach(file, "links " + token + ", which is not a known library");
      }
    }
  }

  void judgeLib(const fs::path& file, const User& user, const std::string& verb,
                const std::string& used) {
    if (used == user.name) return;
    const auto lib = kLibs.find(used);
    if (lib == kLibs.end())
      breach(file, verb + " cf/" + used + ", which is not in the table of floors");
    else if (lib->second.floor >= user.floor)
      breach(file, verb + " cf/" + used + " of floor " + std::to_string(lib->second.floor) +
                       " from floor " + std::to_string(user.floor));
  }

  void judgeOutside(const fs::path& file, const User& user, const std::string& verb,
                    const std::string& used, const std::string& origin) {
    if (origin.empty()) return breach(file, verb + " " + used + ", which is not a known library");
    if (origin == "standard" || origin == "fmt" || user.outside.count(origin) > 0) return;
    if (user.floor >= kTypesFloor && (origin == "eigen" || origin == "opencv_core")) return;
    breach(file, verb + " " + used + " (" + origin + "), which is not for it");
  }

  void inspectForm(const fs::path& file) {
    if (!isSource(file)) return;
    const Lines lines = linesOf(file);
    if (lines.size() < 2 || !startsWith(lines[0], "// SPDX-FileCopyrightText: ") ||
        lines[1] != "// SPDX-License-Identifier: BSD-3-Clause")
      breach(file, "does not begin with the two SPDX lines");
    if (file.extension() == ".h" &&
        std::find(lines.begin(), lines.end(), "#pragma once") == lines.end())
      breach(file, "has no #pragma once");
  }

  void inspectFlags(const fs::path& file) {
    static const std::regex kFlag(".*(-march|-mavx|-ffast-math).*");
    for (const auto& line : linesOf(file))
      if (std::regex_match(line.substr(0, line.find('#')), kFlag))
        breach(file, "sets a flag of -march, -mavx or -ffast-math");
  }

  fs::path root_;
  Lines breaches_;
};

}  // namespace

std::vector<std::string> houseBreaches(const std::filesystem::path& root) {
  return Inspection(root).run();
}

}  // namespace cf
