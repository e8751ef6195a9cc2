// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/config/reference.h"

#include <fmt/format.h>

#include "option_text.h"

namespace cf {
namespace {

/// A cell's text: a bar would end the cell.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|') out += '\\';
    out += c;
  }
  return out;
}

class ReferenceRows : public OptionVisitor {
 public:
  void number(const char* key, double& value, Range range, const char* help) override {
    row(key, numberText(value), range, "number", help);
  }
  void integer(const char* key, int& value, Range range, const char* help) override {
    row(key, fmt::format("{}", value), range, "whole number", help);
  }
  void flag(const char* key, bool& value, const char* help) override {
    row(key, flagText(value), "true, false", help);
  }
  void text(const char* key, std::string& value, const char* help) override {
    row(key, value, "text", help);
  }
  void choice(const char* key, std::string& value, const std::vector<std::string>& allowed,
              const char* help) override {
    row(key, value, fmt::format("{}", fmt::join(allowed, ", ")), help);
  }

  const std::string& rows() const { return rows_; }

 private:
  void row(const char* key, const std::string& value, Range range, const char* kind,
           const char* help) {
    const std::string limits = rangeText(range);
    row(key, value, limits.empty() ? kind : fmt::format("{}, {}", kind, limits), help);
  }
  void row(const char* key, const std::string& value, const std::string& allowed,
           const char* help) {
    const std::string shown = value.empty() ? "(empty)" : "`" + cell(value) + "`";
    rows_ += fmt::format("| `{}` | {} | {} | {} |\n", key, shown, cell(allowed), cell(help));
  }

  std::string rows_;
};

}  // namespace

std::string referenceTable(const std::function<void(OptionVisitor&)>& visit) {
  ReferenceRows rows;
  visit(rows);
  return "| key | default | allowed | meaning |\n|---|---|---|---|\n" + rows.rows();
}

}  // namespace cf
