// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include "cf/base/error.h"
#include "cf/formats/camera_ini.h"
#include "cf/rawlog/rawlog_writer.h"
#include "flight.h"
#include "photo_files.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

void describeFixes(const Flight& flight, ImportedUav& uav) {
  std::map<HeightDatum, int> datums;
  std::vector<double> axes[3];
  for (const ImportedPhoto& photo : flight.photos) {
    if (!photo.fix) continue;
    ++uav.fixes;
    ++datums[photo.fix->datum];
    for (int a = 0; a < 3; ++a) axes[a].push_back(photo.fix->sigma_enu_m[a]);
  }
  int most = 0;
  for (const auto& [datum, count] : datums)
    if (count > most) {
      most = count;
      uav.datum = datum;
    }
  for (int a = 0; a < 3; ++a) {
    if (axes[a].empty()) continue;
    const auto middle = axes[a].begin() + static_cast<std::ptrdiff_t>(axes[a].size() / 2);
    std::nth_element(axes[a].begin(), middle, axes[a].end());
    uav.sigma_enu_m[a] = *middle;
  }
}

ImportedUav describe(const Flight& flight, const fs::path& rawlog) {
  ImportedUav uav;
  uav.name = flight.name;
  uav.rawlog = rawlog;
  uav.photos = flight.photos.size();
  uav.time_source = flight.time_source;
  uav.first = flight.photos.front().frame.time;
  uav.last = flight.photos.back().frame.time;
  std::map<std::tuple<int, int, double>, int> cameras;
  int most = 0;
  for (const ImportedPhoto& photo : flight.photos) {
    if (!photo.readable) ++uav.unreadable;
    const CameraModel& c = photo.frame.camera;
    const int count = ++cameras[{c.width, c.height, c.fx}];
    if (count <= most) continue;
    most = count;
    uav.camera = c;
    uav.focal_source = photo.focal_source;
  }
  describeFixes(flight, uav);
  return uav;
}

ImportedUav writeUav(const Flight& flight, const fs::path& out_dir) {
  const fs::path rawlog = out_dir / (flight.name + ".rawlog");
  const fs::path folder = imagesFolderOf(rawlog);
  createFolder(folder);
  RawlogWriter writer(rawlog);
  for (const ImportedPhoto& photo : flight.photos) {
    ImageFrame frame = photo.frame;
    frame.file = folder / frame.name;
    linkOrCopy(photo.source, frame.file);
    writer.write(frame);
    if (photo.fix) writer.write(*photo.fix);
  }
  writer.finish();
  return describe(flight, rawlog);
}

void writeConfig(const std::vector<ImportedUav>& uavs, const fs::path& file) {
  std::ofstream out(file);
  out << "; Written by cf-import. Every other setting has a default.\n";
  for (const ImportedUav& uav : uavs)
    out << "\n[uav." << uav.name << "]\nrawlog = " << uav.rawlog.filename().string() << "\n";
  out.close();
  if (!out) throw RunError(fmt::format("{} cannot be written", file.string()));
}

void warnIfNowhere(const Flight& flight, std::vector<std::string>& warnings) {
  const bool anywhere = std::any_of(flight.photos.begin(), flight.photos.end(),
                                    [](const ImportedPhoto& p) { return p.fix.has_value(); });
  if (!anywhere)
    warnings.push_back(fmt::format("no photo in {} has a GNSS position: the map will be relative",
                                   flight.folder.string()));
}

std::vector<Flight> readFlights(const ImportOptions& options, ImportSummary& summary) {
  std::optional<CameraModel> camera;
  if (!options.camera.empty()) camera = readCameraIni(options.camera);
  std::optional<GeoFile> geo;
  if (!options.geo.empty()) geo = readGeoTxt(options.geo);

  const std::vector<std::string> names = uavNames(options.images);
  std::vector<Flight> flights;
  for (std::size_t i = 0; i < options.images.size(); ++i)
    flights.push_back(readFlight(names[i], options.images[i], options, camera,
                                 summary.ignored_files, summary.warnings));
  if (geo) applyGeo(*geo, options, flights, summary.warnings);
  return flights;
}

}  // namespace

ImportSummary importFlights(const ImportOptions& options) {
  if (options.images.empty()) throw UsageError("no folder of photos is given: use --images DIR");
  if (options.out_dir.empty()) throw UsageError("no output folder is given: use -o OUTDIR");
  ImportSummary summary;
  std::vector<Flight> uavs;
  std::set<std::string> names;
  for (const Flight& flight : readFlights(options, summary)) {
    warnIfNowhere(flight, summary.warnings);
    for (Flight& uav : splitFlight(flight, options.split)) {
      while (!names.insert(uav.name).second) uav.name += "_";  // folders "x" split and "x_0"
      uavs.push_back(std::move(uav));
    }
  }
  createFolder(options.out_dir);
  for (const Flight& uav : uavs) summary.uavs.push_back(writeUav(uav, options.out_dir));
  summary.config = options.out_dir / "config.ini";
  writeConfig(summary.uavs, summary.config);
  return summary;
}

}  // namespace cf
