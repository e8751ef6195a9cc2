// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_crops.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

namespace cf {
namespace {

std::size_t bytesOf(const PhotoCrop& crop) { return crop.image.total() * crop.image.elemSize(); }

PhotoCrop cut(const cv::Mat& whole, const CameraModel& original, const cv::Rect2f& part) {
  PhotoCrop crop;
  if (whole.empty()) return crop;
  crop.camera = original.scaled(whole.cols, whole.rows);
  const float scale = static_cast<float>(whole.cols) / static_cast<float>(original.width);
  constexpr int kRoom_px = 2;  // for interpolation
  const cv::Point low(static_cast<int>(std::floor(part.x * scale)) - kRoom_px,
                      static_cast<int>(std::floor(part.y * scale)) - kRoom_px);
  const cv::Point high(static_cast<int>(std::ceil(part.br().x * scale)) + kRoom_px + 1,
                       static_cast<int>(std::ceil(part.br().y * scale)) + kRoom_px + 1);
  const cv::Rect inside = cv::Rect(low, high) & cv::Rect(0, 0, whole.cols, whole.rows);
  if (inside.empty()) return crop;
  crop.image = whole(inside).clone();
  crop.corner = inside.tl();
  return crop;
}

}  // namespace

PhotoCrops::PhotoCrops(std::function<cv::Mat(std::size_t)> decode, std::vector<CameraModel> cameras,
                       std::vector<Parts> parts, std::size_t budget_bytes)
    : decode_(std::move(decode)),
      cameras_(std::move(cameras)),
      budget_bytes_(budget_bytes),
      parts_(std::move(parts)),
      entries_(cameras_.size()) {}

PhotoCrop PhotoCrops::get(std::size_t photo, std::size_t window) {
  std::unique_lock<std::mutex> lock(mutex_);
  Entry& entry = entries_[photo];
  ready_.wait(lock, [&] { return !entry.loading; });
  entry.used = ++clock_;
  if (entry.crops.count(window) == 0) {
    entry.loading = true;
    const Parts parts = parts_[photo];
    lock.unlock();
    std::map<std::size_t, PhotoCrop> crops;
    try {
      const cv::Mat whole = decode_(photo);
      for (const auto& [number, part] : parts) crops[number] = cut(whole, cameras_[photo], part);
    } catch (...) {
      lock.lock();
      entry.loading = false;  // who waits for it tries for himself
      ready_.notify_all();
      throw;
    }
    lock.lock();
    for (const auto& [number, crop] : crops) bytes_ += bytesOf(crop);
    entry.crops = std::move(crops);
    entry.loading = false;
    makeRoom(entry);
    ready_.notify_all();
  }
  const PhotoCrop crop = entry.crops[window];
  bytes_ -= bytesOf(crop);
  entry.crops.erase(window);
  parts_[photo].erase(window);
  return crop;
}

void PhotoCrops::makeRoom(const Entry& keep) {
  while (bytes_ > budget_bytes_) {
    Entry* oldest = nullptr;
    for (Entry& entry : entries_)
      if (&entry != &keep && !entry.crops.empty() && (!oldest || entry.used < oldest->used))
        oldest = &entry;
    if (oldest == nullptr) return;
    for (const auto& [number, crop] : oldest->crops) bytes_ -= bytesOf(crop);
    oldest->crops.clear();
  }
}

}  // namespace cf
