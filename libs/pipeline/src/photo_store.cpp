// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <vector>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/jpeg.h"

namespace cf {

PhotoStore::PhotoStore(std::filesystem::path folder, std::size_t capacity)
    : folder_(std::move(folder)), capacity_(capacity) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw RunError(folder_.string() + " cannot be made: " + error.message());
}

void PhotoStore::put(FrameId photo, const std::string& jpeg) {
  writeFileAtomically(file(photo), jpeg);
}

cv::Mat PhotoStore::get(FrameId photo) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto [found, is_new] = entries_.try_emplace(photo);
  if (!is_new) {
    uses_.splice(uses_.begin(), uses_, found->second.use);
    const auto decoded = found->second.decoded;
    ready_.wait(lock, [&] { return decoded->ready; });
    return decoded->image;
  }
  uses_.push_front(photo);
  const auto decoded = std::make_shared<Decoded>();
  found->second = {decoded, uses_.begin()};
  lock.unlock();
  cv::Mat image = read(photo, 1);
  lock.lock();
  decoded->image = std::move(image);
  decoded->ready = true;
  ready_.notify_all();
  while (entries_.size() > capacity_) {
    entries_.erase(uses_.back());
    uses_.pop_back();
  }
  return decoded->image;
}

void PhotoStore::leaveMemory() {
  const std::lock_guard<std::mutex> lock(mutex_);
  entries_.clear();
  uses_.clear();
}

cv::Mat PhotoStore::grey(FrameId photo) const {
  return cv::imread(file(photo).string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
}

cv::Mat PhotoStore::half(FrameId photo) const { return read(photo, 2); }

cv::Mat PhotoStore::eighth(FrameId photo) const { return read(photo, 8); }

cv::Mat PhotoStore::read(FrameId photo, int reduction) const {
  std::ifstream in(file(photo), std::ios::binary | std::ios::ate);
  if (!in) return {};
  std::vector<std::uint8_t> bytes(
      static_cast<std::size_t>(std::max<std::streamoff>(0, in.tellg())));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return in ? decodeJpeg(bytes.data(), bytes.size(), reduction) : cv::Mat();
}

std::filesystem::path PhotoStore::file(FrameId photo) const {
  return folder_ / fmt::format("{}_{}.jpg", photo.uav, photo.index);
}

}  // namespace cf
