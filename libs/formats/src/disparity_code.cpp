// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "disparity_code.h"

#include <cstring>

#include "zstd_bytes.h"

namespace cf {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kUnmatched = 255;
constexpr std::uint8_t kSurprise = 254;  // and above: what a byte does not hold

/// Small steps of either sign to small numbers: 0, -1, 1, -2, ... to 0, 1, 2, 3, ...
std::uint16_t zigzag(std::uint16_t step) {
  return static_cast<std::uint16_t>((step << 1) ^ ((step & 0x8000) != 0 ? 0xFFFF : 0));
}
std::uint16_t unzigzag(std::uint16_t code) {
  return static_cast<std::uint16_t>((code >> 1) ^ ((code & 1) != 0 ? 0xFFFF : 0));
}

/// What is expected of the next pixel of a row: a plane through its neighbours, all modulo 2^16.
/// Unmatched pixels count as their left neighbour.
class Foretelling {
 public:
  explicit Foretelling(int columns) : above_(static_cast<std::size_t>(columns)) {}

  void beginRow() {
    next_ = above_.data();
    left_ = above_left_ = *next_;
  }
  std::uint16_t expected() const {
    return static_cast<std::uint16_t>(left_ + *next_ - above_left_);
  }
  void unmatched() { matched(left_); }
  void matched(std::uint16_t value) {
    above_left_ = *next_;
    *next_++ = left_ = value;
  }

 private:
  std::vector<std::uint16_t> above_;
  std::uint16_t* next_ = nullptr;
  std::uint16_t left_ = 0, above_left_ = 0;
};

}  // namespace

DisparityCode encodeDisparity(const cv::Mat& disparity, const cv::Mat& confidence) {
  Bytes residuals(disparity.total()), confidences(disparity.total());
  DisparityCode out;
  Foretelling foretelling(disparity.cols);
  std::size_t at = 0;
  for (int v = 0; v < disparity.rows; ++v) {
    const auto* values = disparity.ptr<std::uint16_t>(v);
    const auto* sure = confidence.ptr<std::uint8_t>(v);
    foretelling.beginRow();
    std::uint8_t last_sure = 0;
    for (int u = 0; u < disparity.cols; ++u, ++at) {
      if (values[u] == 0) {
        residuals[at] = kUnmatched;
        confidences[at] = sure[u];
        foretelling.unmatched();
        continue;
      }
      const std::uint16_t surprise =
          zigzag(static_cast<std::uint16_t>(values[u] - foretelling.expected()));
      foretelling.matched(values[u]);
      if (surprise < kSurprise) {
        residuals[at] = static_cast<std::uint8_t>(surprise);
      } else {
        residuals[at] = kSurprise;
        out.surprises.push_back(static_cast<char>(surprise & 0xFF));
        out.surprises.push_back(static_cast<char>(surprise >> 8));
      }
      confidences[at] = static_cast<std::uint8_t>(sure[u] - last_sure);
      last_sure = sure[u];
    }
  }
  out.residuals = zstdPressed(residuals);
  out.confidences = zstdPressed(confidences);
  return out;
}

bool decodeDisparity(std::string_view residuals, std::string_view surprises,
                     std::string_view confidences, cv::Size size, cv::Mat& disparity,
                     cv::Mat& confidence) {
  const auto pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  Bytes steps, sure_steps;
  if (!zstdUnpress(residuals, pixels, steps) || !zstdUnpress(confidences, pixels, sure_steps))
    return false;
  disparity.create(size, CV_16UC1);
  confidence.create(size, CV_8UC1);
  Foretelling foretelling(size.width);
  std::size_t at = 0;
  for (int v = 0; v < size.height; ++v) {
    auto* values = disparity.ptr<std::uint16_t>(v);
    auto* sure = confidence.ptr<std::uint8_t>(v);
    foretelling.beginRow();
    std::uint8_t last_sure = 0;
    for (int u = 0; u < size.width; ++u, ++at) {
      std::uint16_t step = steps[at];
      if (step == kUnmatched) {
        values[u] = 0;
        sure[u] = sure_steps[at];
        foretelling.unmatched();
        continue;
      }
      if (step == kSurprise) {
        if (surprises.size() < sizeof step) return false;
        std::memcpy(&step, surprises.data(), sizeof step);
        surprises.remove_prefix(sizeof step);
      }
      values[u] = static_cast<std::uint16_t>(foretelling.expected() + unzigzag(step));
      foretelling.matched(values[u]);
      sure[u] = last_sure = static_cast<std::uint8_t>(last_sure + sure_steps[at]);
    }
  }
  return surprises.empty();
}

}  // namespace cf
