// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "ortho_ground.h"

namespace cf {

/// Which part a photo has in a window.
struct OrthoShare {
  int photo = 0;
  cv::Rect nodes;                     ///< of the window where it has a part
  cv::Rect2f part;                    ///< of the photo [px] that is needed
  std::vector<std::uint8_t> weights;  ///< PNG over `nodes`, 0..255
  cv::Mat decoded() const;            ///< CV_8UC1
};

/// What a window is made of.
struct OrthoWindow {
  /// Nodes around a window that it is shared and painted with, so that shares, places and tones can
  /// be interpolated up to its edge. Whole tone cells.
  static constexpr int kMargin = 16;
  /// Nodes along a side of a cell of tones.
  static constexpr int kToneCell = 8;

  cv::Rect nodes;  ///< of the surface, with the margin
  std::vector<OrthoShare> shares;
  cv::Mat tones;  ///< CV_32FC3: logarithms of the colours that all photos agree on
};

/// Decides by geometry what the picture of `area` [nodes] is made of: at each node of the photo of
/// the least demerit that sees it; photos hardly worse have a part too, so that seams are soft;
/// where all are hidden, of the one that is nearly free.
///
/// And the tone of each place: the mean of what all photos show there that do not disagree with
/// the photo chosen (another thing is in front), steep ones counting most. Each photo is later
/// brought to it: so low frequencies are blended over tens of metres, while details come from one
/// photo.
OrthoWindow shareOrthoWindow(const OrthoScene& scene, const cv::Rect& area);

}  // namespace cf
