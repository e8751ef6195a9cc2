// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/depth_frame_file.h"

#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <utility>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/image_header.h"
#include "cf/formats/jpeg.h"
#include "disparity_code.h"
#include "file_bytes.h"

namespace cf {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the file is little endian");

constexpr char kMagic[8] = {'C', 'F', 'D', 'E', 'P', 'T', 'H', '2'};
constexpr int kJpegQuality = 90;
/// A JPEG of any content takes more than a byte for so many pixels: no file makes us allocate more.
constexpr std::size_t kMaxPixelsPerByte = 256;

std::uint32_t checksum(const char* data, std::size_t bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(data), bytes));
}

class Encoder {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    raw(&value, sizeof value);
  }
  void operator()(std::string_view part) {
    (*this)(static_cast<std::uint64_t>(part.size()));
    raw(part.data(), part.size());
  }
  void raw(const void* data, std::size_t bytes) {
    out_.append(static_cast<const char*>(data), bytes);
  }
  std::string finish() {
    (*this)(checksum(out_.data(), out_.size()));
    return std::move(out_);
  }

 private:
  std::string out_;
};

class Decoder {
 public:
  Decoder(const std::string& bytes, const std::string& source) : left_(bytes), source_(source) {
    std::uint32_t stored = 0;
    if (left_.size() < sizeof kMagic + sizeof stored ||
        std::memcmp(left_.data(), kMagic, sizeof kMagic) != 0) {
      fail("is no depth frame of this version");
    }
    left_.remove_suffix(sizeof stored);
    std::memcpy(&stored, left_.data() + left_.size(), sizeof stored);
    if (stored != checksum(left_.data(), left_.size())) {
      fail("is damaged: its checksum does not match");
    }
    left_.remove_prefix(sizeof kMagic);
  }
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
  }
  std::string_view part() {
    std::uint64_t bytes = 0;
    (*this)(bytes);
    return take(bytes);
  }
  void finish() {
    if (!left_.empty()) fail("is damaged: there are bytes to spare");
  }
  [[noreturn]] void fail(const char* what) const {
    throw RunError(source_ + ": " + what + "; delete it: the pair is matched again");
  }

 private:
  std::string_view take(std::uint64_t bytes) {
    if (bytes > left_.size()) fail("is damaged: it ends early");
    const std::string_view out = left_.substr(0, static_cast<std::size_t>(bytes));
    left_.remove_prefix(out.size());
    return out;
  }

  std::string_view left_;
  std::string source_;
};

/// One list of the plain fields for both ways.
template <class Coder, class Camera>
void codeCamera(Coder& code, Camera& c) {
  for (auto* field : {&c.width, &c.height}) code(*field);
  for (auto* field : {&c.fx, &c.fy, &c.cx, &c.cy, &c.k1, &c.k2, &c.p1, &c.p2, &c.k3, &c.focal_sigma,
                      &c.k1_sigma, &c.k2_sigma}) {
    code(*field);
  }
  code(c.version);
}

template <class Coder, class View>
void codeView(Coder& code, View& view) {
  for (Eigen::Index k = 0; k < 9; ++k) code(view.R_rect_cam.data()[k]);
  for (auto* field : {&view.f, &view.cx, &view.cy}) code(*field);
  for (auto* field : {&view.width, &view.height}) code(*field);
}

template <class Coder, class Frame>
void codeFields(Coder& code, Frame& frame) {
  for (auto* id : {&frame.reference, &frame.partner}) {
    code(id->uav);
    code(id->index);
  }
  codeView(code, frame.reference_view);
  codeView(code, frame.partner_view);
  codeCamera(code, frame.reference_camera);
  codeCamera(code, frame.partner_camera);
  auto& T = frame.T_reference_partner.matrix();
  for (Eigen::Index k = 0; k < 16; ++k) code(T.data()[k]);
  code(frame.disparity_offset_px);
}

/// Empty if it is no JPEG of that size.
cv::Mat decodedColour(std::string_view jpeg, cv::Size size) {
  const auto* bytes = reinterpret_cast<const uchar*>(jpeg.data());
  const auto told = imageSizeOf(bytes, jpeg.size());
  if (!told || told->width != static_cast<unsigned>(size.width) ||
      told->height != static_cast<unsigned>(size.height))
    return {};
  return decodeJpeg(bytes, jpeg.size());
}

}  // namespace

std::string encodeDepthFrame(const DepthFrame& frame) {
  Encoder encode;
  encode.raw(kMagic, sizeof kMagic);
  codeFields(encode, frame);
  const DisparityCode code = encodeDisparity(frame.disparity, frame.confidence);
  for (const auto* part : {&code.residuals, &code.surprises, &code.confidences}) {
    encode(std::string_view(*part));
  }
  encode(std::string_view(frame.colour.empty() ? "" : encodeJpeg(frame.colour, kJpegQuality)));
  return encode.finish();
}

DepthFrame decodeDepthFrame(const std::string& bytes, const std::string& source) {
  Decoder decode(bytes, source);
  DepthFrame frame;
  codeFields(decode, frame);
  const cv::Size size(frame.reference_view.width, frame.reference_view.height);
  if (size.width <= 0 || size.height <= 0 ||
      static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) >
          kMaxPixelsPerByte * bytes.size()) {
    decode.fail("is damaged: its size is impossible");
  }
  const std::string_view residuals = decode.part(), surprises = decode.part(),
                         confidences = decode.part(), jpeg = decode.part();
  decode.finish();
  if (!decodeDisparity(residuals, surprises, confidences, size, frame.disparity,
                       frame.confidence)) {
    decode.fail("is damaged: its disparity does not fit");
  }
  if (jpeg.empty()) return frame;
  frame.colour = decodedColour(jpeg, size);
  if (frame.colour.size() != size || frame.colour.type() != CV_8UC3) {
    decode.fail("is damaged: its colour does not fit");
  }
  return frame;
}

void writeDepthFrame(const std::filesystem::path& path, const DepthFrame& frame) {
  writeFileAtomically(path, encodeDepthFrame(frame));
}

DepthFrame readDepthFrame(const std::filesystem::path& path) {
  const auto bytes = fileBytes(path);
  if (!bytes) throw RunError(path.string() + ": cannot be read");
  return decodeDepthFrame(*bytes, path.string());
}

std::optional<DepthFrame> tryReadDepthFrame(const std::filesystem::path& path) {
  const auto bytes = fileBytes(path);
  if (!bytes) return std::nullopt;
  try {
    return decodeDepthFrame(*bytes, path.string());
  } catch (const RunError&) {
    return std::nullopt;
  }
}

}  // namespace cf
