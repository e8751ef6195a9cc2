// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/base/result.h"
#include "figures.h"

namespace cf {

/// A part of the evaluation, or why it cannot be computed. The keys are those of
/// docs/evaluation.md.
using RunSection = Result<Json>;

}  // namespace cf
