// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cf::support {

/// What an error of this kind says that `function` throws.
template <class Error, class Function>
std::string messageOf(const Function& function) {
  try {
    function();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace cf::support
