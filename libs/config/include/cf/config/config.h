// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cf/base/options.h"

namespace cf {

/// One strictly read ini file with overrides from the command line.
///
/// Whoever owns an options struct loads it from its section; afterwards rejectUnknown() finds what
/// nobody asked for. Every fault of the file or of an override throws UsageError with one line that
/// names file and line, section, key, what is wrong and what would be right.
///
/// Form of the file: lines `[section]`, `key = value`, empty, or comment. `#`, `;` and `//` begin
/// a comment at the start of a line or after a blank. Numbers are read in the C locale, flags are
/// true/false, yes/no or 1/0. A section or key given twice is an error, whatever its case.
class Config {
 public:
  static Config fromFile(const std::filesystem::path& file);

  /// Takes "section.key=value", split at the last dot before the first '=': sections may hold
  /// dots (`uav.north.rawlog=n.rawlog`). Replaces or adds; later overrides win. Call before load().
  void override(const std::string& assignment);

  /// Fills the fields that the section gives, leaves the others at their defaults, and remembers
  /// all of them as known. One section may be loaded into several structs.
  template <class Options>
  void load(const std::string& section, Options& options) {
    loadWith(section, [&](OptionVisitor& v) { options.visit(v); });
  }

  /// Sections whose name starts with `prefix`, full names, in the order of the file.
  std::vector<std::string> sections(const std::string& prefix) const;

  /// Throws UsageError on the first section or key that no load() asked for, with the nearest
  /// known.
  void rejectUnknown() const;

  /// All loaded sections and keys with their values, in the order of loading, paths absolute: an
  /// ini that gives the same options again, wherever it lies.
  std::string effectiveText() const;

  /// All loaded sections as Markdown, a table each: key, default, allowed values, help.
  std::string referenceMarkdown() const;

  /// A path of the configuration, relative ones counted from the folder of the ini; absolute.
  std::filesystem::path resolve(const std::filesystem::path& path) const;

  const std::filesystem::path& file() const { return file_; }

 private:
  friend class OptionReader;
  struct Entry {
    std::string key, value;
    std::string where;  ///< "FILE:LINE" or "-s section.key=value"
  };
  struct Section {
    std::string name;
    std::string where;
    std::vector<Entry> entries;
  };
  /// What an options struct says of a field, and the value that it ended with.
  struct KnownKey {
    std::string key, value;
    std::string default_value, allowed, help;
  };
  struct KnownSection {
    std::string name;
    std::vector<KnownKey> entries;
  };
  explicit Config(std::filesystem::path file) : file_(std::move(file)) {}
  void loadWith(const std::string& section, const std::function<void(OptionVisitor&)>& visit);

  std::filesystem::path file_;
  std::vector<Section> given_;       ///< in the order of the file
  std::vector<KnownSection> known_;  ///< in the order of loading
};

}  // namespace cf
