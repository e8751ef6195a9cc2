// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "cf/formats/image_header.h"

namespace cf {
namespace {

std::size_t lastMarker(const std::vector<std::uint8_t>& bytes, std::uint8_t marker) {
  for (std::size_t i = bytes.size() - 1; i > 1; --i)
    if (bytes[i] == marker && bytes[i - 1] == 0xFF) return i;
  return 0;
}

/// OpenCV decodes a JPEG that breaks off to grey without a word: there must be an end of image
/// after the last start of scan. (An embedded preview has both, further up.)
bool isWholeJpeg(const std::vector<std::uint8_t>& bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xFF || bytes[1] != 0xD8) return true;  // not a JPEG
  return lastMarker(bytes, 0xD9) > lastMarker(bytes, 0xDA);
}

Failure damaged(const std::string& what) { return {"damaged", what}; }

Result<std::vector<std::uint8_t>> bytesOf(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 30;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return damaged("file is missing");
  if (std::filesystem::file_size(file, ignored) > kMostBytes)
    return damaged("file is larger than 1 GB");
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) return damaged("file cannot be opened");
  std::vector<std::uint8_t> bytes(
      static_cast<std::size_t>(std::max<std::streamoff>(0, in.tellg())));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) return damaged("file cannot be read");
  return bytes;
}

/// What speaks against decoding a picture of that size as the photo; empty: nothing.
std::string objectionTo(const ImageSize& size, const CameraModel& camera) {
  constexpr double kMostPixels = 4e8, kRounding_px = 2;
  const double width = size.width, height = size.height;
  if (width * height > kMostPixels)
    return fmt::format("{} x {} pixels are more than any photo has", width, height);
  if (std::abs(height - width * camera.height / camera.width) > kRounding_px)
    return fmt::format("{} x {} pixels have another shape than the {} x {} of the rawlog", width,
                       height, camera.width, camera.height);
  return {};
}

}  // namespace

Result<cv::Mat> decodePhoto(const ImageFrame& photo, double megapixels) {
  const auto read = bytesOf(photo.file);
  if (!read) return read.failure();
  const std::vector<std::uint8_t>& bytes = read.value();
  if (bytes.empty()) return damaged("file is empty");
  if (!isWholeJpeg(bytes)) return damaged("JPEG breaks off");
  double full = 1e-6 * photo.camera.width * photo.camera.height;
  if (const auto size = imageSizeOf(bytes.data(), bytes.size())) {
    const std::string objection = objectionTo(*size, photo.camera);
    if (!objection.empty()) return damaged(objection);
    full = 1e-6 * size->width * size->height;
  }
  const int reduction = full / 16 >= megapixels  ? cv::IMREAD_REDUCED_COLOR_4
                        : full / 4 >= megapixels ? cv::IMREAD_REDUCED_COLOR_2
                                                 : cv::IMREAD_COLOR;
  cv::Mat image;
  try {
    image = cv::imdecode(bytes, reduction | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) return damaged("file cannot be decoded");
  return image;
}

cv::Mat PhotoCache::get(const ImageFrame& photo) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto [found, is_new] = entries_.try_emplace(photo.id);
  if (!is_new) {
    uses_.splice(uses_.begin(), uses_, found->second.use);
    const auto decoded = found->second.decoded;
    ready_.wait(lock, [&] { return decoded->ready; });
    return decoded->image;
  }
  uses_.push_front(photo.id);
  const auto decoded = std::make_shared<Decoded>();
  found->second = {decoded, uses_.begin()};
  lock.unlock();
  auto image = decodePhoto(photo, megapixels_);
  lock.lock();
  if (image) decoded->image = image.value();
  decoded->ready = true;
  ready_.notify_all();
  while (entries_.size() > capacity_) {
    entries_.erase(uses_.back());
    uses_.pop_back();
  }
  return decoded->image;
}

}  // namespace cf
