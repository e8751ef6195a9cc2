// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "run_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/config/config.h"
#include "cf/formats/camera_ini.h"
#include "cf/formats/csv.h"
#include "cf/formats/tum.h"
#include "estimated_poses.h"
#include "pose_consistency.h"
#include "world_origin.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double numberIn(const fs::path& file, const std::string& text) {
  const auto value = numberFrom(text);
  if (!value) throw RunError(file.string() + ": '" + text + "' should be a number");
  return *value;
}

/// The photos by UAV: line k of images.tsv is line k of poses.tum.
std::vector<RunUav> readTruth(const fs::path& truth_dir) {
  const fs::path list = truth_dir / "images.tsv";
  const std::vector<CsvRow> rows = readCsvRows(list, '\t');
  const std::vector<TimedPose> poses = readTum(truth_dir / "poses.tum");
  if (rows.size() != poses.size() || rows.empty())
    throw RunError(
        fmt::format("{}: has {} photos, poses.tum {} poses; line k of both must be the "
                    "same photo",
                    list.string(), rows.size(), poses.size()));
  std::map<std::string, RunUav> uavs;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const fs::path photo = rows[k].front();
    const std::string uav = photo.parent_path().string();
    if (uav.empty())
      throw RunError(list.string() + ": '" + photo.string() + "' should be <uav>/<photo>");
    RunPhoto entry;
    entry.name = photo.filename().string();
    entry.time = poses[k].time;
    entry.truth = poses[k].T_world_cam;
    uavs[uav].name = uav;
    uavs[uav].photos.push_back(entry);
  }
  std::vector<RunUav> out;
  for (auto& [name, uav] : uavs) out.push_back(std::move(uav));
  return out;
}

/// The pose of the nearest time in a TUM file, which must be within a millisecond.
std::optional<Eigen::Isometry3d> poseAt(const std::map<TimeNs, Eigen::Isometry3d>& poses,
                                        TimeNs time) {
  constexpr TimeNs kSame = kNsPerSecond / 1000;
  const auto next = poses.lower_bound(time - kSame);
  if (next == poses.end() || next->first > time + kSame) return std::nullopt;
  return next->second;
}

std::map<TimeNs, Eigen::Isometry3d> posesOf(const fs::path& tum) {
  std::map<TimeNs, Eigen::Isometry3d> poses;
  if (fs::exists(tum))
    for (const TimedPose& pose : readTum(tum)) poses.emplace(pose.time, pose.T_world_cam);
  return poses;
}

RunPhoto* findPhoto(RunUav& uav, const std::string& name, TimeNs time) {
  RunPhoto* found = nullptr;
  for (RunPhoto& photo : uav.photos) {
    if (photo.name != name) continue;
    if (found == nullptr || std::abs(photo.time - time) < std::abs(found->time - time))
      found = &photo;
  }
  return found;
}

void joinPoses(const RunInputs& run, RunUav& uav) {
  const fs::path csv = run.out_dir / "images" / (uav.name + ".csv");
  const CsvTable table(csv);
  const std::size_t image = table.column("image"), t = table.column("t"),
                    status = table.column("status"), segment = table.column("segment");
  const fs::path tum = run.out_dir / "trajectories" / (uav.name + ".tum");
  const PoseCovariances covariances = readCovariances(tum);
  const auto poses = posesOf(tum), local = posesOf(run.out_dir / "odometry" / tum.filename());
  for (const CsvRow& row : table.rows()) {
    const TimeNs time = timeFromText(row[t]);
    RunPhoto* photo = findPhoto(uav, row[image], time);
    if (photo == nullptr) continue;
    if (!row[segment].empty()) photo->segment = static_cast<int>(numberIn(csv, row[segment]));
    photo->local = poseAt(local, time);
    if (row[status] != "posed") continue;
    const auto pose = poseAt(poses, time);
    if (!pose)
      throw RunError(fmt::format("{}: has no row for {} at t = {}, which {} calls posed",
                                 tum.string(), row[image], row[t], csv.string()));
    photo->estimate = run.T_ref_est * *pose;
    const auto covariance = covariances.find({row[image], time});
    if (covariance == covariances.end()) continue;
    photo->component = covariance->second.first;
    photo->covariance = turned(covariance->second.second, run.T_ref_est.linear());
  }
}

std::vector<ScaleEstimate> readScale(const fs::path& file) {
  std::vector<ScaleEstimate> rows;
  if (!fs::exists(file)) return rows;
  const CsvTable table(file);
  const std::size_t t = table.column("t"), segment = table.column("segment"),
                    scale = table.column("scale"), sigma = table.column("sigma");
  for (const CsvRow& row : table.rows())
    rows.push_back({timeFromText(row[t]), static_cast<int>(numberIn(file, row[segment])),
                    numberIn(file, row[scale]), numberIn(file, row[sigma])});
  return rows;
}

std::vector<TrueFix> readFixes(const fs::path& file) {
  std::vector<TrueFix> fixes;
  if (!fs::exists(file)) return fixes;
  const CsvTable table(file);
  const std::size_t t = table.column("t"), e = table.column("true_e"), n = table.column("true_n"),
                    u = table.column("true_u"), outlier = table.column("outlier");
  for (const CsvRow& row : table.rows())
    if (row[outlier] == "0")
      fixes.push_back({timeFromText(row[t]),
                       {numberIn(file, row[e]), numberIn(file, row[n]), numberIn(file, row[u])}});
  return fixes;
}

std::optional<CameraModel> readCamera(const fs::path& file, const std::string& section) {
  if (!fs::exists(file)) return std::nullopt;
  try {
    return readCameraIni(file, section);
  } catch (const UsageError& e) {
    throw RunError(e.what());
  }
}

json readJson(const fs::path& file) {
  if (!fs::exists(file)) return json::object();
  std::ifstream in(file);
  json parsed = json::parse(in, nullptr, false);
  if (!parsed.is_object()) throw RunError(file.string() + ": is not JSON");
  return parsed;
}

std::optional<Eigen::Vector3d> tripleAt(const json& object, const char* key) {
  if (!object.contains(key) || !object[key].is_array() || object[key].size() != 3)
    return std::nullopt;
  Eigen::Vector3d v;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!object[key][i].is_number()) return std::nullopt;
    v[static_cast<Eigen::Index>(i)] = object[key][i].get<double>();
  }
  return v;
}

std::optional<GnssFigures> gnssOf(const json& object, const char* sigma, const char* bias) {
  const auto s = tripleAt(object, sigma), b = tripleAt(object, bias);
  if (!s || !b) return std::nullopt;
  const bool counted = object.contains("gnss_fixes") && object["gnss_fixes"].is_number_integer();
  return GnssFigures{*s, *b, counted ? object["gnss_fixes"].get<int>() : 0};
}

std::vector<RunRelativePose> readRelativePoses(const fs::path& file, std::vector<RunUav>& uavs) {
  std::vector<RunRelativePose> poses;
  if (!fs::exists(file)) return poses;
  const CsvTable table(file);
  const auto photoOf = [&](const CsvRow& row, const char* uav_key,
                           const char* image_key) -> const RunPhoto* {
    const std::string& name = row[table.column(uav_key)];
    const auto uav = std::find_if(uavs.begin(), uavs.end(),
                                  [&](const RunUav& candidate) { return candidate.name == name; });
    return uav == uavs.end() ? nullptr : findPhoto(*uav, row[table.column(image_key)], 0);
  };
  const auto value = [&](const CsvRow& row, const char* key) {
    return numberIn(file, row[table.column(key)]);
  };
  for (const CsvRow& row : table.rows()) {
    const RunPhoto* a = photoOf(row, "uav_a", "image_a");
    const RunPhoto* b = photoOf(row, "uav_b", "image_b");
    if (a == nullptr || b == nullptr) continue;
    RunRelativePose pose;
    pose.truth = a->truth.inverse() * b->truth;
    pose.estimate.translation() << value(row, "tx"), value(row, "ty"), value(row, "tz");
    pose.estimate.linear() =
        Eigen::Quaterniond(value(row, "qw"), value(row, "qx"), value(row, "qy"), value(row, "qz"))
            .normalized()
            .toRotationMatrix();
    int i = 0;
    for (const char* key : {"sigma_tx", "sigma_ty", "sigma_tz", "sigma_rx", "sigma_ry", "sigma_rz"})
      pose.sigma[i++] = value(row, key);
    poses.push_back(pose);
  }
  return poses;
}

struct MatchedSize {
  double megapixels = 0;
  void visit(OptionVisitor& v) { v.number("megapixels", megapixels, {}, "as in [densify]"); }
};

std::optional<double> readMatchedMegapixels(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  MatchedSize size;
  try {
    Config::fromFile(file).load("densify", size);
  } catch (const UsageError& e) {
    throw RunError(e.what());
  }
  if (!(size.megapixels > 0)) return std::nullopt;
  return size.megapixels;
}

}  // namespace

RunInputs readRun(const fs::path& out_dir, const fs::path& truth_dir) {
  RunInputs run;
  run.out_dir = out_dir;
  run.truth_dir = truth_dir;
  run.T_ref_est =
      transformBetweenWorlds(out_dir, truth_dir).value_or(Eigen::Isometry3d::Identity());
  run.uavs = readTruth(truth_dir);
  const json report = readJson(out_dir / "report.json"), gnss = readJson(truth_dir / "gnss.json");
  bool any = false;
  for (RunUav& uav : run.uavs) {
    uav.camera_true = readCamera(truth_dir / "cameras" / (uav.name + ".ini"), "camera");
    uav.fixes = readFixes(truth_dir / "gnss" / (uav.name + ".csv"));
    if (gnss.contains(uav.name)) uav.gnss_true = gnssOf(gnss[uav.name], "sigma_m", "bias_m");
    if (!fs::exists(out_dir / "images" / (uav.name + ".csv"))) continue;
    any = true;
    joinPoses(run, uav);
    const fs::path camera = out_dir / "cameras" / (uav.name + ".ini");
    uav.camera_after = readCamera(camera, "camera");
    uav.camera_before = readCamera(camera, "before");
    uav.scale = readScale(out_dir / "scale" / (uav.name + ".csv"));
    if (report.contains("uavs") && report["uavs"].contains(uav.name))
      uav.gnss_estimated = gnssOf(report["uavs"][uav.name], "gnss_sigma_m", "gnss_bias_m");
  }
  if (!any)
    throw RunError(
        fmt::format("{}: has no images/<uav>.csv for a UAV of {}: give the output folder "
                    "of a run of that flight",
                    out_dir.string(), (truth_dir / "images.tsv").string()));
  run.relative_poses = readRelativePoses(out_dir / "relative_poses.csv", run.uavs);
  run.matched_megapixels = readMatchedMegapixels(out_dir / "config.effective.ini");
  return run;
}

}  // namespace cf
