// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/depth_triangulation.h"

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>

namespace cf {
namespace {

constexpr double kStep = 16;        // px between the nodes of a RayField
constexpr float kMinSine2 = 1e-8F;  // squared sine between the rays, at least

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
      nodes_[i].ray << here.cast<float>(), 0;
      nodes_[i].step << (next - here).cast<float>(), 0;
      here = next;
    }
  }

  /// x, y, z and a zero.
  Eigen::Vector4f operator()(float u) const {
    const float x = std::clamp(u * static_cast<float>(1 / kStep), 0.F,
                               static_cast<float>(nodes_.size()) - 1.001F);
    const int i = static_cast<int>(x);
    const Node& node = nodes_[static_cast<std::size_t>(i)];
    return node.ray + (x - static_cast<float>(i)) * node.step;
  }

 private:
  struct Node {
    Eigen::Vector4f ray, step;  ///< and the difference to the next node's
  };
  const RayField& field_;
  std::vector<Node> nodes_;
};

/// Matches of one row, each a pair of rays a from the origin and b from the end of the baseline.
class RowMatches {
 public:
  explicit RowMatches(int most)
      : columns_(static_cast<std::size_t>(most)),
        a_(padded(most), Eigen::Vector4f::Zero()),
        b_(a_) {}
  void clear() { size_ = 0; }
  void add(int column, const Eigen::Vector4f& a, const Eigen::Vector4f& b) {
    columns_[size_] = column;
    a_[size_] = a;
    b_[size_] = b;
    ++size_;
  }

  /// With n = a x b, the segment between the rays is shortest at ((t x b).n / n.n) a and
  /// t + ((t x a).n / n.n) b, t being the baseline. Four at once: a lane each.
  void intersect(const Eigen::Vector3f& t) {
    using Lanes = Eigen::Array4f;
    using Rays = std::array<Lanes, 3>;
    const auto cross = [](const auto& p, const Rays& q) {
      return Rays{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    };
    const auto dot = [](const Rays& p, const Rays& q) -> Lanes {
      return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    };
    const auto lanes = [](const Eigen::Vector4f* rays) {
      Eigen::Matrix4f matrix = Eigen::Map<const Eigen::Matrix4f>(rays->data());
      matrix.transposeInPlace();
      return Rays{matrix.col(0), matrix.col(1), matrix.col(2)};
    };
    for (std::size_t i = 0; i < size_; i += 4) {
      const Rays a = lanes(&a_[i]), b = lanes(&b_[i]);
      const Rays n = cross(a, b);
      const Lanes nn = dot(n, n), aa = dot(a, a);
      const Lanes along_a = dot(cross(t, b), n) / nn;
      const Lanes along_b = dot(cross(t, a), n) / nn;
      const Lanes along2 = along_a * along_a;
      Eigen::Matrix4f result;
      for (int k = 0; k < 3; ++k)
        result.col(k) = 0.5F * (along_a * a[static_cast<std::size_t>(k)] + t[k] +
                                along_b * b[static_cast<std::size_t>(k)]);
      result.col(3) = (along2 * along2 * aa).inverse();
      result.transposeInPlace();
      Eigen::Map<Eigen::Matrix4f>(a_[i].data()) = result;
      const Lanes in_front = along_a.min(along_b);
      const Lanes apart = nn - kMinSine2 * aa * dot(b, b);
      b_[i] = in_front.min(apart);
    }
  }

  std::size_t size() const { return size_; }
  int column(std::size_t i) const { return columns_[i]; }
  bool meets(std::size_t i) const { return b_[i - i % 4][static_cast<Eigen::Index>(i % 4)] > 0; }
  Eigen::Vector3f point(std::size_t i) const { return a_[i].head<3>(); }
  /// [1/m^2] for a disparity of variance 1 by sigma_Z = Z^2.
  float inverseVariance(std::size_t i) const { return a_[i][3]; }

 private:
  static std::size_t padded(int most) { return static_cast<std::size_t>(most) + 3; }

  std::size_t size_ = 0;
  std::vector<int> columns_;
  std::vector<Eigen::Vector4f> a_;  ///< rays; after intersect() points and inverse variances
  std::vector<Eigen::Vector4f> b_;  ///< rays; then, by fours, above zero where they meet
};

}  // namespace

MapPoints triangulateDepth(const DepthFrame& frame, const PosedCamera& reference_now,
                           const PosedCamera& partner_now,
                           const DepthTriangulationOptions& options) {
  CV_Assert(frame.colour.type() == CV_8UC3 && frame.colour.size() == frame.disparity.size());
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
  RowMatches row(frame.disparity.cols);
  const auto to_partner = static_cast<float>(1 / 16.0 - frame.disparity_offset_px);
  for (int v = stride / 2; v < frame.disparity.rows; v += stride) {
    const auto* disparity = frame.disparity.ptr<ushort>(v);
    const auto* confidence = frame.confidence.ptr<uchar>(v);
    const auto* colour = frame.colour.ptr<uchar>(v);
    reference_rays.moveTo(v);
    partner_rays.moveTo(v);
    row.clear();
    for (int u = stride / 2; u < frame.disparity.cols; u += stride) {
      if (disparity[u] == 0 || confidence[u] < options.min_confidence) continue;
      row.add(
          u, reference_rays(static_cast<float>(u)),
          partner_rays(static_cast<float>(u) - static_cast<float>(disparity[u]) / 16 + to_partner));
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

}  // namespace cf
