// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "cf/types/camera_model.h"

namespace cf {

/// The part of a photo that one window needs.
struct PhotoCrop {
  cv::Mat image;           ///< CV_8UC3; empty where the photo cannot be read
  CameraModel camera;      ///< of the whole photo at the image's scale
  cv::Point corner{0, 0};  ///< of the image in the whole
};

/// Parts of photos. A photo is decoded when one of its parts is needed first; all that are still to
/// come are cut from it and kept until their use, or, where they are too many, forgotten before,
/// those of the photo longest unused first: it is then decoded again. Thread-safe.
class PhotoCrops {
 public:
  /// Of the original photo [px], by window.
  using Parts = std::map<std::size_t, cv::Rect2f>;

  /// `parts` by photo.
  PhotoCrops(std::function<cv::Mat(std::size_t)> decode, std::vector<CameraModel> cameras,
             std::vector<Parts> parts, std::size_t budget_bytes);

  /// Hands out a part, once. What decode() throws comes out here.
  PhotoCrop get(std::size_t photo, std::size_t window);

 private:
  struct Entry {
    std::map<std::size_t, PhotoCrop> crops;  ///< by window
    bool loading = false;
    std::uint64_t used = 0;
  };
  void makeRoom(const Entry& keep);

  const std::function<cv::Mat(std::size_t)> decode_;
  const std::vector<CameraModel> cameras_;
  const std::size_t budget_bytes_;
  std::mutex mutex_;
  std::condition_variable ready_;
  std::vector<Parts> parts_;  ///< not yet handed out
  std::vector<Entry> entries_;
  std::uint64_t clock_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace cf
