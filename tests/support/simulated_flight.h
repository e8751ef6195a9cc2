// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "cf/types/keyframe.h"
#include "cf/types/sim3.h"
#include "support/views.h"

namespace cf::support {

/// Hills of several wavelengths, heights within about relief_m of 0.
struct Terrain {
  double relief_m = 8;

  double height(double x, double y) const {
    return relief_m * (0.5 * std::sin(x / 31 + 1.3) * std::cos(y / 27 - 0.4) +
                       0.3 * std::sin(x / 13 - y / 17) + 0.2 * std::cos(x / 7 + y / 9 + 2));
  }
};

/// Parallel lines flown to and fro.
struct LawnMower {
  Eigen::Vector2d start_m{0, 0};
  double heading_deg = 0;  ///< of the first line, counter-clockwise from east
  int lines = 3, per_line = 8;
  double step_m = 14, spacing_m = 30, height_m = 70;
  /// Photo number at which each odometry segment but the first begins; a segment of one photo is a
  /// photo that could not be tracked.
  std::vector<int> cuts;
  Eigen::Vector3d gnss_bias_m{0, 0, 0};
  double gnss_sigma_m = 0.5;
  bool georeferenced = true;
};

struct SimulationOptions {
  Terrain terrain;
  double point_spacing_m = 2.6;
  double detected = 0.75;         ///< chance that a visible point is a feature
  double pixel_sigma = 0.5;       ///< at the feature size [px]
  double pixel_size = 3.5;        ///< pixels of the photo per pixel searched
  double descriptor_sigma = 5;    ///< per component
  double wrong_features = 0.1;    ///< that look like another ground point
  double attitude_sigma_deg = 2;  ///< of the camera about nadir
  double depth_sigma = 0.005;     ///< of the odometry's depths, relative
  double georeference_sigma_m = 0.3;
  /// Lens that takes the photos, and the one that everybody is told.
  CameraModel true_camera, given_camera;

  SimulationOptions() {
    true_camera.width = 4000;
    true_camera.height = 3000;
    true_camera.fx = true_camera.fy = 3000;
    true_camera.cx = 1999.5;
    true_camera.cy = 1499.5;
    given_camera = true_camera;
  }
};

/// What the stages before align hand on, made without images, and the truth behind it.
struct Simulation {
  std::vector<GeoKeyframe> keyframes;
  std::vector<GeoSegment> segments;
  std::vector<GnssQuality> quality;                  ///< by UAV
  std::vector<CameraModel> cameras;                  ///< by UAV, as given
  std::map<FrameId, Eigen::Isometry3d> T_world_cam;  ///< truth
  std::map<SegmentId, double> metres_per_unit;       ///< truth
  std::map<FrameId, std::vector<int>> ground_point;  ///< per feature; -1 = shows another one
  std::vector<Eigen::Vector3d> points;               ///< the ground points

  const Keyframe& photo(FrameId id) const {
    for (const GeoKeyframe& k : keyframes)
      if (k.keyframe->id == id) return *k.keyframe;
    throw std::out_of_range("no such photo");
  }
};

/// Descriptor of a ground point, RootSIFT's length, from its number alone.
inline std::array<double, FeatureSet::kDescriptorSize> descriptorOf(int point) {
  std::mt19937 random(static_cast<unsigned>(point) * 2654435761U + 17);
  std::array<double, FeatureSet::kDescriptorSize> d;
  double sum = 0;
  for (double& value : d) {
    value = std::exponential_distribution<double>(1)(random);
    sum += value;
  }
  for (double& value : d) value = 512 * std::sqrt(value / sum);
  return d;
}

class FlightSimulator {
 public:
  FlightSimulator(const SimulationOptions& options, unsigned seed)
      : options_(options), random_(seed) {}

  Simulation fly(const std::vector<LawnMower>& uavs) {
    for (std::size_t u = 0; u < uavs.size(); ++u)
      placeCameras(static_cast<std::uint16_t>(u), uavs[u]);
    placePoints();
    for (std::size_t u = 0; u < uavs.size(); ++u) record(static_cast<std::uint16_t>(u), uavs[u]);
    return std::move(out_);
  }

 private:
  double normal(double sigma) { return sigma * std::normal_distribution<double>()(random_); }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Eigen::Vector3d normal3(double sigma) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return {x, y, z};
  }

  void placeCameras(std::uint16_t uav, const LawnMower& plan) {
    const Eigen::Rotation2Dd heading(plan.heading_deg * kDegree);
    for (int line = 0; line < plan.lines; ++line)
      for (int k = 0; k < plan.per_line; ++k) {
        const bool back = line % 2 == 1;
        const double along = plan.step_m * (back ? plan.per_line - 1 - k : k);
        const Eigen::Vector2d p =
            plan.start_m + heading * Eigen::Vector2d(along, plan.spacing_m * line);
        const FrameId id{uav, static_cast<std::uint32_t>(line * plan.per_line + k)};
        // The photo's top points where the UAV flies.
        const double yaw = plan.heading_deg - 90 + (back ? 180 : 0) + normal(3);
        const double pitch = normal(options_.attitude_sigma_deg);
        const double roll = normal(options_.attitude_sigma_deg);
        const Eigen::Vector3d centre(p.x(), p.y(), plan.height_m);
        out_.T_world_cam[id] = nadirPose(centre + normal3(0.5), yaw, pitch, roll);
      }
  }

  /// A jittered grid over all that the photos see.
  void placePoints() {
    Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
    for (const auto& [id, T] : out_.T_world_cam) {
      const double reach = 1.1 * T.translation().z();
      low =
          low.cwiseMin(Eigen::Vector2d(T.translation().head<2>() - Eigen::Vector2d(reach, reach)));
      high =
          high.cwiseMax(Eigen::Vector2d(T.translation().head<2>() + Eigen::Vector2d(reach, reach)));
    }
    const double s = options_.point_spacing_m;
    for (double x = low.x(); x < high.x(); x += s)
      for (double y = low.y(); y < high.y(); y += s) {
        const double px = x + uniform(-0.4, 0.4) * s, py = y + uniform(-0.4, 0.4) * s;
        out_.points.emplace_back(px, py, options_.terrain.height(px, py));
      }
  }

  void record(std::uint16_t uav, const LawnMower& plan) {
    const int photos = plan.lines * plan.per_line;
    std::vector<int> begins{0};
    begins.insert(begins.end(), plan.cuts.begin(), plan.cuts.end());
    for (std::size_t s = 0; s < begins.size(); ++s) {
      const int end = s + 1 < begins.size() ? begins[s + 1] : photos;
      recordSegment(uav, plan, static_cast<int>(s), begins[s], end);
    }
    out_.cameras.push_back(options_.given_camera);
    GnssQuality quality;
    quality.sigma_m = Eigen::Vector3d::Constant(plan.gnss_sigma_m);
    quality.fixes = photos;
    quality.trusted = true;
    out_.quality.push_back(quality);
  }

  void recordSegment(std::uint16_t uav, const LawnMower& plan, int number, int begin, int end) {
    // A frame as odometry could have chosen it: any rotation, unit and origin.
    const double scale = std::exp(uniform(-1, 3));
    Sim3 S_local_world;
    S_local_world.scale = 1 / scale;
    const double angle = uniform(-M_PI, M_PI);
    S_local_world.rotation = Eigen::AngleAxisd(angle, normal3(1).normalized()).toRotationMatrix();
    S_local_world.translation = normal3(5);

    GeoSegment segment;
    segment.id = {uav, number};
    const bool alone = end - begin == 1;
    segment.georeferenced = plan.georeferenced && !alone;
    segment.scale = segment.georeferenced ? scale : 1;
    segment.scale_sigma = 0.01 * scale;
    out_.metres_per_unit[segment.id] = scale;
    const Eigen::Vector3d error = plan.gnss_bias_m + normal3(options_.georeference_sigma_m);
    for (int i = begin; i < end; ++i) {
      const FrameId id{uav, static_cast<std::uint32_t>(i)};
      const Eigen::Isometry3d& truth = out_.T_world_cam.at(id);
      auto keyframe = std::make_shared<Keyframe>();
      keyframe->id = id;
      keyframe->time = 1000 * kNsPerSecond + i * 2 * kNsPerSecond;
      keyframe->name = "photo_" + std::to_string(i) + ".jpg";
      keyframe->segment = number;
      keyframe->camera = options_.given_camera;
      if (!alone) keyframe->T_local_cam = S_local_world.carry(truth);
      addFeatures(*keyframe, truth, alone ? 0 : scale);
      GnssPosition fix;
      fix.position_m = truth.translation() + plan.gnss_bias_m + normal3(plan.gnss_sigma_m);
      fix.sigma_m = Eigen::Vector3d::Constant(plan.gnss_sigma_m);

      GeoSegment::Pose pose;
      pose.frame = id;
      pose.T_world_cam = keyframe->T_local_cam;
      if (segment.georeferenced) {
        pose.T_world_cam = truth;
        pose.T_world_cam.translation() += error;
        pose.covariance.diagonal() << 0.25, 0.25, 0.25, 1e-4, 1e-4, 1e-4;
      }
      segment.poses.push_back(pose);
      GeoKeyframe geo;
      geo.keyframe = keyframe;
      if (plan.georeferenced) geo.fix = fix;
      out_.keyframes.push_back(geo);
    }
    out_.segments.push_back(segment);
  }

  /// `scale` in metres per VO unit; 0 = nothing is triangulated.
  void addFeatures(Keyframe& keyframe, const Eigen::Isometry3d& T_world_cam, double scale) {
    const CameraModel& camera = options_.true_camera;
    auto features = std::make_shared<FeatureSet>();
    features->pixel_size = options_.pixel_size;
    std::vector<int>& shown = out_.ground_point[keyframe.id];
    const Eigen::Isometry3d T_cam_world = T_world_cam.inverse();
    const auto points = static_cast<int>(out_.points.size());
    for (int i = 0; i < points; ++i) {
      const Eigen::Vector3d p = T_cam_world * out_.points[static_cast<std::size_t>(i)];
      if (p.z() <= 0 || std::abs(p.x()) > p.z() || std::abs(p.y()) > p.z()) continue;
      const Eigen::Vector2d pixel = camera.project(p);
      if (!camera.contains(pixel) || uniform(0, 1) > options_.detected) continue;
      const double sigma = options_.pixel_sigma * options_.pixel_size;
      const double du = normal(sigma), dv = normal(sigma);
      features->pixel.emplace_back(static_cast<float>(pixel.x() + du),
                                   static_cast<float>(pixel.y() + dv));
      features->scale_px.push_back(static_cast<float>(5 * options_.pixel_size));
      features->colour.insert(features->colour.end(), {10, 120, 60});
      const bool wrong = uniform(0, 1) < options_.wrong_features;
      const int looks_like = wrong ? static_cast<int>(uniform(0, points)) : i;
      for (const double value : descriptorOf(looks_like))
        features->descriptor.push_back(static_cast<std::uint8_t>(
            std::min(255.0, std::max(0.0, std::round(value + normal(options_.descriptor_sigma))))));
      shown.push_back(wrong ? -1 : i);
      // A focal length believed too long puts everything further away by as much.
      const double believed = options_.given_camera.fx / camera.fx;
      const double depth = p.z() * believed * (1 + normal(options_.depth_sigma));
      keyframe.inverse_depth.push_back(scale > 0 ? static_cast<float>(scale / depth) : 0.0f);
    }
    keyframe.features = features;
  }

  SimulationOptions options_;
  std::mt19937 random_;
  Simulation out_;
};

}  // namespace cf::support
