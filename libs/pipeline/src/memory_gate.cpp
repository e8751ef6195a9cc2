// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "memory_gate.h"

#include <chrono>

#include "free_memory.h"

namespace cf {
namespace {

constexpr auto kPatience = std::chrono::seconds(2);

}  // namespace

void MemoryGate::enter() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (inside_ > 0 && residentMegabytes() > full_mb_) {
    releaseFreeMemory();
    if (residentMegabytes() <= full_mb_) break;
    const std::size_t before = count_;
    if (!left_.wait_for(lock, kPatience, [&] { return count_ != before; })) break;
  }
  ++inside_;
}

void MemoryGate::leave() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (inside_ > 0) --inside_;
  ++count_;
  left_.notify_all();
}

}  // namespace cf
