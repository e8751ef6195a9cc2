// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map_rasters.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "cf/deliver/orthophoto.h"
#include "photo_decoder.h"

namespace cf {
namespace {

constexpr const char* kDsm = "dsm.tif";

/// Ground size of a photo's own pixel, the median over the views.
double photoGroundSize(const std::vector<DenseView>& views) {
  std::vector<double> sizes;
  for (const DenseView& v : views) sizes.push_back(v.median_depth_m / v.camera.fx);
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

}  // namespace

MapRasters::MapRasters(const DeliverOptions& options, const GridFrame& grid, double voxel_m)
    : options_(options), grid_(grid), dsm_(grid, voxel_m) {}

void MapRasters::add(const Tile& tile) { dsm_.add(tile); }

void MapRasters::writeDsm(TileStore& cloud, const std::filesystem::path& outdir,
                          StageTimes& times) {
  if (dsm_.empty() || (!options_.dsm && !options_.orthophoto)) return;
  const StageTimes::Scope scope(times, "dsm", CpuClock::kProcess);
  dsm_.write(cloud, outdir / kDsm);
}

void MapRasters::writeOrthophoto(const std::vector<DenseView>& views,
                                 const std::vector<std::vector<ImageFrame>>& photos,
                                 const PhotoStore& store, double matched_pixel_m, int crops_mb,
                                 const std::filesystem::path& outdir, StageTimes& times) const {
  if (dsm_.empty() || !options_.orthophoto) return;
  const StageTimes::Scope scope(times, "orthophoto", CpuClock::kProcess);
  const double photo_m = photoGroundSize(views);
  const double gsd_m = options_.orthophoto_gsd_m > 0 ? options_.orthophoto_gsd_m
                                                     : std::max(photo_m, matched_pixel_m / 2);
  std::vector<OrthoPhoto> ortho(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    const DenseView& view = views[i];
    ortho[i] = {view.T_world_cam, view.camera, static_cast<int>(view.id.uav),
                orthoThumbnail(store.eighth(view.id))};
  });
  // No larger than the orthophoto can show.
  const double reduction = std::min(1.0, photo_m / gsd_m);
  const auto decode = [&](std::size_t i) {
    const ImageFrame& photo = photos[views[i].id.uav][views[i].id.index];
    const double full = 1e-6 * photo.camera.width * photo.camera.height;
    const auto image = decodePhoto(photo, full * reduction * reduction);
    return image ? image.value() : cv::Mat();
  };
  cf::writeOrthophoto(outdir / "orthophoto.tif", outdir / kDsm, grid_, ortho, decode, gsd_m,
                      crops_mb);
  if (!options_.dsm) std::filesystem::remove(outdir / kDsm);
}

}  // namespace cf
