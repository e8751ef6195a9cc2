// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Before a function that is a hot loop: it is compiled for several classes of CPU, and the best is
/// taken when the program starts. Nothing in our build lets the compiler reorder or contract
/// floating-point operations, so that each gives the same bits. Other machines and compilers get
/// the loop once.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define CF_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define CF_CLONES
#endif

/// For what such a loop calls: a call would leave its instruction set.
#define CF_INLINE inline __attribute__((always_inline))
