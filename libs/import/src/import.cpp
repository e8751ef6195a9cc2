// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "cf/base/disk.h"
#include "cf/base/error.h"
#include "cf/formats/camera_ini.h"
#include "cf/rawlog/rawlog_writer.h"
#include "flight.h"
#include "follow_folders.h"
#include "photo_files.h"
#include "summary.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

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
  if (options.follow_s > 0) return followFolders(options);
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
  std::vector<fs::path> rawlogs;
  for (const ImportedUav& uav : summary.uavs) rawlogs.push_back(uav.rawlog);
  writeConfig(rawlogs, 0, summary.config);
  return summary;
}

}  // namespace cf
