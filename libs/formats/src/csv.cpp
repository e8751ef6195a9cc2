// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/csv.h"

#include <algorithm>
#include <utility>

#include "cf/base/error.h"
#include "file_bytes.h"

namespace cf {

std::vector<CsvRow> readCsvRows(const std::filesystem::path& path, char separator) {
  const auto bytes = fileBytes(path);
  if (!bytes) throw RunError(path.string() + ": cannot be read");
  const std::string& text = *bytes;
  std::vector<CsvRow> rows;
  CsvRow row;
  std::string field;
  bool quoted = false;
  std::size_t line = 1, opened = 0;
  const auto endRow = [&] {
    if (!row.empty() || !field.empty()) {
      row.push_back(std::move(field));
      rows.push_back(std::move(row));
    }
    row.clear();
    field.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    if (quoted) {
      if (c != '"') {
        field += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        field += text[++i];
      } else {
        quoted = false;
      }
    } else if (c == '"' && field.empty()) {
      quoted = true;
      opened = line;
    } else if (c == separator) {
      row.push_back(std::move(field));
      field.clear();
    } else if (c == '\n') {
      endRow();
    } else if (c != '\r' || i + 1 == text.size() || text[i + 1] != '\n') {
      field += c;
    }
  }
  if (quoted)
    throw RunError(path.string() + ": line " + std::to_string(opened) +
                   ": a quote is never closed");
  endRow();
  return rows;
}

CsvTable::CsvTable(const std::filesystem::path& path) : path_(path), rows_(readCsvRows(path)) {
  if (rows_.empty()) throw RunError(path.string() + ": is empty, a header line was expected");
  header_ = std::move(rows_.front());
  rows_.erase(rows_.begin());
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (rows_[i].size() != header_.size())
      throw RunError(path.string() + ": record " + std::to_string(i + 1) + " has " +
                     std::to_string(rows_[i].size()) + " fields, the header " +
                     std::to_string(header_.size()));
}

std::size_t CsvTable::column(const std::string& name) const {
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found == header_.end()) throw RunError(path_.string() + ": has no column '" + name + "'");
  return static_cast<std::size_t>(found - header_.begin());
}

CsvWriter::CsvWriter(const std::filesystem::path& path, const CsvRow& header) : file_(path) {
  row(header);
}

void CsvWriter::row(const CsvRow& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) line += ',';
    if (fields[i].find_first_of(",\"\r\n") == std::string::npos) {
      line += fields[i];
      continue;
    }
    line += '"';
    for (const char c : fields[i]) line += c == '"' ? std::string("\"\"") : std::string(1, c);
    line += '"';
  }
  file_.write(line + "\n");
}

}  // namespace cf
