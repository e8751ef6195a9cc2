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
#include <utility>
#include <vector>

#include "cf/formats/image_header.h"
#include "cf/formats/jpeg.h"

namespace cf {
namespace {

std::size_t lastMarker(const std::vector<std::uint8_t>& bytes, std::uint8_t marker) {
  for (std::size_t i = bytes.size() - 1; i > 1; --i)
    if (bytes[i] == marker && bytes[i - 1] == 0xFF) return i;
  return 0;
}

bool isJpeg(const std::vector<std::uint8_t>& bytes) {
  return cf::isJpeg(bytes.data(), bytes.size());
}

/// OpenCV decodes a JPEG that breaks off to grey without a word: there must be an end of image
/// after the last start of scan. (An embedded preview has both, further up.)
bool isWholeJpeg(const std::vector<std::uint8_t>& bytes) {
  return !isJpeg(bytes) || lastMarker(bytes, 0xD9) > lastMarker(bytes, 0xDA);
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

constexpr int kReducedQuality = 95;

struct Decoded {
  std::vector<std::uint8_t> file;
  cv::Mat image;
  bool reduced = false;
};

/// Of another format; empty where it cannot be.
cv::Mat decodeOther(const std::vector<std::uint8_t>& bytes, int reduction) {
  const int flag = reduction == 4   ? cv::IMREAD_REDUCED_COLOR_4
                   : reduction == 2 ? cv::IMREAD_REDUCED_COLOR_2
                                    : cv::IMREAD_COLOR;
  try {
    return cv::imdecode(bytes, flag | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

Result<Decoded> decode(const ImageFrame& photo, double megapixels) {
  auto read = bytesOf(photo.file);
  if (!read) return read.failure();
  Decoded out{std::move(read.value()), {}, false};
  const std::vector<std::uint8_t>& bytes = out.file;
  if (bytes.empty()) return damaged("file is empty");
  if (!isWholeJpeg(bytes)) return damaged("JPEG breaks off");
  double full = 1e-6 * photo.camera.width * photo.camera.height;
  if (const auto size = imageSizeOf(bytes.data(), bytes.size())) {
    const std::string objection = objectionTo(*size, photo.camera);
    if (!objection.empty()) return damaged(objection);
    full = 1e-6 * size->width * size->height;
  }
  const int reduction = full / 16 >= megapixels ? 4 : full / 4 >= megapixels ? 2 : 1;
  out.reduced = reduction > 1;
  out.image = isJpeg(bytes) ? decodeJpeg(bytes.data(), bytes.size(), reduction)
                            : decodeOther(bytes, reduction);
  if (out.image.empty()) return damaged("file cannot be decoded");
  return out;
}

}  // namespace

Result<cv::Mat> decodePhoto(const ImageFrame& photo, double megapixels) {
  auto decoded = decode(photo, megapixels);
  if (!decoded) return decoded.failure();
  return decoded.value().image;
}

Result<TakenPhoto> takePhoto(const ImageFrame& photo, double megapixels) {
  auto decoded = decode(photo, megapixels);
  if (!decoded) return decoded.failure();
  const std::vector<std::uint8_t>& file = decoded.value().file;
  const cv::Mat& image = decoded.value().image;
  const bool as_it_is = !decoded.value().reduced && isJpeg(file);
  return TakenPhoto{
      image, as_it_is ? std::string(file.begin(), file.end()) : encodeJpeg(image, kReducedQuality)};
}

}  // namespace cf
