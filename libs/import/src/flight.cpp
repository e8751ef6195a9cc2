// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "cf/base/error.h"
#include "cf/base/text.h"
#include "cf/import/focal.h"
#include "cf/import/strips.h"
#include "cf/import/timing.h"
#include "cf/rawlog/rawlog_reader.h"
#include "photo_files.h"

namespace cf {
namespace {

namespace fs = std::filesystem;
using Warnings = std::vector<std::string>;

bool sameBytes(const fs::path& a, const fs::path& b) {
  std::error_code failed;
  if (fs::file_size(a, failed) != fs::file_size(b, failed) || failed) return false;
  std::ifstream in_a(a, std::ios::binary), in_b(b, std::ios::binary);
  return in_a && in_b &&
         std::equal(std::istreambuf_iterator<char>(in_a), std::istreambuf_iterator<char>(),
                    std::istreambuf_iterator<char>(in_b));
}

/// Copies of a photo in the same folder tree: the first by name stays.
std::size_t dropDuplicates(std::vector<fs::path>& files, std::vector<PhotoTags>& tags) {
  std::map<std::pair<TimeNs, std::uintmax_t>, std::vector<std::size_t>> alike;
  std::vector<bool> drop(files.size(), false);
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!tags[i].readable || !tags[i].time.camera) continue;
    std::error_code failed;
    std::vector<std::size_t>& others =
        alike[{*tags[i].time.camera, fs::file_size(files[i], failed)}];
    drop[i] = std::any_of(others.begin(), others.end(),
                          [&](std::size_t k) { return sameBytes(files[k], files[i]); });
    if (!drop[i]) others.push_back(i);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (drop[i]) continue;
    std::swap(files[kept], files[i]);
    std::swap(tags[kept], tags[i]);
    ++kept;
  }
  const std::size_t dropped = files.size() - kept;
  files.resize(kept);
  tags.resize(kept);
  return dropped;
}

struct Camera {
  CameraModel model;
  std::string source;
  bool assumed = false;
};

bool sameShape(const CameraModel& camera, int width, int height) {
  constexpr double kPixels = 1.0;
  return std::abs(static_cast<double>(camera.height) * width / camera.width - height) <= kPixels;
}

Camera cameraOf(const PhotoTags& tags, const std::optional<CameraModel>& given) {
  if (given && sameShape(*given, tags.width, tags.height))
    return {given->scaled(tags.width, tags.height), "camera file", false};
  const FocalEstimate focal = focalOf(tags.focal, tags.width, tags.height);
  return {cameraFrom(focal, tags.width, tags.height), focal.source, focal.assumed};
}

/// The camera that most readable photos have; of equals the first.
Camera usualCamera(const std::vector<PhotoTags>& tags, const std::optional<CameraModel>& given) {
  std::map<std::tuple<int, int, double>, std::pair<int, Camera>> counts;
  const std::pair<int, Camera>* best = nullptr;
  for (const PhotoTags& t : tags) {
    if (!t.readable) continue;
    const Camera camera = cameraOf(t, given);
    auto& entry = counts[{t.width, t.height, camera.model.fx}];
    if (entry.first++ == 0) entry.second = camera;
    if (best == nullptr || entry.first > best->first) best = &entry;
  }
  if (best != nullptr) return best->second;
  return {given.value_or(CameraModel{}), given ? "camera file" : "none: no photo is readable",
          false};
}

GnssFix fixFrom(const PhotoPosition& position, TimeNs time, const ImportOptions& options) {
  // A photo without a height: the sigma says that nothing is known of it.
  constexpr double kNoHeightSigma_m = 1000;
  GnssFix fix;
  fix.time = time;
  fix.latitude_deg = position.latitude_deg;
  fix.longitude_deg = position.longitude_deg;
  fix.height_m = position.height_m.value_or(0);
  fix.datum = position.datum;
  fix.sigma_enu_m = position.sigma_enu_m.value_or(defaultSigma(options));
  if (!position.height_m) fix.sigma_enu_m.z() = kNoHeightSigma_m;
  return fix;
}

void warnAbout(const std::vector<PhotoTags>& tags, const std::vector<Camera>& cameras,
               const std::optional<CameraModel>& given, const std::string& folder,
               Warnings& warnings) {
  const auto count = [&](auto&& predicate) {
    return std::count_if(tags.begin(), tags.end(), predicate);
  };
  const auto warn = [&](std::ptrdiff_t photos, const char* what) {
    if (photos != 0) warnings.push_back(fmt::format("{}: {} photos {}", folder, photos, what));
  };
  warn(count([](const PhotoTags& t) { return !t.readable; }),
       "cannot be read; they are recorded, to be reported as damaged");
  warn(count([](const PhotoTags& t) { return t.position && !t.position->height_m; }),
       "have a GNSS position without a height");
  warn(count([](const PhotoTags& t) { return t.orientation != 1; }),
       "are tagged as turned; they are taken as the sensor saw them");
  warn(std::count_if(cameras.begin(), cameras.end(), [](const Camera& c) { return c.assumed; }),
       "have no usable focal length; it is assumed, give --camera if you know it");
  if (given)
    warn(count([&](const PhotoTags& t) {
           return t.readable && !sameShape(*given, t.width, t.height);
         }),
         "have another shape than the camera file; theirs is by their tags");
}

}  // namespace

Eigen::Vector3d defaultSigma(const ImportOptions& options) {
  const Eigen::Vector2d hv =
      options.sigma_m.value_or(Eigen::Vector2d(kDefaultSigmaHorizontal_m, kDefaultSigmaVertical_m));
  return {hv.x(), hv.x(), hv.y()};
}

Flight flightOf(const std::string& name, const fs::path& folder, TaggedPhotos photos,
                const ImportOptions& options, const std::optional<CameraModel>& given,
                Warnings& warnings) {
  auto& [files, tags] = photos;
  std::vector<PhotoTime> tagged_times;
  const std::size_t duplicates = dropDuplicates(files, tags);
  if (duplicates != 0)
    warnings.push_back(
        fmt::format("{}: {} photos are copies of others: left out", folder.string(), duplicates));
  for (const PhotoTags& t : tags) tagged_times.push_back(t.time);

  const FlightTimes times = flightTimes(tagged_times);
  for (const std::string& w : times.warnings)
    warnings.push_back(fmt::format("{}: {}", folder.string(), w));
  const std::vector<std::string> names = uniqueNames(files);
  const Camera usual = usualCamera(tags, given);

  Flight flight{name, folder, times.source, {}};
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    cameras.push_back(tags[i].readable ? cameraOf(tags[i], given) : usual);
    ImportedPhoto photo;
    photo.source = files[i];
    photo.readable = tags[i].readable;
    photo.frame.name = names[i];
    photo.frame.time = times.times[i];
    photo.frame.camera = cameras[i].model;
    photo.focal_source = cameras[i].source;
    photo.frame.attitude = tags[i].attitude;
    photo.frame.height_above_ground_m = tags[i].height_above_ground_m;
    if (tags[i].position) photo.fix = fixFrom(*tags[i].position, photo.frame.time, options);
    flight.photos.push_back(std::move(photo));
  }
  std::stable_sort(
      flight.photos.begin(), flight.photos.end(),
      [](const ImportedPhoto& a, const ImportedPhoto& b) { return a.frame.time < b.frame.time; });
  warnAbout(tags, cameras, given, folder.string(), warnings);
  return flight;
}

Flight readFlight(const std::string& name, const fs::path& folder, const ImportOptions& options,
                  const std::optional<CameraModel>& given, std::size_t& ignored_files,
                  Warnings& warnings) {
  PhotoFiles found = findPhotos(folder, options.out_dir);
  ignored_files += found.others;
  TaggedPhotos photos{std::move(found.photos), {}};
  for (const fs::path& file : photos.files) photos.tags.push_back(readPhotoTags(file));
  return flightOf(name, folder, std::move(photos), options, given, warnings);
}

std::vector<Flight> splitFlight(const Flight& flight, const std::string& split) {
  if (split.empty()) return {flight};
  const std::size_t n = flight.photos.size();
  std::vector<int> part(n);
  if (split == "strips") {
    std::optional<LocalFrame> frame;
    std::vector<std::optional<Eigen::Vector2d>> track(n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto& fix = flight.photos[i].fix;
      if (!fix) continue;
      if (!frame) frame.emplace(fix->latitude_deg, fix->longitude_deg, 0);
      track[i] = frame->toEnu(fix->latitude_deg, fix->longitude_deg, 0).head<2>();
    }
    part = stripsOf(track);
    if (part.empty())
      throw UsageError(
          fmt::format("{} cannot be cut into strips: fewer than two of its photos "
                      "have a GNSS position; use --split with a number",
                      flight.folder.string()));
  } else {
    const auto parts = numberFrom(split);
    if (!parts || *parts != std::floor(*parts) || *parts < 1)
      throw UsageError(fmt::format("--split {}: give a number of UAVs or 'strips'", split));
    if (*parts > static_cast<double>(n))
      throw UsageError(
          fmt::format("--split {}: {} holds only {} photos", split, flight.folder.string(), n));
    for (std::size_t i = 0; i < n; ++i)
      part[i] = static_cast<int>(i * static_cast<std::size_t>(*parts) / n);
  }
  std::vector<Flight> flights;
  for (std::size_t i = 0; i < n; ++i) {
    while (static_cast<int>(flights.size()) <= part[i])
      flights.push_back({fmt::format("{}_{}", flight.name, flights.size()),
                         flight.folder,
                         flight.time_source,
                         {}});
    flights[static_cast<std::size_t>(part[i])].photos.push_back(flight.photos[i]);
  }
  return flights;
}

}  // namespace cf
