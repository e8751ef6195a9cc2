// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "cf/base/log.h"
#include "cf/deliver/hand_over.h"
#include "cf/formats/atomic_file.h"
#include "out_path.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "colmap";
/// COLMAP counts pixels from the photo's corner, CameraModel from the first pixel's centre.
const Eigen::Vector2d kCorner(0.5, 0.5);

template <class... Values>
void append(std::string& text, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
}

/// Photos and points numbered as COLMAP does: photos and cameras from 1, a photo's sights from 0.
class ColmapModel {
 public:
  explicit ColmapModel(const RunRecord& run) : run_(run) {
    for (std::size_t u = 0; u < run.uavs.size(); ++u)
      for (const PhotoPose& pose : run.uavs[u].final_trajectory)
        images_[{static_cast<std::uint16_t>(u), pose.photo}].T_cam_world =
            pose.T_world_cam.inverse();
    int number = 0;
    for (auto& [id, image] : images_) image.number = ++number;
    addPoints();
  }

  std::string cameras() const {
    std::string text =
        "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n# A camera for each UAV, in order.\n";
    for (std::size_t u = 0; u < run_.uavs.size(); ++u) {
      const CameraModel& c = run_.uavs[u].camera_after;
      append(text,
             "{} {} {} {} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g}{}\n",
             u + 1, c.k3 == 0 ? "OPENCV" : "FULL_OPENCV", c.width, c.height, c.fx, c.fy,
             c.cx + kCorner.x(), c.cy + kCorner.y(), c.k1, c.k2, c.p1, c.p2,
             c.k3 == 0 ? "" : fmt::format(" {:.12g} 0 0 0", c.k3));
    }
    return text;
  }

  std::string images() const {
    std::string text =
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# X, Y, POINT3D_ID …\n";
    for (const auto& [id, image] : images_) {
      const Eigen::Quaterniond q(image.T_cam_world.linear());
      const Eigen::Vector3d t = image.T_cam_world.translation();
      append(text, "{} {:.12g} {:.12g} {:.12g} {:.12g} {:.6f} {:.6f} {:.6f} {} {}/{}\n",
             image.number, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), id.uav + 1,
             uavOf(run_, id).name, photoOf(run_, id).name);
      const char* between = "";
      for (const Sight& sight : image.sights) {
        append(text, "{}{:.3f} {:.3f} {}", between, sight.pixel.x(), sight.pixel.y(), sight.point);
        between = " ";
      }
      text += '\n';
    }
    return text;
  }

  std::string points() const {
    std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR [px], (IMAGE_ID, POINT2D_IDX) …\n";
    for (const Point& point : points_) {
      const SparsePoint& p = *point.sparse;
      append(text, "{} {:.5f} {:.5f} {:.5f} {} {} {} {:.4f}", point.number, p.position_m.x(),
             p.position_m.y(), p.position_m.z(), p.bgr[2], p.bgr[1], p.bgr[0], point.error_px);
      for (const auto& [image, sight] : point.track) append(text, " {} {}", image, sight);
      text += '\n';
    }
    return text;
  }

 private:
  struct Sight {
    Eigen::Vector2d pixel;  ///< from the corner
    std::size_t point;
  };
  struct Image {
    int number = 0;
    Eigen::Isometry3d T_cam_world = Eigen::Isometry3d::Identity();
    std::vector<Sight> sights;
  };
  struct Point {
    std::size_t number;
    const SparsePoint* sparse;
    double error_px;                                 ///< mean distance
    std::vector<std::pair<int, std::size_t>> track;  ///< number of the image, place in its sights
  };

  void addPoints() {
    auto pixel = run_.sparse_pixels.begin();
    for (const SparsePoint& p : run_.sparse_points) {
      if (run_.sparse_pixels.end() - pixel < static_cast<long>(p.observations.size())) return;
      Point point{points_.size() + 1, &p, 0, {}};
      for (const SparseObservation& o : p.observations) {
        const Eigen::Vector2d seen = (pixel++)->cast<double>();
        const auto found = images_.find(o.frame);
        if (found == images_.end()) continue;
        Image& image = found->second;
        const CameraModel& camera = uavOf(run_, o.frame).camera_after;
        point.error_px += (camera.project(image.T_cam_world * p.position_m) - seen).norm();
        point.track.emplace_back(image.number, image.sights.size());
        image.sights.push_back({seen + kCorner, point.number});
      }
      if (point.track.empty()) continue;
      point.error_px /= static_cast<double>(point.track.size());
      points_.push_back(std::move(point));
    }
  }

  const RunRecord& run_;
  std::map<FrameId, Image> images_;
  std::vector<Point> points_;
};

std::string originText(const WorldRecord& world) {
  if (world.relative)
    return "# The model is relative: its place, heading and scale are arbitrary.\n";
  return fmt::format(
      "# The model's x, y, z are east, north, up [m] at this place on WGS84.\n"
      "latitude_deg = {:.10f}\nlongitude_deg = {:.10f}\nheight_m = {:.4f}\n"
      "height_datum = {}\nutm_zone = {}\n",
      world.latitude_deg, world.longitude_deg, world.height_m, name(world.h_datum), world.utm);
}

void linkPhotos(const RunRecord& run, const fs::path& images) {
  for (const UavRecord& uav : run.uavs) {
    std::error_code error;
    if (uav.photo_folder.empty() || !fs::is_directory(uav.photo_folder, error)) continue;
    const fs::path link = images / uav.name;
    fs::create_directories(images, error);
    if (fs::is_symlink(link)) fs::remove(link, error);
    fs::create_directory_symlink(fs::absolute(uav.photo_folder), link, error);
    if (error)
      logWarning(fmt::format("{}: cannot be made a link to {}: {}", link.string(),
                             uav.photo_folder.string(), error.message()));
  }
}

}  // namespace

void writeColmapModel(const RunRecord& run, const fs::path& outdir) {
  const ColmapModel model(run);
  writeFileAtomically(outPath(outdir, kFolder, "cameras.txt"), model.cameras());
  writeFileAtomically(outPath(outdir, kFolder, "images.txt"), model.images());
  writeFileAtomically(outPath(outdir, kFolder, "points3D.txt"), model.points());
  writeFileAtomically(outPath(outdir, kFolder, "origin.txt"), originText(run.world));
  linkPhotos(run, outdir / kFolder / "images");
}

}  // namespace cf
