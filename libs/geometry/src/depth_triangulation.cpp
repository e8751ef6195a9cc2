// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/depth_triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cf {
namespace {

constexpr double kStep = 16;         // px between the nodes of a RayField
constexpr double kMinSine2 = 1e-8;   // squared sine between the rays, at least
constexpr int kShiftSamples = 2000;  // matches that epipolarShiftPx looks at, about

bool sameLens(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 &&
         a.p2 == b.p2 && a.k3 == b.k3;
}

/// World direction of each pixel of a rectified view under the camera and pose as known now: exact
/// on a grid, bilinear between (exact everywhere while the camera is the one of the matching).
class RayField {
 public:
  RayField(const RectifiedView& view, const CameraModel& then, const PosedCamera& now)
      : columns_(static_cast<int>(view.width / kStep) + 2),
        rows_(static_cast<int>(view.height / kStep) + 2),
        nodes_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
    const bool same = sameLens(then, now.camera);
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {
        Eigen::Vector3d ray =
            view.R_rect_cam.transpose() *
            Eigen::Vector3d((i * kStep - view.cx) / view.f, (j * kStep - view.cy) / view.f, 1);
        if (!same && ray.z() > 0) {
          const Eigen::Vector2d pixel = then.project(ray);
          const Eigen::Vector2d normalized = now.camera.undistort(pixel);
          ray = ray.z() * Eigen::Vector3d(normalized.x(), normalized.y(), 1);
        }
        node(i, j) = now.T_world_cam.linear() * ray;
      }
    }
  }

  /// Of length 1 along the rectified z axis, about.
  Eigen::Vector3d operator()(double u, double v) const {
    const double x = std::clamp(u / kStep, 0.0, columns_ - 1.001);
    const double y = std::clamp(v / kStep, 0.0, rows_ - 1.001);
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const double s = x - i, t = y - j;
    const Eigen::Vector3d* top = &nodes_[index(i, j)];
    const Eigen::Vector3d* bottom = &nodes_[index(i, j + 1)];
    return (1 - t) * ((1 - s) * top[0] + s * top[1]) + t * ((1 - s) * bottom[0] + s * bottom[1]);
  }

 private:
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(i);
  }
  Eigen::Vector3d& node(int i, int j) { return nodes_[index(i, j)]; }

  int columns_, rows_;
  std::vector<Eigen::Vector3d> nodes_;
};

double disparityOf(const DepthFrame& frame, ushort stored) {
  return (stored - 1) / 16.0 + frame.disparity_offset_px;
}

}  // namespace

std::vector<MapPoint> triangulateDepth(const DepthFrame& frame, const PosedCamera& reference_now,
                                       const PosedCamera& partner_now,
                                       const DepthTriangulationOptions& options) {
  const RayField reference_rays(frame.reference_view, frame.reference_camera, reference_now);
  const RayField partner_rays(frame.partner_view, frame.partner_camera, partner_now);
  const Eigen::Vector3d origin = reference_now.T_world_cam.translation();
  const Eigen::Vector3d baseline = partner_now.T_world_cam.translation() - origin;
  const double sigma_over_fb =
      options.disparity_sigma_px / (frame.reference_view.f * baseline.norm());
  const int stride = std::max(1, options.stride);
  std::vector<MapPoint> points;
  points.reserve(frame.disparity.total() / static_cast<std::size_t>(stride * stride));
  for (int v = stride / 2; v < frame.disparity.rows; v += stride) {
    const auto* disparity = frame.disparity.ptr<ushort>(v);
    const auto* confidence = frame.confidence.ptr<uchar>(v);
    const auto* colour = frame.colour.ptr<uchar>(v);
    for (int u = stride / 2; u < frame.disparity.cols; u += stride) {
      if (disparity[u] == 0 || confidence[u] < options.min_confidence) continue;
      const Eigen::Vector3d a = reference_rays(u, v);
      const Eigen::Vector3d b = partner_rays(u - disparityOf(frame, disparity[u]), v);
      const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
      const double determinant = aa * bb - ab * ab;
      if (determinant < kMinSine2 * aa * bb) continue;
      const double a0 = a.dot(baseline), b0 = b.dot(baseline);
      const double along_a = (bb * a0 - ab * b0) / determinant;
      const double along_b = (ab * a0 - aa * b0) / determinant;
      if (along_a <= 0 || along_b <= 0) continue;
      MapPoint point;
      point.position_m = origin + 0.5 * (along_a * a + baseline + along_b * b);
      std::copy_n(colour + 3 * u, 3, point.bgr);
      const double sigma_m = along_a * along_a * sigma_over_fb;
      point.weight = static_cast<float>(confidence[u] / 255.0 / (sigma_m * sigma_m * aa));
      points.push_back(point);
    }
  }
  return points;
}

double epipolarShiftPx(const DepthFrame& frame, const PosedCamera& reference_now,
                       const PosedCamera& partner_now) {
  const Eigen::Vector3d baseline =
      partner_now.T_world_cam.translation() - reference_now.T_world_cam.translation();
  const Eigen::Vector3d axis =
      reference_now.T_world_cam.linear() * frame.reference_view.R_rect_cam.transpose().col(2) +
      partner_now.T_world_cam.linear() * frame.partner_view.R_rect_cam.transpose().col(2);
  const Eigen::Vector3d x = baseline.normalized();
  const Eigen::Vector3d z = (axis - axis.dot(x) * x).normalized();
  const Eigen::Vector3d y = z.cross(x);
  if (!(baseline.norm() > 0) || !(y.norm() > 0.5)) return std::numeric_limits<double>::infinity();

  const RayField reference_rays(frame.reference_view, frame.reference_camera, reference_now);
  const RayField partner_rays(frame.partner_view, frame.partner_camera, partner_now);
  const int stride = std::max(
      1, static_cast<int>(std::sqrt(static_cast<double>(frame.disparity.total()) / kShiftSamples)));
  double sum = 0;
  int count = 0;
  for (int v = stride / 2; v < frame.disparity.rows; v += stride) {
    for (int u = stride / 2; u < frame.disparity.cols; u += stride) {
      const ushort stored = frame.disparity.at<ushort>(v, u);
      if (stored == 0) continue;
      const Eigen::Vector3d a = reference_rays(u, v);
      const Eigen::Vector3d b = partner_rays(u - disparityOf(frame, stored), v);
      const double shift = a.dot(y) / a.dot(z) - b.dot(y) / b.dot(z);
      sum += shift * shift;
      ++count;
    }
  }
  return count ? frame.reference_view.f * std::sqrt(sum / count) : 0;
}

}  // namespace cf
