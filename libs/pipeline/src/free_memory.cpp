// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "free_memory.h"

#include <cstdlib>  // tells which C library it is

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace cf {

void releaseFreeMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace cf
