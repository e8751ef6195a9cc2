// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ortho_paint.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cf/base/instruction_sets.h"

namespace cf {
namespace {

constexpr int kBlock = 32;  ///< nodes painted at once
constexpr int kMargin = OrthoWindow::kMargin;
constexpr int kToneCell = OrthoWindow::kToneCell;
constexpr int kToneReach = 2;          ///< cells that tones are smoothed over
constexpr float kMostCorrected = 0.7;  ///< logarithm of the greatest factor

/// Sums of colours and of weights over a window's pixels, margin included.
struct Canvas {
  cv::Mat colours;  ///< CV_32FC3
  cv::Mat weights;  ///< CV_32FC1
};

CF_CLONES void addRow(const std::uint8_t* share, const std::uint8_t* share_of_colour,
                      const std::uint8_t* colour, const float* factor, int width,
                      float* __restrict sum, float* __restrict weight) {
  for (int x = 0; x < width; ++x) weight[x] += static_cast<float>(share[x]);
  for (int c = 0; c < 3 * width; ++c)
    sum[c] += static_cast<float>(share_of_colour[c]) * factor[c] * static_cast<float>(colour[c]);
}

/// One photo on the canvas, block by block of nodes.
class Painter {
 public:
  Painter(const OrthoScene& scene, const OrthoGround& ground, const OrthoWindow& window,
          const PhotoCrop& crop, const OrthoShare& share)
      : ground_(ground),
        crop_(crop),
        view_(ground.projection(share.photo)),
        n_(scene.surface.pixelsPerNode()),
        scale_(
            static_cast<float>(crop.camera.width) /
            static_cast<float>(scene.photos[static_cast<std::size_t>(share.photo)].camera.width)),
        shares_(cv::Mat::zeros(ground.nodes().size(), CV_8UC1)) {
    share.decoded().copyTo(shares_(share.nodes));
    setFactors(scene.tones, window.tones, share);
  }

  /// `block` of nodes of the window.
  void paint(const cv::Rect& block, Canvas& canvas) const {
    const cv::Rect all({0, 0}, ground_.nodes().size());
    const cv::Rect wide =
        cv::Rect(block.x - 1, block.y - 1, block.width + 2, block.height + 2) & all;
    if (cv::countNonZero(shares_(wide)) == 0) return;
    cv::Mat places(wide.size(), CV_32FC2);
    for (int y = 0; y < wide.height; ++y)
      for (int x = 0; x < wide.width; ++x) {
        const auto sight = view_.place(ground_.local(wide.x + x, wide.y + y));
        places.at<cv::Vec2f>(y, x) = {
            (sight.u + 0.5F) * scale_ - 0.5F - static_cast<float>(crop_.corner.x),
            (sight.v + 0.5F) * scale_ - 0.5F - static_cast<float>(crop_.corner.y)};
      }
    const cv::Size fine(wide.width * n_, wide.height * n_);
    const cv::Rect pixels((block.x - wide.x) * n_, (block.y - wide.y) * n_, block.width * n_,
                          block.height * n_);
    cv::Mat fine_places, shares, colours;
    cv::resize(places, fine_places, fine, 0, 0, cv::INTER_LINEAR);
    cv::resize(shares_(wide), shares, fine, 0, 0, cv::INTER_LINEAR);
    cv::remap(crop_.image, colours, fine_places(pixels), cv::noArray(), cv::INTER_LINEAR,
              cv::BORDER_REPLICATE);
    add(block, shares(pixels), colours, canvas);
  }

 private:
  /// What brings the photo's tones to those agreed on, by cell of tones.
  void setFactors(const OrthoTones& tones, const cv::Mat& agreed, const OrthoShare& share) {
    const cv::Point low(share.nodes.x / kToneCell - kToneReach - 1,
                        share.nodes.y / kToneCell - kToneReach - 1);
    const cv::Point high((share.nodes.br().x - 1) / kToneCell + kToneReach + 2,
                         (share.nodes.br().y - 1) / kToneCell + kToneReach + 2);
    const cv::Rect cells = cv::Rect(low, high) & cv::Rect({0, 0}, agreed.size());
    cv::Mat sum(cells.size(), CV_32FC3, cv::Scalar::all(0));
    cv::Mat weight(cells.size(), CV_32FC1, cv::Scalar(1e-6));
    for (int y = 0; y < cells.height; ++y)
      for (int x = 0; x < cells.width; ++x) {
        const cv::Vec3f& wanted = agreed.at<cv::Vec3f>(cells.y + y, cells.x + x);
        if (wanted == cv::Vec3f::all(0)) continue;  // no photo there
        const auto sight = view_.project(ground_.local((cells.x + x) * kToneCell + kToneCell / 2,
                                                       (cells.y + y) * kToneCell + kToneCell / 2));
        if (sight.border < 0) continue;
        sum.at<cv::Vec3f>(y, x) = wanted - tones.shown(share.photo, sight.u, sight.v);
        weight.at<float>(y, x) = 1;
      }
    const cv::Size kernel(2 * kToneReach + 1, 2 * kToneReach + 1);
    cv::GaussianBlur(sum, sum, kernel, 1, 1, cv::BORDER_REPLICATE);
    cv::GaussianBlur(weight, weight, kernel, 1, 1, cv::BORDER_REPLICATE);
    factors_.create(cells.size(), CV_32FC3);
    for (int y = 0; y < cells.height; ++y)
      for (int x = 0; x < cells.width; ++x)
        for (int c = 0; c < 3; ++c)
          factors_.at<cv::Vec3f>(y, x)[c] =
              std::exp(std::clamp(sum.at<cv::Vec3f>(y, x)[c] / weight.at<float>(y, x),
                                  -kMostCorrected, kMostCorrected));
    corner_ = cells.tl();
  }

  void add(const cv::Rect& block, const cv::Mat& shares, const cv::Mat& colours,
           Canvas& canvas) const {
    // Factors, from the cells of tones to pixels.
    const double step = 1.0 / (n_ * kToneCell);
    const auto offset = [&](int node, int cell) {
      return static_cast<double>(node) / kToneCell - cell + 0.5 * step - 0.5;
    };
    const cv::Matx23d to_cells(step, 0, offset(block.x, corner_.x), 0, step,
                               offset(block.y, corner_.y));
    cv::Mat factors;
    cv::warpAffine(factors_, factors, to_cells, colours.size(),
                   cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
    cv::Mat wide;
    cv::cvtColor(shares, wide, cv::COLOR_GRAY2BGR);  // a share for each colour
    for (int y = 0; y < colours.rows; ++y)
      addRow(shares.ptr<std::uint8_t>(y), wide.ptr<std::uint8_t>(y), colours.ptr<std::uint8_t>(y),
             factors.ptr<float>(y), colours.cols,
             canvas.colours.ptr<float>(block.y * n_ + y) + 3 * block.x * n_,
             canvas.weights.ptr<float>(block.y * n_ + y) + block.x * n_);
  }

  const OrthoGround& ground_;
  const PhotoCrop& crop_;
  const PhotoProjection view_;
  const int n_;
  const float scale_;
  cv::Mat shares_;
  cv::Mat factors_;   ///< CV_32FC3
  cv::Point corner_;  ///< its first cell, of the window's
};

}  // namespace

cv::Mat paintOrthoWindow(const OrthoScene& scene, PhotoCrops& crops, std::size_t number,
                         const OrthoWindow& window) {
  const OrthoGround ground(scene, window.nodes, false);
  const int n = scene.surface.pixelsPerNode();
  const cv::Size size(ground.nodes().width * n, ground.nodes().height * n);
  Canvas canvas{cv::Mat(size, CV_32FC3, cv::Scalar::all(0)),
                cv::Mat(size, CV_32FC1, cv::Scalar(0))};
  for (const OrthoShare& share : window.shares) {
    const PhotoCrop crop = crops.get(static_cast<std::size_t>(share.photo), number);
    if (crop.image.empty()) continue;
    const Painter painter(scene, ground, window, crop, share);
    const cv::Rect& nodes = share.nodes;
    for (int y = nodes.y; y < nodes.br().y; y += kBlock)
      for (int x = nodes.x; x < nodes.br().x; x += kBlock)
        painter.paint(cv::Rect(x, y, kBlock, kBlock) & nodes, canvas);
  }
  cv::Mat out(size.height - 2 * kMargin * n, size.width - 2 * kMargin * n, CV_8UC4,
              cv::Scalar::all(0));
  for (int y = 0; y < out.rows; ++y) {
    const int v = y + kMargin * n;
    const auto* weight = canvas.weights.ptr<float>(v) + kMargin * n;
    const auto* sum = canvas.colours.ptr<float>(v) + 3 * kMargin * n;
    auto* pixel = out.ptr<std::uint8_t>(y);
    for (int x = 0; x < out.cols; ++x) {
      if (!(weight[x] > 127) || !ground.shown(x / n + kMargin, v / n)) continue;
      for (int c = 0; c < 3; ++c)
        pixel[4 * x + c] = cv::saturate_cast<std::uint8_t>(sum[3 * x + c] / weight[x]);
      pixel[4 * x + 3] = 255;
    }
  }
  return out;
}

}  // namespace cf
