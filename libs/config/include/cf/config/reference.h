// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "cf/base/options.h"

namespace cf {

/// Markdown table of one section: key, default, allowed values, help; one row per field visited.
std::string referenceTable(const std::function<void(OptionVisitor&)>& visit);

/// "## [section]", `about` and the table of the defaults of an options struct.
template <class Options>
std::string referenceMarkdown(const std::string& section, const std::string& about,
                              Options defaults = {}) {
  return "## [" + section + "]\n\n" + about + "\n\n" +
         referenceTable([&](OptionVisitor& v) { defaults.visit(v); });
}

}  // namespace cf
