// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include "cf/deliver/deliver.h"
#include "cf/deliver/hand_over.h"
#include "cf/formats/atomic_file.h"
#include "escape.h"
#include "geographic.h"
#include "out_path.h"
#include "outline.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

std::string coordinates(const LocalFrame& frame, const Eigen::Vector3d& p_world) {
  const auto [longitude, latitude, height] = lonLatHeight(frame, p_world);
  return fmt::format("{:.9f},{:.9f},{:.3f}\n", longitude, latitude, height);
}

std::string track(const UavRecord& uav, const RunRecord& run, const LocalFrame& frame) {
  // aabbggrr; the central UAV is white as in the pictures.
  const char* colour = uav.name == run.world.center ? "ffffffff" : "ff00d6ff";
  std::string kml = fmt::format(
      "<Placemark>\n<name>{}</name>\n<Style><LineStyle><color>{}</color><width>3</width>"
      "</LineStyle></Style>\n<LineString><altitudeMode>absolute</altitudeMode>\n<coordinates>\n",
      markupEscaped(uav.name), colour);
  for (const PhotoPose& pose : uav.final_trajectory)
    kml += coordinates(frame, pose.T_world_cam.translation());
  return kml + "</coordinates></LineString>\n</Placemark>\n";
}

std::string photoPoint(const UavRecord& uav, const PhotoPose& pose, const LocalFrame& frame) {
  const PhotoRecord& photo = photoOf(uav, pose.photo);
  return fmt::format(
      "<Placemark>\n<name>{}</name>\n<TimeStamp><when>{}</when></TimeStamp>\n"
      "<styleUrl>#photo</styleUrl>\n<Point><altitudeMode>absolute</altitudeMode><coordinates>\n"
      "{}</coordinates></Point>\n</Placemark>\n",
      markupEscaped(photo.name), isoText(photo.time),
      coordinates(frame, pose.T_world_cam.translation()));
}

std::string outline(const RunRecord& run, const LocalFrame& frame) {
  const std::vector<Eigen::Vector3d> corners = outlineOf(run);
  if (corners.empty()) return {};
  std::string kml =
      "<Placemark>\n<name>outline of the map</name>\n<styleUrl>#outline</styleUrl>\n<Polygon>"
      "<tessellate>1</tessellate><outerBoundaryIs><LinearRing><coordinates>\n";
  for (const Eigen::Vector3d& corner : corners) kml += coordinates(frame, corner);
  kml += coordinates(frame, corners.front());
  return kml + "</coordinates></LinearRing></outerBoundaryIs></Polygon>\n</Placemark>\n";
}

void writeDocument(const fs::path& file, const std::string& title, const std::string& body) {
  writeFileAtomically(file,
                      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                      "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>" +
                          title + "</name>\n" + body + "</Document>\n</kml>\n");
}

}  // namespace

void writeKml(const RunRecord& run, const fs::path& outdir) {
  if (run.world.relative) return;
  const LocalFrame frame = frameOf(run.world);
  std::string tracks;
  for (const UavRecord& uav : run.uavs)
    if (!uav.final_trajectory.empty()) tracks += track(uav, run, frame);
  writeDocument(outPath(outdir, "trajectories", "all.kml"), "Trajectories", tracks);
}

void writeMapKml(const RunRecord& run, const fs::path& outdir) {
  if (run.world.relative) return;
  const LocalFrame frame = frameOf(run.world);
  std::string kml =
      "<Style id=\"photo\"><IconStyle><scale>0.4</scale></IconStyle>"
      "<LabelStyle><scale>0</scale></LabelStyle></Style>\n"
      "<Style id=\"outline\"><LineStyle><color>ff00ffff</color><width>2</width></LineStyle>"
      "<PolyStyle><fill>0</fill></PolyStyle></Style>\n" +
      outline(run, frame);
  for (const UavRecord& uav : run.uavs) {
    if (uav.final_trajectory.empty()) continue;
    kml += "<Folder>\n<name>" + markupEscaped(uav.name) + "</name>\n" + track(uav, run, frame);
    for (const PhotoPose& pose : uav.final_trajectory) kml += photoPoint(uav, pose, frame);
    kml += "</Folder>\n";
  }
  writeDocument(outPath(outdir, "", "map.kml"), "ClusterFusion map", kml);
}

}  // namespace cf
