// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/jpeg.h"

#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

// After <cstdio>, which it takes for granted.
#include <jpeglib.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 30;

/// The library's errors come back here; it says nothing on the terminal.
struct Errors {
  jpeg_error_mgr manager;
  std::jmp_buf back;
};

[[noreturn]] void leave(j_common_ptr codec) {
  std::longjmp(reinterpret_cast<Errors*>(codec->err)->back, 1);
}
void keepQuiet(j_common_ptr, int) {}
void printNothing(j_common_ptr) {}

jpeg_error_mgr* quiet(Errors& errors) {
  jpeg_std_error(&errors.manager);
  errors.manager.error_exit = leave;
  errors.manager.emit_message = keepQuiet;
  errors.manager.output_message = printNothing;
  return &errors.manager;
}

// Where the library may jump back, there are no objects with destructors.

/// Reads the header and starts decoding into `image`'s format; false on any error, and for colours
/// that need more than the library does (CMYK).
bool start(jpeg_decompress_struct& codec, Errors& errors, const std::uint8_t* bytes,
           std::size_t size, int reduction) {
  if (setjmp(errors.back) != 0) return false;
  jpeg_create_decompress(&codec);
  jpeg_mem_src(&codec, bytes, static_cast<unsigned long>(size));
  if (jpeg_read_header(&codec, TRUE) != JPEG_HEADER_OK) return false;
  if (codec.jpeg_color_space != JCS_YCbCr && codec.jpeg_color_space != JCS_GRAYSCALE &&
      codec.jpeg_color_space != JCS_RGB)
    return false;
  codec.out_color_space = JCS_EXT_BGR;
  codec.scale_num = 1;
  codec.scale_denom = static_cast<unsigned>(reduction);
  jpeg_calc_output_dimensions(&codec);
  if (std::uint64_t{codec.output_width} * codec.output_height > kMostPixels) return false;
  return jpeg_start_decompress(&codec) != FALSE;
}

bool readRows(jpeg_decompress_struct& codec, Errors& errors, std::uint8_t* first,
              std::size_t step) {
  if (setjmp(errors.back) != 0) return false;
  constexpr unsigned kAtOnce = 16;
  JSAMPROW rows[kAtOnce];
  while (codec.output_scanline < codec.output_height) {
    for (unsigned k = 0; k < kAtOnce; ++k) rows[k] = first + (codec.output_scanline + k) * step;
    const unsigned left = codec.output_height - codec.output_scanline;
    jpeg_read_scanlines(&codec, rows, left < kAtOnce ? left : kAtOnce);
  }
  jpeg_finish_decompress(&codec);
  return true;
}

bool compress(Errors& errors, const std::uint8_t* first, std::size_t step, int width, int height,
              int quality, unsigned char** out, unsigned long* bytes) {
  jpeg_compress_struct codec;
  codec.err = quiet(errors);
  if (setjmp(errors.back) != 0) {
    jpeg_destroy_compress(&codec);
    return false;
  }
  jpeg_create_compress(&codec);
  jpeg_mem_dest(&codec, out, bytes);
  codec.image_width = static_cast<JDIMENSION>(width);
  codec.image_height = static_cast<JDIMENSION>(height);
  codec.input_components = 3;
  codec.in_color_space = JCS_EXT_BGR;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, quality, TRUE);
  jpeg_start_compress(&codec, TRUE);
  while (codec.next_scanline < codec.image_height) {
    JSAMPROW row = const_cast<std::uint8_t*>(first + codec.next_scanline * step);
    jpeg_write_scanlines(&codec, &row, 1);
  }
  jpeg_finish_compress(&codec);
  jpeg_destroy_compress(&codec);
  return true;
}

cv::Mat decodeByOpencv(const std::uint8_t* bytes, std::size_t size, int reduction) {
  const int flag = reduction == 8   ? cv::IMREAD_REDUCED_COLOR_8
                   : reduction == 4 ? cv::IMREAD_REDUCED_COLOR_4
                   : reduction == 2 ? cv::IMREAD_REDUCED_COLOR_2
                                    : cv::IMREAD_COLOR;
  try {
    return cv::imdecode(std::vector<std::uint8_t>(bytes, bytes + size),
                        flag | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

}  // namespace

bool isJpeg(const std::uint8_t* bytes, std::size_t size) {
  return size >= 4 && bytes[0] == 0xFF && bytes[1] == 0xD8;
}

cv::Mat decodeJpeg(const std::uint8_t* bytes, std::size_t size, int reduction) {
  if (!isJpeg(bytes, size)) return {};
  Errors errors;
  jpeg_decompress_struct codec;
  codec.err = quiet(errors);
  codec.mem = nullptr;
  cv::Mat image;
  bool good = start(codec, errors, bytes, size, reduction);
  const bool other_colours = !good && codec.mem && codec.jpeg_color_space >= JCS_CMYK;
  if (good) {
    image.create(static_cast<int>(codec.output_height), static_cast<int>(codec.output_width),
                 CV_8UC3);
    good = readRows(codec, errors, image.data, image.step);
  }
  if (codec.mem) jpeg_destroy_decompress(&codec);
  if (good) return image;
  return other_colours ? decodeByOpencv(bytes, size, reduction) : cv::Mat();
}

std::string encodeJpeg(const cv::Mat& image, int quality) {
  CV_Assert(image.type() == CV_8UC3);
  Errors errors;
  unsigned char* buffer = nullptr;
  unsigned long bytes = 0;
  const bool good = !image.empty() && compress(errors, image.data, image.step, image.cols,
                                               image.rows, quality, &buffer, &bytes);
  std::string out;
  if (good) out.assign(reinterpret_cast<const char*>(buffer), bytes);
  std::free(buffer);
  if (!good) throw RunError("an image cannot be coded as JPEG");
  return out;
}

}  // namespace cf
