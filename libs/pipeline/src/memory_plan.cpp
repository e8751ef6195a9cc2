// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "memory_plan.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "thread_limit.h"

namespace cf {
namespace {

constexpr double kMegabyte = 1024.0 * 1024.0;
constexpr double kShareOfMachine = 0.75;

/// The program with its libraries and threads.
constexpr double kProgram_mb = 170;
/// What odometry and the centre keep of each photo, what the solution of the whole takes beside it,
/// what is left when that is done, and with the rasters and pictures of the whole.
constexpr double kFlightPhoto_mb = 0.75, kSolvingPhoto_mb = 0.9, kMapPhoto_mb = 0.35;
constexpr double kProductsPhoto_mb = 0.8;
constexpr double kSolving_mb = 65;
/// A photo that is decoded and searched for features, beyond its pixels, per megapixel searched.
constexpr double kFeatures_mb = 45;
/// A photo that is being matched, with the points that it adds, per megapixel matched.
constexpr double kMatching_mb = 75;
/// The orthophoto beyond parts of photos; the renderer, its scene and a picture, and what several
/// pictures take more.
constexpr double kOrthophoto_mb = 120, kPictures_mb = 680, kMorePictures_mb = 190;
constexpr int kLeastTiles_mb = 48, kLeastCrops_mb = 48, kMostCrops_mb = 300;
constexpr std::size_t kLeastPhotos = 3;  ///< in memory: a reference and its partners
constexpr double kLive_mb = 100;
constexpr double kBytesOfPixel = 3;

/// Of the machine, or of the control group that it lets us have.
double machineMegabytes() {
  double bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  for (const char* file :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    double limit = 0;
    if (std::ifstream(file) >> limit && limit > 0) bytes = std::min(bytes, limit);
  }
  return bytes / kMegabyte;
}

std::size_t fitting(double room_mb, double each_mb, std::size_t most) {
  const double many = std::floor(room_mb / std::max(1.0, each_mb));
  return static_cast<std::size_t>(std::clamp(many, 1.0, static_cast<double>(most)));
}

int within(double room_mb, int least, int most) {
  return static_cast<int>(std::clamp(room_mb, std::min(1.0 * least, 1.0 * most), 1.0 * most));
}

}  // namespace

double memoryLimit(const RunOptions& options) {
  const int told = options.system.max_memory_mb;
  return told > 0 ? told : kShareOfMachine * machineMegabytes();
}

void FlightSize::add(const ImageFrame& photo) {
  ++photos;
  photo_mp = std::max(photo_mp, 1e-6 * photo.camera.width * photo.camera.height);
}

MemoryPlan planMemory(const RunOptions& options, const FlightSize& flight) {
  MemoryPlan plan;
  plan.limit_mb = memoryLimit(options);

  // A JPEG is decoded at 1, 1/2 or 1/4: up to four times the pixels that are wanted.
  const double wanted_mp =
      std::max(options.odometry.features.megapixels, 2 * options.densify.megapixels);
  const double decoded_mb = kBytesOfPixel * std::min(flight.photo_mp, 4 * wanted_mp);
  const double searched_mb =
      2 * decoded_mb + kFeatures_mb * std::max(1.0, options.odometry.features.megapixels);
  const double matched_mb = kMatching_mb * options.densify.megapixels;
  const double live_mb =
      options.playback.inRealTime() || options.view.live_every_s > 0 ? kLive_mb : 0;
  const double whole_mb = kBytesOfPixel * flight.photo_mp;  // of the orthophoto
  const double threads = std::min(16, threadsOf(options));
  const double raster_mb = kOrthophoto_mb + threads * 2 * whole_mb;
  const double pictures_mb = options.view.snapshots ? kPictures_mb : 0;

  const auto photos = static_cast<double>(flight.photos);
  const double flight_mb = kProgram_mb + kFlightPhoto_mb * photos;
  const double map_mb = kProgram_mb + kMapPhoto_mb * photos;
  const double products_mb = kProgram_mb + kProductsPhoto_mb * photos;
  plan.least_mb = std::max(
      {flight_mb + searched_mb + live_mb, flight_mb + kSolving_mb + kSolvingPhoto_mb * photos,
       map_mb + matched_mb + kLeastTiles_mb + static_cast<double>(kLeastPhotos) * decoded_mb,
       products_mb + raster_mb + kLeastCrops_mb, products_mb + pictures_mb});

  const double flight_room_mb = plan.limit_mb - flight_mb - live_mb;
  const double room_mb = plan.limit_mb - map_mb;
  plan.tile_mb = within(room_mb / 3, kLeastTiles_mb, options.fuse.max_memory_mb);
  plan.photos_in_memory = std::max<std::size_t>(kLeastPhotos, fitting(room_mb / 5, decoded_mb, 12));
  plan.photos_matched =
      fitting(room_mb - plan.tile_mb - static_cast<double>(plan.photos_in_memory) * decoded_mb,
              matched_mb, 3);
  // Only so many as there are threads are decoded at a time; the others keep their features.
  plan.steps_in_flight =
      flight_room_mb >= threads * searched_mb + 16 ? 16 : fitting(flight_room_mb, searched_mb, 16);
  const double products_room_mb = plan.limit_mb - products_mb;
  const double pictures_at_once_mb = options.view.snapshots ? kPictures_mb + kMorePictures_mb : 0;
  plan.side_by_side = products_room_mb >= pictures_at_once_mb + raster_mb + kMostCrops_mb;
  plan.crops_mb = within(products_room_mb - raster_mb, kLeastCrops_mb, kMostCrops_mb);
  return plan;
}

std::string objectionTo(const MemoryPlan& plan, const RunOptions& options,
                        const FlightSize& flight) {
  if (plan.least_mb <= plan.limit_mb) return {};
  const std::string size =
      flight.photo_mp > 0 ? fmt::format(" of {:.0f} MP", flight.photo_mp) : std::string();
  return fmt::format(
      "{} photos{} matched at {:g} MP need about {:.0f} MB of memory, more than the {:.0f} MB that "
      "they may have ([system] max_memory_mb): allow more, or try a smaller [densify] megapixels "
      "or "
      "[view] snapshots = false",
      flight.photos, size, options.densify.megapixels, plan.least_mb, plan.limit_mb);
}

}  // namespace cf
