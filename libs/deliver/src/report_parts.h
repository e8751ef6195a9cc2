// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "cf/deliver/run_record.h"

namespace cf {

/// Sections of report.html, in its order; each is empty where there is nothing to show.

/// Verdict, self-check, chief figures, warnings with advice.
std::string summaryHtml(const RunRecord& run);
/// Trajectories over the orthophoto, height, overlap, seam.
std::string mapsHtml(const RunRecord& run, const std::filesystem::path& outdir);
/// The view that turns in the browser.
std::string view3dHtml(const RunRecord& run);
/// What was measured, as plots.
std::string accuracyPlotsHtml(const RunRecord& run);
/// How long it took, and how much memory.
std::string costHtml(const RunRecord& run);
std::string tablesHtml(const RunRecord& run);

/// <h2 id=…>…</h2>
std::string heading(const std::string& title);
/// A figure of some markup with its caption, escaped; empty without markup.
std::string figure(const std::string& markup, const std::string& caption);
/// As an attribute value: data:image/jpeg;base64,…
std::string jpegUri(const cv::Mat& picture, int quality = 85);
/// A table with its headings; cells are escaped.
std::string tableHtml(const std::vector<std::string>& headings,
                      const std::vector<std::vector<std::string>>& rows);

}  // namespace cf
