// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cf/base/disk.h"
#include "cf/base/stopwatch.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/float_raster.h"
#include "cf/formats/jpeg.h"
#include "cf/rawlog/rawlog_writer.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

fs::path rawlogOf(const PlannedUav& uav, const fs::path& outdir) {
  return fs::absolute(outdir) / (uav.options.name + ".rawlog");
}

}  // namespace

void writeRawlog(const PlannedUav& uav, const fs::path& outdir) {
  const fs::path rawlog = rawlogOf(uav, outdir), folder = imagesFolderOf(rawlog);
  createFolder(folder);
  RawlogWriter writer(rawlog);
  std::vector<GnssFix> fixes;
  for (const SimulatedFix& fix : uav.gnss.fixes) fixes.push_back(fix.fix);
  auto fix = fixes.begin();
  for (const PlannedPhoto& photo : uav.photos) {
    for (; fix != fixes.end() && fix->time < photo.time; ++fix) writer.write(*fix);
    ImageFrame frame;
    frame.time = photo.time;
    frame.name = photo.name;
    frame.file = folder / photo.name;
    frame.camera = uav.told;
    frame.attitude = photo.attitude;
    writer.write(frame);
  }
  for (; fix != fixes.end(); ++fix) writer.write(*fix);
  writer.finish();
}

void writeRunConfig(const SimulationSetup& setup, const std::vector<PlannedUav>& uavs,
                    const fs::path& file) {
  const Geodetic& o = setup.origin;
  std::string text = fmt::format(
      "; Written by cf-simulate. Every other setting has a default.\n\n[world]\norigin = {}, {}, "
      "{}\n",
      o.latitude_deg, o.longitude_deg, o.height_m);
  for (const PlannedUav& uav : uavs)
    text += fmt::format("\n[uav.{0}]\nrawlog = {0}.rawlog\n", uav.options.name);
  writeFileAtomically(file, text);
}

double writePhoto(const PlannedUav& uav, const PlannedPhoto& photo, const Scene& scene,
                  const PhotoOptions& options, const fs::path& outdir) {
  const double start = wallSeconds();
  const cv::Mat image = takePhoto(scene, uav.camera, photo.motion, options, photo.seed);
  const double seconds = wallSeconds() - start;
  writeFileAtomically(imagesFolderOf(rawlogOf(uav, outdir)) / photo.name,
                      encodeJpeg(image, options.jpeg_quality));
  return seconds;
}

void writeDepth(const PlannedUav& uav, const PlannedPhoto& photo, const Scene& scene,
                const PhotoOptions& options, double megapixels, const fs::path& truth) {
  constexpr double kMega = 1e6;
  const double pixels = static_cast<double>(uav.camera.width) * uav.camera.height;
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMega / megapixels))));
  FloatRaster raster;
  raster.values = trueDepth(scene, uav.camera, photo.motion, options, step);
  raster.metadata["STEP"] = std::to_string(step);
  const fs::path folder = truth / "depth" / uav.options.name;
  createFolder(folder);
  writeFloatRaster(folder / (fs::path(photo.name).stem().string() + ".tif"), raster);
}

}  // namespace cf
