// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/geometry/rectification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "cf/base/instruction_sets.h"

namespace cf {
namespace {

constexpr double kMaxAxisTilt = 0.7071;  // cosine between baseline and mean optical axis
constexpr double kMaxAxisSpread = 0.5;   // cosine between the two optical axes, at least
constexpr double kMinRayForward = 0.2;   // z of a unit ray in the rectified frame, at least
constexpr double kMinBaselineOverDepth = 1e-3;
constexpr int kSamples = 48;  // of the photo's longer side, to find the common area
constexpr int kGridStep = 8;  // px, of the remap table

/// Box of the points of the normalized rectified plane that both photos see, and how much that is.
struct CommonArea {
  double min_x = std::numeric_limits<double>::infinity(), max_x = -min_x;
  double min_y = min_x, max_y = -min_x;
  double nearest_m = std::numeric_limits<double>::infinity(), farthest_m = 0;  // rectified z
  double share = 0;
};

// The cells of a row of the remap table in the compiler's own vector notation.
using Floats = float __attribute__((vector_size(4 * kGridStep)));
using Integers = std::int32_t __attribute__((vector_size(4 * kGridStep)));
using Shorts = std::uint16_t __attribute__((vector_size(2 * kGridStep)));
using Bytes = std::uint8_t __attribute__((vector_size(kGridStep)));
constexpr Floats kAlongCell = {0, 0.125F, 0.25F, 0.375F, 0.5F, 0.625F, 0.75F, 0.875F};
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "pairs of shorts are packed into ints");

/// In 1/32 px: floor of a value shifted to the positive side.
CF_INLINE Integers fixedPoint(Floats v) {
  constexpr int kOne = cv::INTER_TAB_SIZE, kShift = 16384;
  return __builtin_convertvector((v + kShift * 1.F) * (kOne * 1.F) + 0.5F, Integers) -
         kShift * kOne;
}

/// A row of the table: `line` holds its crossings with the columns of the grid, x and y each.
CF_CLONES void tableRow(const float* line, int width, int max_x, int max_y, short* xy,
                        ushort* fraction, uchar* inside) {
  constexpr int kBits = cv::INTER_BITS, kOne = cv::INTER_TAB_SIZE;
  for (int from = 0; from < width; from += kGridStep) {
    const float* a = line + 2 * (from / kGridStep);
    const Integers x = fixedPoint(a[0] + kAlongCell * (a[2] - a[0]));
    const Integers y = fixedPoint(a[1] + kAlongCell * (a[3] - a[1]));
    const Integers column = x >> kBits, row = y >> kBits;
    const Integers cell = (row << 16) | (column & 0xFFFF);  // two shorts, the column first
    const Integers part = ((y & (kOne - 1)) << kBits) + (x & (kOne - 1));
    // Negative where one of them is.
    const Integers beyond = column | row | (max_x - 1 - column) | (max_y - 1 - row);
    const Shorts parts = __builtin_convertvector(part, Shorts);
    const Bytes within = __builtin_convertvector(beyond >= 0, Bytes);  // true is -1
    const auto n = static_cast<std::size_t>(std::min(kGridStep, width - from));
    std::memcpy(xy + 2 * from, &cell, n * 2 * sizeof(short));
    std::memcpy(fraction + from, &parts, n * sizeof(ushort));
    std::memcpy(inside + from, &within, n);
  }
}

bool sees(const PosedCamera& camera, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p = camera.T_world_cam.inverse() * p_world;
  if (p.z() <= 0) return false;
  // A strong distortion folds over far outside the photo: keep to a field a little wider than it.
  const CameraModel& c = camera.camera;
  if (std::abs(p.x() / p.z()) > c.width / c.fx || std::abs(p.y() / p.z()) > c.height / c.fy) {
    return false;
  }
  return c.contains(c.project(p));
}

CommonArea commonArea(const PosedCamera& reference, const PosedCamera& partner,
                      const Eigen::Matrix3d& R_rect_cam, const RectificationRequest& request) {
  CommonArea area;
  const CameraModel& camera = reference.camera;
  const double depths[] = {request.near_depth_m,
                           std::sqrt(request.near_depth_m * request.far_depth_m),
                           request.far_depth_m};
  const double search_near_m =
      request.search_near_depth_m > 0 ? request.search_near_depth_m : request.near_depth_m;
  const double search_far_m =
      request.search_far_depth_m > 0 ? request.search_far_depth_m : request.far_depth_m;
  int seen = 0, total = 0;
  for (int j = 0; j <= kSamples; ++j) {
    for (int i = 0; i <= kSamples; ++i, ++total) {
      const Eigen::Vector2d pixel((camera.width - 1.0) * i / kSamples,
                                  (camera.height - 1.0) * j / kSamples);
      const Eigen::Vector3d ray = camera.undistort(pixel).homogeneous();
      const Eigen::Vector3d rect = R_rect_cam * ray;
      if (rect.z() < kMinRayForward * ray.norm()) continue;
      bool any = false;
      for (const double depth : depths) {
        any = any || sees(partner, reference.T_world_cam * (depth * ray));
      }
      if (!any) continue;
      ++seen;
      area.nearest_m = std::min(area.nearest_m, rect.z() * search_near_m);
      area.farthest_m = std::max(area.farthest_m, rect.z() * search_far_m);
      area.min_x = std::min(area.min_x, rect.x() / rect.z());
      area.max_x = std::max(area.max_x, rect.x() / rect.z());
      area.min_y = std::min(area.min_y, rect.y() / rect.z());
      area.max_y = std::max(area.max_y, rect.y() / rect.z());
    }
  }
  area.share = static_cast<double>(seen) / total;
  return area;
}

}  // namespace

Result<RectifiedPair> rectifyPair(const PosedCamera& reference, const PosedCamera& partner,
                                  const RectificationRequest& request) {
  const Eigen::Vector3d baseline =
      partner.T_world_cam.translation() - reference.T_world_cam.translation();
  RectifiedPair pair;
  pair.baseline_m = baseline.norm();
  if (!(pair.baseline_m > kMinBaselineOverDepth * request.near_depth_m)) {
    return Failure{"no_baseline", fmt::format("the photos are {:.3f} m apart", pair.baseline_m)};
  }
  const Eigen::Vector3d axis_a = reference.T_world_cam.linear().col(2);
  const Eigen::Vector3d axis_b = partner.T_world_cam.linear().col(2);
  if (axis_a.dot(axis_b) < kMaxAxisSpread) {
    return Failure{"diverging_views",
                   fmt::format("the optical axes are {:.0f} degrees apart",
                               std::acos(std::clamp(axis_a.dot(axis_b), -1.0, 1.0)) * 57.29578)};
  }
  const Eigen::Vector3d mean_axis = (axis_a + axis_b).normalized();
  const Eigen::Vector3d x = baseline / pair.baseline_m;
  if (std::abs(x.dot(mean_axis)) > kMaxAxisTilt) {
    return Failure{"forward_motion",
                   fmt::format("the baseline is {:.0f} degrees from the optical axis",
                               std::acos(std::min(1.0, std::abs(x.dot(mean_axis)))) * 57.29578)};
  }
  const Eigen::Vector3d z = (mean_axis - mean_axis.dot(x) * x).normalized();
  Eigen::Matrix3d R_world_rect;
  R_world_rect << x, z.cross(x), z;
  pair.reference.R_rect_cam = R_world_rect.transpose() * reference.T_world_cam.linear();
  pair.partner.R_rect_cam = R_world_rect.transpose() * partner.T_world_cam.linear();
  pair.T_reference_partner = reference.T_world_cam.inverse() * partner.T_world_cam;

  const CommonArea area = commonArea(reference, partner, pair.reference.R_rect_cam, request);
  pair.overlap = area.share;
  if (area.share < request.min_overlap) {
    return Failure{"little_overlap", fmt::format("the partner sees {:.0f} % of the reference photo",
                                                 100 * area.share)};
  }
  const double box = (area.max_x - area.min_x) * (area.max_y - area.min_y);
  const CameraModel& camera = reference.camera;
  // A box along a diagonal baseline holds empty corners: the wanted size counts what is common, and
  // the box may hold twice that.
  const double photo = camera.width / camera.fx * camera.height / camera.fy;
  const double counted = std::max(std::min(area.share * photo, box), box / 2);
  const double f_native =
      std::min(std::min(camera.fx, camera.fy), std::min(partner.camera.fx, partner.camera.fy));
  const double f = std::min(f_native, std::sqrt(request.megapixels * 1e6 / counted));

  RectifiedView& r = pair.reference;
  r.f = f;
  r.width = std::max(1, static_cast<int>(std::lround(f * (area.max_x - area.min_x))));
  r.height = std::max(1, static_cast<int>(std::lround(f * (area.max_y - area.min_y))));
  r.cx = -f * area.min_x - 0.5;
  r.cy = -f * area.min_y - 0.5;
  RectifiedView& p = pair.partner;
  p.f = f;
  p.cy = r.cy;
  p.height = r.height;
  const double far_shift = f * pair.baseline_m / area.farthest_m;
  const double near_shift = f * pair.baseline_m / area.nearest_m;
  const double shift = std::ceil(near_shift);
  p.cx = r.cx + shift;
  pair.max_disparity_px = 0;
  pair.min_disparity_px = static_cast<int>(std::floor(far_shift - shift));
  p.width = r.width - pair.min_disparity_px;
  return pair;
}

RemapTable remapTable(const RectifiedView& view, const CameraModel& image_camera, cv::Range strip) {
  if (strip == cv::Range::all()) strip = {0, view.height};
  // The grid has the same nodes whatever the strip.
  const int first_row = strip.start / kGridStep;
  const int columns = view.width / kGridStep + 2;
  const int rows = (strip.end - 1) / kGridStep - first_row + 2;
  std::vector<float> grid(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) * 2);
  const Eigen::Matrix3d R_cam_rect = view.R_rect_cam.transpose();
  const float outside = -1e4F;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector3d ray =
          R_cam_rect * Eigen::Vector3d((i * kGridStep - view.cx) / view.f,
                                       ((first_row + j) * kGridStep - view.cy) / view.f, 1);
      float* node = &grid[2 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
                               static_cast<std::size_t>(i))];
      node[0] = node[1] = outside;
      const double limit_x = image_camera.width / image_camera.fx * ray.z();
      const double limit_y = image_camera.height / image_camera.fy * ray.z();
      if (ray.z() <= 0 || std::abs(ray.x()) > limit_x || std::abs(ray.y()) > limit_y) continue;
      const Eigen::Vector2d pixel = image_camera.project(ray);
      node[0] = static_cast<float>(pixel.x());
      node[1] = static_cast<float>(pixel.y());
    }
  }
  RemapTable table;
  table.fixed_xy.create(strip.size(), view.width, CV_16SC2);
  table.fraction.create(strip.size(), view.width, CV_16UC1);
  table.inside.create(strip.size(), view.width, CV_8UC1);
  const int max_x = image_camera.width - 1, max_y = image_camera.height - 1;
  std::vector<float> line(static_cast<std::size_t>(columns) * 2);
  for (int v = strip.start; v < strip.end; ++v) {
    const float* above = &grid[static_cast<std::size_t>(v / kGridStep - first_row) * line.size()];
    const float* below = above + line.size();
    const float t = static_cast<float>(v % kGridStep) / kGridStep;
    for (std::size_t k = 0; k < line.size(); ++k) line[k] = above[k] + t * (below[k] - above[k]);
    const int row = v - strip.start;
    tableRow(line.data(), view.width, max_x, max_y, table.fixed_xy.ptr<short>(row),
             table.fraction.ptr<ushort>(row), table.inside.ptr<uchar>(row));
  }
  return table;
}

}  // namespace cf
