// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/depth_triangulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

namespace cf {
namespace {

constexpr double kStep = 16;         // px between the nodes of a RayField
constexpr float kMinSine2 = 1e-8F;   // squared sine between the rays, at least
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

  std::size_t columns() const { return static_cast<std::size_t>(columns_); }
  /// Column i of the grid, where row v crosses it.
  Eigen::Vector3d onRow(int i, double v) const {
    const double y = std::clamp(v / kStep, 0.0, rows_ - 1.001);
    const int j = static_cast<int>(y);
    const double t = y - j;
    return (1 - t) * nodes_[index(i, j)] + t * nodes_[index(i, j + 1)];
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

/// The rays along one row of a RayField, which is linear between its nodes. In floats, whose
/// rounding moves a ray by 0.0002 px.
class RowRays {
 public:
  explicit RowRays(const RayField& field) : field_(field), nodes_(field.columns()) {}

  void moveTo(int v) {
    Eigen::Vector3d here = field_.onRow(0, v);
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const Eigen::Vector3d next = field_.onRow(static_cast<int>(i) + 1, v);
      nodes_[i] = {here.cast<float>(), (next - here).cast<float>()};
      here = next;
    }
  }

  Eigen::Vector3f operator()(float u) const {
    const float x = std::clamp(u * static_cast<float>(1 / kStep), 0.F,
                               static_cast<float>(nodes_.size()) - 1.001F);
    const auto i = static_cast<std::size_t>(static_cast<int>(x));
    const Node& node = nodes_[i];
    return node.ray + (x - static_cast<float>(static_cast<int>(i))) * node.step;
  }

 private:
  struct Node {
    Eigen::Vector3f ray, step;  ///< and the difference to the next node's
  };
  const RayField& field_;
  std::vector<Node> nodes_;
};

/// Matches of one row, each a pair of rays a from the origin and b from the end of the baseline.
/// Held by component, so that the compiler works on several at once.
class RowMatches {
 public:
  explicit RowMatches(std::size_t most) : columns_(most) {
    for (auto& values : values_) values.resize(most);
  }
  void clear() { size_ = 0; }
  void add(int column, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    columns_[size_] = column;
    for (int k = 0; k < 3; ++k) {
      values_[kA + k][size_] = a[k];
      values_[kB + k][size_] = b[k];
    }
    ++size_;
  }

  /// With n = a x b, the segment between the rays is shortest at ((t x b).n / n.n) a and
  /// t + ((t x a).n / n.n) b, t being the baseline.
  void intersect(const Eigen::Vector3f& baseline) {
    const float tx = baseline.x(), ty = baseline.y(), tz = baseline.z();
    float* const a[3] = {values_[kA].data(), values_[kA + 1].data(), values_[kA + 2].data()};
    float* const b[3] = {values_[kB].data(), values_[kB + 1].data(), values_[kB + 2].data()};
    float* const inverse_variance = values_[kInverseVariance].data();
    for (std::size_t i = 0; i < size_; ++i) {
      const float ax = a[0][i], ay = a[1][i], az = a[2][i];
      const float bx = b[0][i], by = b[1][i], bz = b[2][i];
      const float nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
      const float nn = nx * nx + ny * ny + nz * nz;
      const float aa = ax * ax + ay * ay + az * az, bb = bx * bx + by * by + bz * bz;
      const float along_a =
          ((ty * bz - tz * by) * nx + (tz * bx - tx * bz) * ny + (tx * by - ty * bx) * nz) / nn;
      const float along_b =
          ((ty * az - tz * ay) * nx + (tz * ax - tx * az) * ny + (tx * ay - ty * ax) * nz) / nn;
      a[0][i] = 0.5F * (along_a * ax + tx + along_b * bx);
      a[1][i] = 0.5F * (along_a * ay + ty + along_b * by);
      a[2][i] = 0.5F * (along_a * az + tz + along_b * bz);
      const float along2 = along_a * along_a;
      // Not above zero where they do not meet.
      const float parallel = nn - kMinSine2 * aa * bb;
      inverse_variance[i] =
          std::min(std::min(along_a, along_b), parallel) > 0 ? 1 / (along2 * along2 * aa) : 0;
    }
  }

  std::size_t size() const { return size_; }
  int column(std::size_t i) const { return columns_[i]; }
  bool meets(std::size_t i) const { return values_[kInverseVariance][i] > 0; }
  Eigen::Vector3f point(std::size_t i) const {
    return {values_[kA][i], values_[kA + 1][i], values_[kA + 2][i]};
  }
  /// [1/m^2] for a disparity of variance 1 by sigma_Z = Z^2.
  float inverseVariance(std::size_t i) const { return values_[kInverseVariance][i]; }

 private:
  enum { kA = 0, kB = 3, kInverseVariance = 6, kValues = 7 };
  std::size_t size_ = 0;
  std::vector<int> columns_;
  std::array<std::vector<float>, kValues> values_;
};

double disparityOf(const DepthFrame& frame, ushort stored) {
  return (stored - 1) / 16.0 + frame.disparity_offset_px;
}

}  // namespace

MapPoints triangulateDepth(const DepthFrame& frame, const PosedCamera& reference_now,
                           const PosedCamera& partner_now,
                           const DepthTriangulationOptions& options) {
  const RayField reference_field(frame.reference_view, frame.reference_camera, reference_now);
  const RayField partner_field(frame.partner_view, frame.partner_camera, partner_now);
  RowRays reference_rays(reference_field), partner_rays(partner_field);
  MapPoints result;
  result.origin_m = reference_now.T_world_cam.translation();
  const Eigen::Vector3d baseline = partner_now.T_world_cam.translation() - result.origin_m;
  const double sigma_over_fb =
      options.disparity_sigma_px / (frame.reference_view.f * baseline.norm());
  const auto weight_scale = static_cast<float>(1 / (255 * sigma_over_fb * sigma_over_fb));
  const int stride = std::max(1, options.stride);
  result.points.reserve(static_cast<std::size_t>(cv::countNonZero(frame.disparity)) /
                        (stride > 1 ? 1 + static_cast<std::size_t>(stride) : 1));
  RowMatches row(static_cast<std::size_t>(frame.disparity.cols));
  for (int v = stride / 2; v < frame.disparity.rows; v += stride) {
    const auto* disparity = frame.disparity.ptr<ushort>(v);
    const auto* confidence = frame.confidence.ptr<uchar>(v);
    const auto* colour = frame.colour.ptr<uchar>(v);
    reference_rays.moveTo(v);
    partner_rays.moveTo(v);
    row.clear();
    for (int u = stride / 2; u < frame.disparity.cols; u += stride) {
      if (disparity[u] == 0 || confidence[u] < options.min_confidence) continue;
      row.add(u, reference_rays(static_cast<float>(u)),
              partner_rays(static_cast<float>(u - disparityOf(frame, disparity[u]))));
    }
    row.intersect(baseline.cast<float>());
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (!row.meets(i)) continue;
      const int u = row.column(i);
      MapPoint point;
      point.position_m = row.point(i);
      std::copy_n(colour + 3 * u, 3, point.bgr);
      point.weight = weight_scale * static_cast<float>(confidence[u]) * row.inverseVariance(i);
      result.points.push_back(point);
    }
  }
  return result;
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
