// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ground_survey.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/geodesy/crs.h"
#include "cf/geometry/similarity.h"
#include "judgement.h"
#include "moved_map.h"

namespace cf {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr std::size_t kFewest = 3;
/// Of points nearly on a line: what an error of one across it turns the map about it.
constexpr double kSlenderest = 0.1;
constexpr std::size_t kNamesSaid = 3;
/// Nobody marks worse than this, and the photos of a map agree far better: of a photo's width.
constexpr double kBadMark = 0.003;

Eigen::Vector3d middleOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// Whether they hold a map in all directions.
bool areSpread(const std::vector<Eigen::Vector3d>& points) {
  if (points.size() < kFewest) return false;
  const Eigen::Vector3d middle = middleOf(points);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) spread += (p - middle) * (p - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues()[1]) > kSlenderest * std::sqrt(solver.eigenvalues()[2]);
}

constexpr const char* kTooFew =
    "[gcp] use = control needs three ground points that are not almost on one line";

std::vector<Eigen::Vector3d> without(std::vector<Eigen::Vector3d> points, std::size_t i) {
  points.erase(points.begin() + static_cast<std::ptrdiff_t>(i));
  return points;
}

GroundPointRecord recordOf(const MarkedPoint& point, const MarkedPlace& place) {
  GroundPointRecord record;
  record.name = point.name;
  record.marks = static_cast<int>(point.sights.size());
  record.uavs = point.uavs();
  record.surveyed_m = point.surveyed;
  record.difference_m = place.position - point.surveyed;
  double squares = 0;
  for (const MarkedSight& sight : point.sights) {
    const double error = sight.errorOf(place.position).norm();
    squares += error * error;
    record.max_px = std::max(record.max_px, error);
  }
  record.rms_px = std::sqrt(squares / record.marks);
  return record;
}

/// About the worst mark of a point, if it cannot be right.
std::optional<std::string> badMark(const MarkedPoint& point, const MarkedPlace& place) {
  const auto worse = [&](const MarkedSight& a, const MarkedSight& b) {
    return a.errorOf(place.position).norm() < b.errorOf(place.position).norm();
  };
  const MarkedSight& worst = *std::max_element(point.sights.begin(), point.sights.end(), worse);
  const double error_px = worst.errorOf(place.position).norm();
  if (error_px < kBadMark * worst.camera.width) return std::nullopt;
  return fmt::format(
      "the marks of ground point {} disagree, worst in {} by {:.1f} px: look at them", point.name,
      worst.image, error_px);
}

double rmsLength(const std::vector<GroundPointRecord>& points) {
  double squares = 0;
  for (const GroundPointRecord& p : points) squares += p.difference_m.squaredNorm();
  return std::sqrt(squares / static_cast<double>(points.size()));
}

}  // namespace

void GcpOptions::visit(OptionVisitor& v) {
  v.path("file", file, "gcp_list.txt: the CRS, then lines x y z px py image [name]; empty: none");
  v.choice("use", use, {"check", "control"},
           "check: the report tells how far the map is from the points; control: the map is moved, "
           "turned and scaled as a whole onto them");
  v.text("size", size,
         "WIDTHxHEIGHT of the photos in which they were marked [px]; empty: as recorded");
}

/// The points that the photos see, with their places.
struct GroundSurvey::Placed {
  std::vector<Eigen::Vector3d> surveyed, mapped;
  std::vector<GroundPointRecord> records;
};

GroundSurvey::GroundSurvey(const std::filesystem::path& file, const GcpOptions& options)
    : list_(readGcpList(file)),
      places_(surveyedPlaces(list_)),
      datum_(crsFromText(list_.crs)->datum),
      control_(options.use == "control") {
  if (!options.size.empty()) {
    const ImageSize size = parseImageSize(options.size);
    size_ = PhotoSize{size.width, size.height};
  }
  if (!control_) return;
  const LocalFrame frame(places_.front());
  std::vector<Eigen::Vector3d> points;
  for (const Geodetic& place : places_) points.push_back(frame.toEnu(place));
  if (!areSpread(points)) throw UsageError(list_.file.string() + ": " + kTooFew);
}

void GroundSurvey::checkPhotos(const std::vector<UavInput>& inputs) const {
  MapPhotos photos;
  for (const UavInput& input : inputs)
    for (const auto& [photo, came_s, file] : input.photos())
      photos.emplace(photo.name,
                     MapPhoto{input.name(), Eigen::Isometry3d::Identity(), photo.camera});
  for (const MarkedPoint& point : joinMarks(list_, LocalFrame(places_.front()), photos, size_))
    if (!point.sights.empty()) return;
  throw UsageError(fmt::format("{}: none of its photos ({}, …) is one of this flight",
                               list_.file.string(), list_.points.front().marks.front().image));
}

MapPhotos GroundSurvey::photosOf(const Alignment& alignment, const RunRecord& record) const {
  MapPhotos photos;
  for (const auto& [id, entry] : alignment.table.poses) {
    const UavRecord& uav = record.uavs[id.uav];
    photos.emplace(uav.photos[id.index].name,
                   MapPhoto{uav.name, entry.T_world_cam, alignment.table.cameras[id.uav]});
  }
  return photos;
}

void GroundSurvey::warnOfUnknownPhotos(RunRecord& record) const {
  std::set<std::string> known;
  for (const UavRecord& uav : record.uavs)
    for (const PhotoRecord& photo : uav.photos) {
      known.insert(photo.name);
      known.insert(uav.name + "/" + photo.name);
    }
  std::set<std::string> unknown;
  for (const GroundControlPoint& point : list_.points)
    for (const GcpMark& mark : point.marks)
      if (known.count(mark.image) == 0) unknown.insert(mark.image);
  if (unknown.empty()) return;
  std::string names;
  for (auto it = unknown.begin(); it != unknown.end(); ++it) {
    const auto said = static_cast<std::size_t>(std::distance(unknown.begin(), it));
    if (said == kNamesSaid) {
      names += ", …";
      break;
    }
    names += (said > 0 ? ", " : "") + *it;
  }
  warn(record, fmt::format("{}: {} of its photos are not of this flight ({}): their marks are left "
                           "out",
                           list_.file.string(), unknown.size(), names));
}

GroundSurvey::Placed GroundSurvey::place(const World& world, const Alignment& alignment,
                                         RunRecord& record) const {
  // A relative map's photos are joined before anything is known of where they are.
  const LocalFrame frame = world.frame ? *world.frame : LocalFrame(places_.front());
  Placed placed;
  for (const MarkedPoint& point : joinMarks(list_, frame, photosOf(alignment, record), size_)) {
    const Result<MarkedPlace> place = placeOf(point.sights);
    if (!place) {
      const std::string why =
          point.sights.size() < 2
              ? fmt::format("marked in {} photo{} with a pose, two are needed", point.sights.size(),
                            point.sights.size() == 1 ? "" : "s")
              : place.failure().detail;
      record.ground_control->missing[point.name] = why;
      warn(record, fmt::format("{}: ground point {} is left out: {}", list_.file.string(),
                               point.name, why));
      continue;
    }
    if (const auto bad = badMark(point, *place)) warn(record, list_.file.string() + ": " + *bad);
    placed.surveyed.push_back(point.surveyed);
    placed.mapped.push_back(place->position);
    placed.records.push_back(recordOf(point, *place));
  }
  return placed;
}

void GroundSurvey::apply(World& world, Alignment& alignment, RunRecord& record) const {
  if (!world.frame && !control_)
    return warn(record, list_.file.string() +
                            ": the map is relative and cannot be held against ground points; "
                            "[gcp] use = control gives it its place");
  warnOfUnknownPhotos(record);
  record.ground_control.emplace().file = list_.file.filename().string();
  Placed placed = place(world, alignment, record);
  if (control_) {
    const auto S = alignPoints(placed.surveyed, placed.mapped, AlignmentModel::kSim3);
    if (!S || !areSpread(placed.surveyed))
      throw RunError(fmt::format("{}: {} of {} ground points could be triangulated: {}",
                                 list_.file.string(), placed.surveyed.size(), list_.points.size(),
                                 kTooFew));
    for (std::size_t i = 0; i < placed.records.size(); ++i) {
      GroundPointRecord& point = placed.records[i];
      point.difference_m = *S * placed.mapped[i] - placed.surveyed[i];
      const auto others = without(placed.surveyed, i);
      if (!areSpread(others)) continue;
      if (const auto S_others =
              alignPoints(others, without(placed.mapped, i), AlignmentModel::kSim3))
        point.left_out_m = *S_others * placed.mapped[i] - placed.surveyed[i];
    }
    record.ground_control->moved =
        MapMotion{middleOf(placed.surveyed) - middleOf(placed.mapped),
                  kDegrees * Eigen::AngleAxisd(S->rotation).angle(), S->scale};
    moveMap(*S, alignment);
    alignment.relative = false;
    if (!world.frame) world.frame.emplace(places_.front());
    world.setFrame(*world.frame, datum_);
  }
  record.ground_control->points = std::move(placed.records);
  if (const auto& points = record.ground_control->points; !points.empty())
    logInfo(fmt::format("ground {} points: {} of {}, {:.3f} m from the map (RMS)",
                        control_ ? "control" : "check", points.size(), list_.points.size(),
                        rmsLength(points)));
}

}  // namespace cf
