// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// For the leak sanitizer: MRPT 2.5.8 forgets a GNSS message that it finds damaged, some 70 bytes.
/// To be included by one source file of a program.
extern "C" const char* __lsan_default_suppressions() { return "leak:gnss_message::Factory"; }
