// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <string>

#include "cf/types/ids.h"

namespace cf {

/// The central node's copy of the photos, as they crossed the seam: JPEG files in a folder, the
/// most recently used ones decoded in memory. Thread-safe; a photo asked for by two threads is
/// decoded once.
class PhotoStore {
 public:
  /// Up to `capacity` photos stay in memory.
  PhotoStore(std::filesystem::path folder, std::size_t capacity);

  /// Throws RunError where it cannot be written.
  void put(FrameId photo, const std::string& jpeg);
  /// Empty where the photo was never put.
  cv::Mat get(FrameId photo);
  /// Forgets the decoded ones.
  void leaveMemory();
  /// The same in grey, past the memory.
  cv::Mat grey(FrameId photo) const;
  /// The same at half or an eighth of its size, past the memory.
  cv::Mat half(FrameId photo) const;
  cv::Mat eighth(FrameId photo) const;
  /// Where its JPEG stands, or would.
  std::filesystem::path file(FrameId photo) const;

 private:
  cv::Mat read(FrameId photo, int reduction) const;

  struct Decoded {
    cv::Mat image;
    bool ready = false;
  };
  struct Entry {
    std::shared_ptr<Decoded> decoded;
    std::list<FrameId>::iterator use;
  };

  const std::filesystem::path folder_;
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable ready_;
  std::map<FrameId, Entry> entries_;
  std::list<FrameId> uses_;  ///< most recent first
};

}  // namespace cf
