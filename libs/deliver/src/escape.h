// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cf {

/// Text as it may stand in XML and HTML, attributes included: what is not UTF-8 becomes a question
/// mark.
std::string markupEscaped(const std::string& text);

std::string base64(const unsigned char* bytes, std::size_t count);

}  // namespace cf
