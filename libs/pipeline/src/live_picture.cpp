// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "live_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>

#include "cf/view/render.h"

namespace cf {
namespace {

constexpr double kMostPixels = 2000;  // a side
const cv::Scalar kBackground(40, 40, 40);

/// A horizontal picture of a part of the world, north up.
class Sheet {
 public:
  /// Around what has been included, with cells of at least `least_cell_m`.
  void include(const Eigen::Vector2d& p) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  bool empty() const { return !(low_.x() < high_.x() && low_.y() < high_.y()); }
  void layOut(double least_cell_m) {
    cell_m_ = std::max(least_cell_m, (high_ - low_).maxCoeff() / kMostPixels);
  }
  cv::Size size() const {
    const Eigen::Vector2d cells = (high_ - low_) / cell_m_;
    return {static_cast<int>(cells.x()) + 1, static_cast<int>(cells.y()) + 1};
  }
  cv::Point at(const Eigen::Vector2d& p) const {
    return {static_cast<int>((p.x() - low_.x()) / cell_m_),
            static_cast<int>((high_.y() - p.y()) / cell_m_)};
  }

 private:
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_ = -low_;
  double cell_m_ = 1;
};

Eigen::Vector2d centreOf(const DenseView& view) { return view.T_world_cam.translation().head<2>(); }

void drawTracks(const std::vector<DenseView>& views, std::uint16_t central_uav, const Sheet& sheet,
                cv::Mat& picture) {
  std::map<std::uint16_t, std::vector<cv::Point>> tracks;
  for (const DenseView& view : views) tracks[view.id.uav].push_back(sheet.at(centreOf(view)));
  const int width = std::max(1, picture.cols / 500);
  std::size_t other = 0;
  for (const auto& [uav, points] : tracks) {
    const bool central = uav == central_uav;
    const auto rgb = uavColour(central, other);
    if (!central) ++other;
    const cv::Scalar colour(rgb[2], rgb[1], rgb[0]);
    cv::polylines(picture, points, false, colour, width, cv::LINE_AA);
    const int r = 5 * width;
    const cv::Point& end = points.back();
    const std::vector<cv::Point> triangle = {
        {end.x, end.y - r}, {end.x - r, end.y + r}, {end.x + r, end.y + r}};
    cv::fillConvexPoly(picture, triangle, colour, cv::LINE_AA);
  }
}

/// The photo's corners on level ground at its median depth.
std::array<Eigen::Vector2d, 4> footprint(const DenseView& view) {
  const CameraModel& c = view.camera;
  const double ground = view.T_world_cam.translation().z() - view.median_depth_m;
  std::array<Eigen::Vector2d, 4> corners;
  const std::array<Eigen::Vector2d, 4> pixels = {
      Eigen::Vector2d(0, 0), Eigen::Vector2d(c.width - 1, 0),
      Eigen::Vector2d(c.width - 1, c.height - 1), Eigen::Vector2d(0, c.height - 1)};
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d ray = view.T_world_cam.linear() * c.undistort(pixels[k]).homogeneous();
    const Eigen::Vector3d centre = view.T_world_cam.translation();
    // A ray that hardly goes down ends at three times the median depth.
    const double down = std::max(-ray.z(), ray.norm() / 3);
    corners[k] = (centre + (centre.z() - ground) / down * ray).head<2>();
  }
  return corners;
}

cv::Vec3b coverageColour(int photos) {
  static const std::array<cv::Vec3b, 6> kColours = {
      cv::Vec3b(40, 40, 40),   cv::Vec3b(40, 40, 200),  cv::Vec3b(30, 120, 240),
      cv::Vec3b(40, 210, 240), cv::Vec3b(90, 220, 160), cv::Vec3b(60, 170, 50)};
  return kColours[static_cast<std::size_t>(std::min(photos, 5))];
}

void drawLegend(cv::Mat& picture) {
  const int step = std::max(14, picture.cols / 60);
  const double font = step / 30.0;
  const cv::Rect panel = cv::Rect(step / 2, step / 2, 12 * step, 6 * step);
  cv::rectangle(picture, panel & cv::Rect({}, picture.size()), kBackground, cv::FILLED);
  for (int n = 1; n <= 5; ++n) {
    const int y = n * step;
    cv::rectangle(picture, cv::Rect(step, y, step, 4 * step / 5) & cv::Rect({}, picture.size()),
                  cv::Scalar(coverageColour(n)), cv::FILLED);
    cv::putText(picture,
                std::to_string(n) + (n == 5   ? " or more photos"
                                     : n == 1 ? " photo"
                                              : ""),
                {5 * step / 2, y + 3 * step / 4}, cv::FONT_HERSHEY_SIMPLEX, font,
                cv::Scalar::all(255), 1, cv::LINE_AA);
  }
}

}  // namespace

cv::Mat liveMapPicture(const std::vector<Tile>& tiles, double voxel_m,
                       const std::vector<DenseView>& views, std::uint16_t central_uav) {
  Sheet sheet;
  for (const Tile& tile : tiles)
    for (const TilePoint& p : tile.points)
      sheet.include(tile.offset_m.head<2>() + p.position_m.head<2>().cast<double>());
  if (sheet.empty()) return {};
  for (const DenseView& view : views) sheet.include(centreOf(view));
  sheet.layOut(voxel_m);
  cv::Mat picture(sheet.size(), CV_8UC3, kBackground);
  cv::Mat height(sheet.size(), CV_32F, cv::Scalar(-std::numeric_limits<float>::infinity()));
  for (const Tile& tile : tiles)
    for (const TilePoint& p : tile.points) {
      const cv::Point at =
          sheet.at(tile.offset_m.head<2>() + p.position_m.head<2>().cast<double>());
      if (!(p.position_m.z() > height.at<float>(at))) continue;
      height.at<float>(at) = p.position_m.z();
      picture.at<cv::Vec3b>(at) = {p.bgr[0], p.bgr[1], p.bgr[2]};
    }
  drawTracks(views, central_uav, sheet, picture);
  return picture;
}

cv::Mat coveragePicture(const std::vector<DenseView>& views, std::uint16_t central_uav) {
  Sheet sheet;
  for (const DenseView& view : views)
    for (const Eigen::Vector2d& corner : footprint(view)) sheet.include(corner);
  if (sheet.empty()) return {};
  sheet.layOut(0);
  cv::Mat count(sheet.size(), CV_16U, cv::Scalar(0)), mask(sheet.size(), CV_16U);
  for (const DenseView& view : views) {
    std::vector<cv::Point> corners;
    for (const Eigen::Vector2d& corner : footprint(view)) corners.push_back(sheet.at(corner));
    const cv::Rect box = cv::boundingRect(corners) & cv::Rect({}, sheet.size());
    mask(box).setTo(0);
    cv::fillConvexPoly(mask, corners, cv::Scalar(1));
    count(box) += mask(box);
  }
  cv::Mat picture(sheet.size(), CV_8UC3);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      picture.at<cv::Vec3b>(y, x) = coverageColour(count.at<std::uint16_t>(y, x));
  drawTracks(views, central_uav, sheet, picture);
  drawLegend(picture);
  return picture;
}

}  // namespace cf
