// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "step_source.h"

namespace cf {

std::size_t StepSource::photoCount() const {
  std::size_t count = 0;
  for (const SeamHello& hello : hellos_) count += hello.photos.value_or(1);
  return count;
}

}  // namespace cf
