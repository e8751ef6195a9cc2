// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/depth_frame_file.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <type_traits>
#include <vector>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"

namespace cf {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the file is little endian");

constexpr char kMagic[8] = {'C', 'F', 'D', 'E', 'P', 'T', 'H', '1'};
constexpr std::size_t kChecksumBytes = 8;

/// FNV-1a, 64 bit.
std::uint64_t checksum(const char* data, std::size_t bytes) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (std::size_t k = 0; k < bytes; ++k) {
    hash = (hash ^ static_cast<unsigned char>(data[k])) * 0x100000001b3U;
  }
  return hash;
}

class Encoder {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    raw(&value, sizeof value);
  }
  void operator()(const cv::Mat& image, const char* extension, const std::vector<int>& parameters) {
    std::vector<uchar> bytes;
    cv::imencode(extension, image, bytes, parameters);
    (*this)(static_cast<std::uint64_t>(bytes.size()));
    raw(bytes.data(), bytes.size());
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
  Decoder(const std::string& bytes, const std::string& source) : bytes_(bytes), source_(source) {
    if (bytes.size() < sizeof kMagic + kChecksumBytes ||
        std::memcmp(bytes.data(), kMagic, sizeof kMagic) != 0) {
      fail("is not a depth frame of this version");
    }
    end_ = bytes.size() - kChecksumBytes;
    std::uint64_t stored = 0;
    std::memcpy(&stored, bytes.data() + end_, sizeof stored);
    if (stored != checksum(bytes.data(), end_)) fail("is damaged: its checksum does not match");
    at_ = sizeof kMagic;
  }
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    std::memcpy(&value, take(sizeof value), sizeof value);
  }
  void operator()(cv::Mat& image, int type, cv::Size size) {
    std::uint64_t bytes = 0;
    (*this)(bytes);
    const char* from = take(bytes);
    const std::vector<uchar> data(from, from + bytes);
    if (!data.empty()) image = cv::imdecode(data, cv::IMREAD_UNCHANGED);
    if (image.type() != type || image.size() != size) fail("is damaged: an image does not fit");
  }
  void finish() {
    if (at_ != end_) fail("is damaged: there are bytes to spare");
  }

 private:
  const char* take(std::uint64_t bytes) {
    if (bytes > end_ - at_) fail("is damaged: it ends early");
    const char* from = bytes_.data() + at_;
    at_ += static_cast<std::size_t>(bytes);
    return from;
  }
  [[noreturn]] void fail(const char* what) {
    throw RunError("depth frame " + source_ + " " + what + "; delete it and match again");
  }

  const std::string& bytes_;
  std::string source_;
  std::size_t at_ = 0, end_ = 0;
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

}  // namespace

std::string encodeDepthFrame(const DepthFrame& frame) {
  Encoder encode;
  encode.raw(kMagic, sizeof kMagic);
  codeFields(encode, frame);
  const std::vector<int> png = {cv::IMWRITE_PNG_COMPRESSION, 1};
  encode(frame.disparity, ".png", png);
  encode(frame.confidence, ".png", png);
  encode(frame.colour, ".jpg", {cv::IMWRITE_JPEG_QUALITY, 90});
  return encode.finish();
}

DepthFrame decodeDepthFrame(const std::string& bytes, const std::string& source) {
  Decoder decode(bytes, source);
  DepthFrame frame;
  codeFields(decode, frame);
  const cv::Size size(frame.reference_view.width, frame.reference_view.height);
  decode(frame.disparity, CV_16UC1, size);
  decode(frame.confidence, CV_8UC1, size);
  decode(frame.colour, CV_8UC3, size);
  decode.finish();
  return frame;
}

void writeDepthFrame(const std::filesystem::path& path, const DepthFrame& frame) {
  writeFileAtomically(path, encodeDepthFrame(frame));
}

DepthFrame readDepthFrame(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw RunError("cannot read depth frame " + path.string());
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  return decodeDepthFrame(bytes, path.string());
}

}  // namespace cf
