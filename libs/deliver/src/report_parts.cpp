// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report_parts.h"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>

#include "escape.h"

namespace cf {
namespace {

std::string rowHtml(const char* cell, const std::vector<std::string>& cells) {
  std::string out = "<tr>";
  for (const std::string& c : cells) out += fmt::format("<{0}>{1}</{0}>", cell, markupEscaped(c));
  return out + "</tr>\n";
}

}  // namespace

std::string heading(const std::string& title) { return "<h2>" + markupEscaped(title) + "</h2>\n"; }

std::string figure(const std::string& markup, const std::string& caption) {
  if (markup.empty()) return {};
  return "<figure>" + markup + "<figcaption>" + markupEscaped(caption) + "</figcaption></figure>\n";
}

std::string jpegUri(const cv::Mat& picture, int quality) {
  std::vector<unsigned char> jpeg;
  cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality});
  return "data:image/jpeg;base64," + base64(jpeg.data(), jpeg.size());
}

std::string tableHtml(const std::vector<std::string>& headings,
                      const std::vector<std::vector<std::string>>& rows) {
  if (rows.empty()) return {};
  std::string out = "<div class=\"scroll\"><table>\n" + rowHtml("th", headings);
  for (const auto& row : rows) out += rowHtml("td", row);
  return out + "</table></div>\n";
}

}  // namespace cf
