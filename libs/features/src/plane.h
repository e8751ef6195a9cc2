// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "cf/base/instruction_sets.h"

namespace cf::sift {

/// A grey image of floats, 0 to 1. Rows are padded to whole blocks, which hold nothing of use.
class Plane {
 public:
  static constexpr int kBlock = 64;

  Plane() = default;
  Plane(int width, int height)
      : width_(width),
        height_(height),
        stride_((width + kBlock - 1) / kBlock * kBlock),
        data_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height)) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int stride() const { return stride_; }
  const float* data() const { return data_.data(); }
  float* row(int y) { return data_.data() + static_cast<std::ptrdiff_t>(y) * stride_; }
  const float* row(int y) const { return data_.data() + static_cast<std::ptrdiff_t>(y) * stride_; }

 private:
  int width_ = 0, height_ = 0, stride_ = 0;
  std::vector<float> data_;
};

}  // namespace cf::sift
