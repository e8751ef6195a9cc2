// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/gcp_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/formats/text_lines.h"

namespace cf {
namespace {

struct Entry {
  std::string name;  ///< empty: none given
  Eigen::Vector3d surveyed;
  GcpMark mark;
};

Entry entryFrom(const std::string& line) {
  const std::vector<std::string> words = wordsOf(line);
  if (words.size() < 6 || words.size() > 7)
    throw UsageError("'x y z px py image [name]' was expected");
  std::array<double, 5> v;
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = numberFrom(words[i]);
    if (!value) throw UsageError("'" + words[i] + "' is not a number");
    v[i] = *value;
  }
  return {words.size() == 7 ? words[6] : "", {v[0], v[1], v[2]}, {words[5], {v[3], v[4]}}};
}

void add(const Entry& entry, std::vector<GroundControlPoint>& points, std::vector<bool>& has_name) {
  std::size_t i = 0;
  for (; i < points.size(); ++i)
    if (has_name[i] ? points[i].name == entry.name
                    : entry.name.empty() && points[i].surveyed == entry.surveyed)
      break;
  if (i == points.size()) {
    points.push_back({entry.name.empty() ? std::to_string(i + 1) : entry.name, entry.surveyed, {}});
    has_name.push_back(!entry.name.empty());
  }
  if (points[i].surveyed != entry.surveyed)
    throw UsageError("point " + entry.name + " has another position in a line above");
  for (const GcpMark& mark : points[i].marks)
    if (mark.image == entry.mark.image)
      throw UsageError(fmt::format("point {} is marked twice in {}", points[i].name, mark.image));
  points[i].marks.push_back(entry.mark);
}

}  // namespace

GcpList readGcpList(const std::filesystem::path& file) {
  GcpList list;
  list.file = file;
  std::vector<bool> has_name;
  for (const TextLine& line : readTextLines(file)) {
    if (list.crs.empty()) {
      list.crs = line.text;
      continue;
    }
    try {
      add(entryFrom(line.text), list.points, has_name);
    } catch (const UsageError& e) {
      throw UsageError(fmt::format("{}:{}: {}", file.string(), line.number, e.what()));
    }
  }
  if (list.points.empty())
    throw UsageError(fmt::format(
        "{} marks no point: after the CRS, lines 'x y z px py image' are needed", file.string()));
  return list;
}

}  // namespace cf
