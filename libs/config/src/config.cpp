// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/config/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "cf/base/error.h"
#include "edit_distance.h"
#include "ini_file.h"
#include "option_text.h"

namespace cf {
namespace {

template <class Sections>
auto findSection(Sections& sections, const std::string& name) -> decltype(sections.data()) {
  const auto it =
      std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return s.name == name; });
  return it == sections.end() ? nullptr : &*it;
}

template <class Section>
auto findEntry(Section& section, const std::string& key) -> decltype(section.entries.data()) {
  const auto it = std::find_if(section.entries.begin(), section.entries.end(),
                               [&](const auto& e) { return e.key == key; });
  return it == section.entries.end() ? nullptr : &*it;
}

/// Text of a cell of a Markdown table, where a bar would end the cell.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

}  // namespace

/// Fills one options struct from one section.
class OptionReader : public OptionVisitor {
 public:
  OptionReader(Config& config, std::string section)
      : config_(config), section_(std::move(section)) {}

  void number(const char* key, double& value, Range range, const char* help) override {
    take(key, value, help, withRange("number", range), numberText,
         [&](const std::string& text) { return numberFromText(text, range); });
  }
  void integer(const char* key, int& value, Range range, const char* help) override {
    take(key, value, help, withRange("whole number", range), integerText,
         [&](const std::string& text) { return integerFromText(text, range); });
  }
  void flag(const char* key, bool& value, const char* help) override {
    take(key, value, help, "true, false", flagText, flagFromText);
  }
  void text(const char* key, std::string& value, const char* help) override {
    take(key, value, help, "text", plainText,
         [](const std::string& text) { return Result<std::string>(text); });
  }
  /// Absolute from here on, so that the effective configuration means the same anywhere.
  void path(const char* key, std::string& value, const char* help) override {
    take(key, value, help, "path", plainText, [&](const std::string& text) {
      return Result<std::string>(text.empty() ? text : config_.resolve(text).string());
    });
  }
  void choice(const char* key, std::string& value, const std::vector<std::string>& allowed,
              const char* help) override {
    take(key, value, help, fmt::format("{}", fmt::join(allowed, ", ")), plainText,
         [&](const std::string& text) { return choiceFromText(text, allowed); });
  }

 private:
  static std::string plainText(const std::string& value) { return value; }
  static std::string withRange(const std::string& kind, Range range) {
    const std::string limits = rangeText(range);
    return limits.empty() ? kind : kind + ", " + limits;
  }

  template <class T, class Print, class Parse>
  void take(const char* key, T& value, const char* help, const std::string& allowed, Print print,
            Parse parse) {
    const std::string default_value = print(value);
    if (const auto* entry = given(key)) {
      auto parsed = parse(entry->value);
      if (!parsed)
        throw UsageError(fmt::format("{}: [{}] {} = {} {}", entry->where, section_, key,
                                     entry->value.empty() ? "(nothing)" : entry->value,
                                     parsed.failure().detail));
      value = parsed.value();
    }
    know({key, print(value), default_value, allowed, help});
  }

  const Config::Entry* given(const char* key) const {
    auto* section = findSection(config_.given_, section_);
    return section == nullptr ? nullptr : findEntry(*section, key);
  }

  void know(const Config::KnownKey& known) {
    auto* section = findSection(config_.known_, section_);
    if (section == nullptr)
      section = &config_.known_.emplace_back(Config::KnownSection{section_, {}});
    if (auto* entry = findEntry(*section, known.key))
      *entry = known;
    else
      section->entries.push_back(known);
  }

  Config& config_;
  std::string section_;
};

Config Config::fromFile(const std::filesystem::path& file) {
  Config config(file);
  for (const auto& section : readIniFile(file)) {
    const auto where = [&](int line) { return fmt::format("{}:{}", file.string(), line); };
    auto& given = config.given_.emplace_back(Section{section.name, where(section.line), {}});
    for (const auto& entry : section.entries)
      given.entries.push_back({entry.key, entry.value, where(entry.line)});
  }
  return config;
}

void Config::override(const std::string& assignment) {
  const std::string where = "-s " + assignment;
  const std::size_t equals = assignment.find('=');
  const std::size_t dot =
      equals == std::string::npos ? equals : assignment.substr(0, equals).rfind('.');
  if (dot == std::string::npos) throw UsageError(where + ": write -s section.key=value");
  const std::string section = trimmed(assignment.substr(0, dot));
  const std::string key = trimmed(assignment.substr(dot + 1, equals - dot - 1));
  const std::string value = trimmed(assignment.substr(equals + 1));
  if (section.empty() || key.empty()) throw UsageError(where + ": write -s section.key=value");
  if (withoutComment(value) != value || value.find('\n') != std::string::npos)
    throw UsageError(where +
                     ": a value must not hold a comment (blank, then #, ; or //) or a "
                     "line break");
  auto* target = findSection(given_, section);
  if (target == nullptr) target = &given_.emplace_back(Section{section, where, {}});
  if (auto* entry = findEntry(*target, key))
    *entry = {key, value, where};
  else
    target->entries.push_back({key, value, where});
}

void Config::loadWith(const std::string& section,
                      const std::function<void(OptionVisitor&)>& visit) {
  OptionReader reader(*this, section);
  visit(reader);
}

std::vector<std::string> Config::sections(const std::string& prefix) const {
  std::vector<std::string> names;
  for (const auto& section : given_)
    if (section.name.compare(0, prefix.size(), prefix) == 0) names.push_back(section.name);
  return names;
}

void Config::rejectUnknown() const {
  const auto names = [](const auto& things, auto name) {
    std::vector<std::string> out;
    for (const auto& thing : things) out.push_back(name(thing));
    return out;
  };
  for (const auto& section : given_) {
    const auto* known = findSection(known_, section.name);
    if (known == nullptr)
      throw UsageError(fmt::format(
          "{}: section [{}] is not known{}", section.where, section.name,
          suggestion(section.name, names(known_, [](const KnownSection& s) { return s.name; }))));
    for (const auto& entry : section.entries)
      if (findEntry(*known, entry.key) == nullptr)
        throw UsageError(fmt::format(
            "{}: [{}] key '{}' is not known{}", entry.where, section.name, entry.key,
            suggestion(entry.key, names(known->entries, [](const KnownKey& k) { return k.key; }))));
  }
}

std::string Config::effectiveText() const {
  std::string text;
  for (const auto& section : known_) {
    text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", section.name);
    for (const auto& entry : section.entries)
      text += fmt::format("{} = {}\n", entry.key, entry.value);
  }
  return text;
}

std::string Config::referenceMarkdown() const {
  std::string text;
  for (const auto& section : known_) {
    text += fmt::format("{}## [{}]\n\n| key | default | allowed | meaning |\n|---|---|---|---|\n",
                        text.empty() ? "" : "\n", section.name);
    for (const auto& known : section.entries)
      text += fmt::format(
          "| `{}` | {} | {} | {} |\n", known.key,
          known.default_value.empty() ? "(empty)" : "`" + cell(known.default_value) + "`",
          cell(known.allowed), cell(known.help));
  }
  return text;
}

std::filesystem::path Config::resolve(const std::filesystem::path& path) const {
  return (std::filesystem::absolute(file_).parent_path() / path).lexically_normal();
}

}  // namespace cf
