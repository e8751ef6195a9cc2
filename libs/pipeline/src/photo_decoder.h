// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>

#include "cf/base/result.h"
#include "cf/types/image_frame.h"

namespace cf {

/// Decodes a photo at the smallest of JPEG's scales 1, 1/2, 1/4 that keeps `megapixels`. Failure:
/// "damaged" with the reason; a JPEG that breaks off counts as damaged.
Result<cv::Mat> decodePhoto(const ImageFrame& photo, double megapixels);

/// Decoded photos, the most recently used kept; thread-safe. A photo asked for by two threads is
/// decoded once.
class PhotoCache {
 public:
  PhotoCache(double megapixels, std::size_t capacity)
      : megapixels_(megapixels), capacity_(capacity) {}

  /// Empty where the photo is damaged.
  cv::Mat get(const ImageFrame& photo);

 private:
  struct Decoded {
    cv::Mat image;
    bool ready = false;
  };
  struct Entry {
    std::shared_ptr<Decoded> decoded;
    std::list<FrameId>::iterator use;
  };
  const double megapixels_;
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable ready_;
  std::map<FrameId, Entry> entries_;
  std::list<FrameId> uses_;  ///< most recent first
};

}  // namespace cf
