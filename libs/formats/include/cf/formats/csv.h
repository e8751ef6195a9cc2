// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "cf/formats/atomic_file.h"

namespace cf {

/// Comma separated values after RFC 4180: fields with a separator, a quote or a line break are
/// quoted, quotes in them doubled. Lines may end in LF or CRLF; empty lines are skipped.
using CsvRow = std::vector<std::string>;

/// All rows, the header (if any) included. Throws RunError naming file and line on an open quote.
std::vector<CsvRow> readCsvRows(const std::filesystem::path& path, char separator = ',');

/// A file whose first row names the columns; every row has as many fields.
class CsvTable {
 public:
  explicit CsvTable(const std::filesystem::path& path);
  /// Index of the column, or RunError naming file and column.
  std::size_t column(const std::string& name) const;
  const std::vector<CsvRow>& rows() const { return rows_; }

 private:
  std::filesystem::path path_;
  CsvRow header_;
  std::vector<CsvRow> rows_;
};

/// Appears under its name at close(), which must be called.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& path, const CsvRow& header);
  void row(const CsvRow& fields);
  void close() { file_.commit(); }

 private:
  AtomicFile file_;
};

}  // namespace cf
