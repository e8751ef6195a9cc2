// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/tum.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"

namespace cf {
namespace {

TimedPose poseFromLine(const std::string& line) {
  std::istringstream in(line);
  std::string t, rest;
  double v[7];
  in >> t;
  for (double& x : v) in >> x;
  if (!in || (in >> rest)) throw RunError("'t tx ty tz qx qy qz qw' was expected");
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(q.norm() > 0.5 && q.norm() < 2)) throw RunError("the quaternion is not of unit length");
  TimedPose pose;
  pose.time = timeFromText(t);
  pose.T_world_cam.linear() = q.normalized().toRotationMatrix();
  pose.T_world_cam.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

}  // namespace

std::vector<TimedPose> readTum(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in || std::filesystem::is_directory(path))
    throw RunError(path.string() + ": cannot be read");
  std::vector<TimedPose> poses;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    try {
      poses.push_back(poseFromLine(line));
    } catch (const RunError& e) {
      throw RunError(fmt::format("{}: line {}: {}", path.string(), number, e.what()));
    }
  }
  return poses;
}

void writeTum(const std::filesystem::path& path, const std::vector<TimedPose>& poses) {
  AtomicFile file(path);
  for (const TimedPose& pose : poses) {
    const Eigen::Vector3d t = pose.T_world_cam.translation();
    Eigen::Quaterniond q(pose.T_world_cam.linear());
    if (q.w() < 0) q.coeffs() *= -1;
    file.write(fmt::format("{} {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                           timeText(pose.time), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()));
  }
  file.commit();
}

}  // namespace cf
