// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cf/import/import.h"

namespace cf {

/// importFlights() of folders into which photos keep arriving.
ImportSummary followFolders(const ImportOptions& options);

}  // namespace cf
