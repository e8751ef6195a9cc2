// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/pose_covariance_csv.h"

#include <fmt/format.h>

#include <limits>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/formats/csv.h"

namespace cf {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Each matrix with the prefix of its columns' names.
constexpr std::pair<const char*, Matrix6d PoseCovariance::*> kMatrices[] = {
    {"world", &PoseCovariance::in_world}, {"map", &PoseCovariance::in_map}};
constexpr const char* kNames[] = {"tx", "ty", "tz", "rx", "ry", "rz"};

/// Of the upper triangle, row by row.
template <class Visit>
void forEachEntry(const Visit& visit) {
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) visit(i, j);
}

std::string columnOf(const char* prefix, int i, int j) {
  return fmt::format("{}_{}_{}", prefix, kNames[i], kNames[j]);
}

}  // namespace

void writePoseCovariances(const std::filesystem::path& file,
                          const std::vector<PoseCovarianceRow>& rows) {
  CsvRow header = {"image", "t", "component"};
  for (const auto& [prefix, matrix] : kMatrices)
    forEachEntry([&, p = prefix](int i, int j) { header.push_back(columnOf(p, i, j)); });
  CsvWriter csv(file, header);
  for (const PoseCovarianceRow& row : rows) {
    CsvRow out = {row.image, timeText(row.time), std::to_string(row.component)};
    for (const auto& [prefix, matrix] : kMatrices)
      forEachEntry([&, m = row.covariance.*matrix](int i, int j) {
        out.push_back(fmt::format("{:.9g}", m(i, j)));
      });
    csv.row(out);
  }
  csv.close();
}

std::vector<PoseCovarianceRow> readPoseCovariances(const std::filesystem::path& file) {
  const CsvTable table(file);
  const auto not_a = [&](const char* wanted, const std::string& column) {
    return RunError(file.string() + ": a value of column " + column + " is no " + wanted);
  };
  const auto number = [&](const CsvRow& row, const std::string& column) {
    const auto value = numberFrom(row[table.column(column)]);
    if (!value) throw not_a("number", column);
    return *value;
  };
  const auto component = [&](const CsvRow& row) {
    const double value = number(row, "component");
    if (!(value >= 0 && value <= std::numeric_limits<int>::max()))
      throw not_a("count", "component");
    return static_cast<int>(value);
  };
  const auto time = [&](const std::string& text) {
    try {
      return timeFromText(text);
    } catch (const RunError&) {
      throw not_a("time", "t");
    }
  };
  const std::size_t image = table.column("image"), t = table.column("t");
  std::vector<PoseCovarianceRow> rows;
  for (const CsvRow& row : table.rows()) {
    PoseCovarianceRow out{row[image], time(row[t]), component(row), {}};
    for (const auto& [prefix, matrix] : kMatrices)
      forEachEntry([&, p = prefix, member = matrix](int i, int j) {
        Matrix6d& m = out.covariance.*member;
        m(i, j) = m(j, i) = number(row, columnOf(p, i, j));
      });
    rows.push_back(std::move(out));
  }
  return rows;
}

}  // namespace cf
