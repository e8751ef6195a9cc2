// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "output_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

#include "cf/base/error.h"
#include "cf/base/log.h"
#include "cf/config/config.h"
#include "cf/formats/atomic_file.h"

namespace cf {
namespace fs = std::filesystem;
namespace {

/// On disk while the run lasts, a photo, per megapixel matched: itself and its depth frames; and
/// with its share of tiles and clouds where photos overlap little.
constexpr double kWorkBytes = 5e6, kAllBytes = 2e7;

/// Files of an earlier result. The folder may hold other things too, photos even: what we have not
/// written stays.
void removeEarlierResult(const fs::path& outdir) {
  constexpr std::pair<const char*, const char*> kFiles[] = {
      {"images", ".csv"},       {"trajectories", ".tum"}, {"trajectories", ".csv"},
      {"trajectories", ".kml"}, {"cameras", ".ini"},      {"trajectories", ".geojson"},
      {"scale", ".csv"},        {"odometry", ".tum"},     {"graphs", ".graph"},
      {"cloud", ".ply"},        {"cloud", ".json"},       {"cloud/tiles", ".pcd"},
      {"cloud", ".las"},        {"snapshots", ".png"},    {"live", ".png"},
      {"colmap", ".txt"}};
  std::vector<fs::path> files;
  for (const char* name :
       {"report.json", "report.html", "world.json", "relative_poses.csv", "octomap.ot",
        "octomap.bt", "map.3Dscene", "dsm.tif", "orthophoto.tif", "shots.geojson", "map.kml"})
    files.push_back(outdir / name);
  std::error_code error;
  const auto collect = [&](const fs::path& folder, const char* extension) {
    for (const auto& item : fs::directory_iterator(folder, error))
      if (item.path().extension() == extension) files.push_back(item.path());
  };
  for (const auto& [folder, extension] : kFiles) collect(outdir / folder, extension);
  for (const auto& uav : fs::directory_iterator(outdir / "depth", error))
    collect(uav.path(), ".tif");
  for (const auto& link : fs::directory_iterator(outdir / "colmap" / "images", error))
    if (link.is_symlink()) files.push_back(link.path());
  for (const fs::path& file : files) {
    fs::remove(file, error);
    if (error) throw RunError(file.string() + " cannot be replaced: " + error.message());
  }
  fs::remove_all(workFolder(outdir), error);
  if (error) throw RunError(workFolder(outdir).string() + " cannot be removed: " + error.message());
}

/// Tells what run has begun there.
fs::path begunFile(const fs::path& outdir) { return workFolder(outdir) / "run.txt"; }

/// [playback] says when photos come, [system] with what they are worked on: not what becomes of
/// them.
std::string withoutCircumstances(std::string settings) {
  for (const char* section : {"[playback]\n", "[system]\n"}) {
    const std::size_t begin = settings.find(section);
    if (begin == std::string::npos) continue;
    const std::size_t end = std::min(settings.find("\n[", begin), settings.size());
    settings.erase(begin, end - begin);
  }
  return settings;
}

/// What a run depends on: its settings, and which recordings they are about, if these do not grow.
std::string fingerprint(const FlightRunRequest& request, const Config& config,
                        const RunOptions& options) {
  std::string text =
      "version = " + request.version + "\n" + withoutCircumstances(config.effectiveText());
  if (options.playback.follow_s > 0) return text;
  for (const UavOptions& uav : options.uavs) {
    std::error_code error;
    const auto size = fs::file_size(config.resolve(uav.rawlog), error);
    text += fmt::format("{} = {} bytes\n", uav.rawlog, error ? 0 : size);
  }
  return text;
}

std::string textOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Of a flight that was followed it is not known how large the recordings were.
bool sameRun(const std::string& before, const std::string& now) {
  const std::size_t common = std::min(before.size(), now.size());
  return before.compare(0, common, now, 0, common) == 0;
}

/// The first line that differs.
std::string difference(const std::string& before, const std::string& now) {
  const std::size_t at = static_cast<std::size_t>(
      std::mismatch(before.begin(), before.end(), now.begin(), now.end()).first - before.begin());
  const auto line = [&](const std::string& text) {
    const std::size_t begin = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
    return begin < text.size() ? text.substr(begin, text.find('\n', begin) - begin)
                               : std::string("nothing");
  };
  return "'" + line(before) + "' then, '" + line(now) + "' now";
}

void checkSpace(const fs::path& outdir, const DensifyOptions& options, std::size_t photos) {
  std::error_code error;
  const auto free = static_cast<double>(fs::space(outdir, error).available);
  if (error) return;
  const double megapixels = options.megapixels * static_cast<double>(photos);
  if (free < megapixels * kWorkBytes)
    throw RunError(fmt::format("{}: {:.1f} GB are free there, at least {:.1f} GB are needed",
                               outdir.string(), 1e-9 * free, 1e-9 * megapixels * kWorkBytes));
  if (free < megapixels * kAllBytes)
    logWarning(fmt::format("{}: {:.1f} GB are free there, up to {:.1f} GB may be needed",
                           outdir.string(), 1e-9 * free, 1e-9 * megapixels * kAllBytes));
}

}  // namespace

fs::path workFolder(const fs::path& outdir) { return outdir / ".cf-run"; }

bool isFinished(const fs::path& outdir) {
  return fs::exists(outdir / "report.json") && !fs::exists(workFolder(outdir));
}

void checkOutput(const FlightRunRequest& request, const Config& config, const RunOptions& options) {
  const fs::path& outdir = request.outdir;
  const fs::path begun = begunFile(outdir);
  const bool interrupted = fs::exists(begun);
  const std::string now = fingerprint(request, config, options);
  if (interrupted && request.resume && !sameRun(textOf(begun), now))
    throw UsageError(fmt::format(
        "{} was begun with other settings ({}): resume it with the same ones, or give -w to begin "
        "anew",
        outdir.string(), difference(textOf(begun), now)));
  if (interrupted && !request.resume && !request.overwrite)
    throw UsageError(outdir.string() +
                     " holds an interrupted run; give --resume to go on with it or -w to begin "
                     "anew");
  if (!interrupted && fs::exists(outdir / "report.json") && !request.overwrite)
    throw UsageError(outdir.string() + " holds an earlier result; give -w to overwrite it");
}

void prepareOutput(const FlightRunRequest& request, const Config& config, const RunOptions& options,
                   std::size_t photos) {
  const fs::path& outdir = request.outdir;
  const fs::path begun = begunFile(outdir);
  std::error_code error;
  fs::create_directories(outdir, error);
  if (error) throw RunError(outdir.string() + " cannot be made: " + error.message());
  if (request.overwrite && !(fs::exists(begun) && request.resume)) removeEarlierResult(outdir);
  checkSpace(outdir, options.densify, photos);
  fs::create_directories(begun.parent_path(), error);
  if (error) throw RunError(begun.parent_path().string() + " cannot be made: " + error.message());
  writeFileAtomically(begun, fingerprint(request, config, options));
  writeFileAtomically(outdir / "config.effective.ini", config.effectiveText());
}

}  // namespace cf
