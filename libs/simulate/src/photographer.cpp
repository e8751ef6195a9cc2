// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/photographer.h"

#include <tbb/blocked_range2d.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "cf/base/error.h"
#include "photographer_tile.h"
#include "srgb.h"
#include "texture_noise.h"

namespace cf {
namespace {

constexpr int kToneSteps = 4096;

/// sRGB's curve, in 8-bit steps, at kToneSteps + 1 equal steps of light, and one more.
std::array<float, kToneSteps + 2> toneCurve() {
  std::array<float, kToneSteps + 2> curve{};
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const double light = std::min(1.0, static_cast<double>(i) / kToneSteps);
    curve[i] = static_cast<float>(255 * srgbOf(light));
  }
  return curve;
}

/// A number of mean 0 and variance 1, near Gauss: the sum of the four bytes of a hash.
float gauss(std::uint32_t hash) {
  const auto sum =
      static_cast<float>((hash & 255U) + (hash >> 8 & 255U) + (hash >> 16 & 255U) + (hash >> 24));
  return (sum - 510) * (1 / 147.801F);
}

/// From linear light to the photo's bytes: exposure, vignetting, tone, noise.
class Development {
 public:
  Development(const TrueCamera& camera, const PhotoOptions& options, std::uint64_t seed)
      : seed_(hash2(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32))),
        gain_(std::exp(static_cast<float>(options.exposure_sigma) * gauss(hash2(seed_, 1)))),
        vignetting_(static_cast<float>(options.vignetting)),
        noise_(static_cast<float>(options.noise_sigma)),
        middle_x_(static_cast<float>(camera.width - 1) / 2),
        middle_y_(static_cast<float>(camera.height - 1) / 2) {}

  cv::Vec3b operator()(const std::array<float, 3>& light, int x, int y) const {
    static const auto kCurve = toneCurve();
    const float dx = static_cast<float>(x) - middle_x_, dy = static_cast<float>(y) - middle_y_;
    const float r2 = (dx * dx + dy * dy) / (middle_x_ * middle_x_ + middle_y_ * middle_y_ + 1e-6F);
    const float gain = gain_ * (1 - vignetting_ * r2);
    const std::uint32_t pixel =
        hash2(seed_ + static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(x));
    cv::Vec3b bytes;
    for (int c = 0; c < 3; ++c) {
      const float v = std::clamp(gain * light[static_cast<std::size_t>(c)], 0.0F, 1.0F) *
                      static_cast<float>(kToneSteps);
      const auto step = static_cast<std::size_t>(v);
      const float part = v - static_cast<float>(step);
      const float tone = kCurve[step] + part * (kCurve[step + 1] - kCurve[step]);
      // Behind the tone curve shot noise is nearly the same everywhere.
      const float sigma = noise_ * std::sqrt(1 + tone * (1 / 255.0F));
      const float noisy = tone + sigma * gauss(hash2(pixel, static_cast<std::uint32_t>(c)));
      bytes[c] = static_cast<unsigned char>(std::clamp(noisy + 0.5F, 0.0F, 255.0F));
    }
    return bytes;
  }

 private:
  std::uint32_t seed_;
  float gain_, vignetting_, noise_, middle_x_, middle_y_;
};

/// Instants over the exposure: one where things move by up to a pixel and a half (PhotoTile blurs
/// as much by itself), more beyond.
int momentsFor(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
               const PhotoOptions& options) {
  const Eigen::Vector3d at = motion.T_world_cam.translation();
  const double height_m = std::max(1.0, at.z() - scene.surfaceHeight(at.x(), at.y()));
  const double moved_px =
      camera.focal * options.exposure_s *
      (motion.velocity_mps.norm() / height_m + motion.angular_velocity_radps.norm());
  constexpr double kPerMoment_px = 1.5;
  constexpr int kMost = 32;
  return std::clamp(static_cast<int>(std::ceil(moved_px / kPerMoment_px)), 1, kMost);
}

void requireValid(const TrueCamera& camera) {
  if (camera.width < 1 || camera.height < 1 || camera.focal <= 0) {
    throw UsageError("the simulated camera has no size or no focal length");
  }
}

}  // namespace

void PhotoOptions::visit(OptionVisitor& v) {
  v.integer("edge_samples", edge_samples, {1, 64}, "rays per pixel where objects meet, else 1");
  v.number("exposure_sigma", exposure_sigma, {0, 1},
           "change of brightness from photo to photo [fraction]");
  v.number("vignetting", vignetting, {0, 0.9}, "loss of light in the corners [fraction]");
  v.number("noise_sigma", noise_sigma, {0, 50},
           "read noise [8-bit steps]; shot noise comes with it");
  v.number("exposure_s", exposure_s, {0, 1}, "shutter time [s]: motion blur");
  v.number("readout_s", readout_s, {0, 1},
           "rolling shutter: time from the first row to the last [s]; 0 = global");
  v.integer("jpeg_quality", jpeg_quality, {1, 100}, "quality of the JPEG files");
}

cv::Mat takePhoto(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
                  const PhotoOptions& options, std::uint64_t seed) {
  requireValid(camera);
  const int moments = momentsFor(scene, camera, motion, options);
  const Development develop(camera, options, seed);
  cv::Mat photo(camera.height, camera.width, CV_8UC3);
  const int columns = (camera.width + PhotoTile::kSize - 1) / PhotoTile::kSize;
  const int rows = (camera.height + PhotoTile::kSize - 1) / PhotoTile::kSize;
  tbb::enumerable_thread_specific<PhotoTile> tiles;
  tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 1, 0, columns, 4), [&](const auto& range) {
    PhotoTile& tile = tiles.local();
    for (int row = range.rows().begin(); row < range.rows().end(); ++row) {
      for (int column = range.cols().begin(); column < range.cols().end(); ++column) {
        const int x0 = column * PhotoTile::kSize, y0 = row * PhotoTile::kSize;
        tile.render(scene, camera, motion, options, x0, y0, moments);
        const int width = std::min(PhotoTile::kSize, camera.width - x0);
        const int height = std::min(PhotoTile::kSize, camera.height - y0);
        for (int y = 0; y < height; ++y) {
          auto* out = photo.ptr<cv::Vec3b>(y0 + y) + x0;
          for (int x = 0; x < width; ++x) out[x] = develop(tile.light(x, y), x0 + x, y0 + y);
        }
      }
    }
  });
  return photo;
}

cv::Mat trueDepth(const Scene& scene, const TrueCamera& camera, const CameraMotion& motion,
                  const PhotoOptions& options, int step) {
  requireValid(camera);
  if (step < 1) throw UsageError("the step of a depth map must be at least 1");
  cv::Mat depth((camera.height + step - 1) / step, (camera.width + step - 1) / step, CV_32FC1,
                cv::Scalar(0));
  tbb::parallel_for(0, depth.rows, [&](int r) {
    const double row = static_cast<double>(r) * step;
    const Eigen::Isometry3d T_world_cam = poseAt(motion, timeOfRow(camera, options, row));
    for (int c = 0; c < depth.cols; ++c) {
      const Eigen::Vector3d ray = camera.rayThrough({static_cast<double>(c) * step, row});
      const auto hit = scene.hit(T_world_cam.translation(), T_world_cam.linear() * ray);
      // The ray's z is 1: its length counts along the optical axis.
      if (hit) depth.at<float>(r, c) = static_cast<float>(hit->distance);
    }
  });
  return depth;
}

}  // namespace cf
