// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/deliver/orthophoto.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <memory>

#include "cf/base/progress.h"
#include "cf/formats/geotiff.h"
#include "ortho_paint.h"
#include "ortho_shares.h"
#include "ortho_surface.h"
#include "ortho_tones.h"
#include "ortho_views.h"
#include "photo_crops.h"

namespace cf {
namespace {

constexpr int kWindow = 512;  ///< nodes
constexpr int kWindowsAtOnce = 2;

/// Windows in an order that keeps those in work side by side few: along the shorter side.
std::vector<cv::Rect> windowsOf(cv::Size size) {
  const cv::Size count((size.width - 1) / kWindow + 1, (size.height - 1) / kWindow + 1);
  const bool by_columns = size.width > size.height;
  const int outer = by_columns ? count.width : count.height;
  const int inner = by_columns ? count.height : count.width;
  std::vector<cv::Rect> windows;
  for (int i = 0; i < outer; ++i)
    for (int j = 0; j < inner; ++j) {
      const cv::Point at = by_columns ? cv::Point(i, j) : cv::Point(j, i);
      windows.push_back(cv::Rect(at.x * kWindow, at.y * kWindow, kWindow, kWindow) &
                        cv::Rect({0, 0}, size));
    }
  return windows;
}

struct Picture {
  cv::Rect window;
  cv::Mat pixels;
};

}  // namespace

void writeOrthophoto(const std::filesystem::path& path, const std::filesystem::path& dsm,
                     const GridFrame& grid, const std::vector<OrthoPhoto>& photos,
                     const std::function<cv::Mat(std::size_t)>& decode, double gsd_m,
                     int crops_mb) {
  const OrthoSurface surface(dsm, gsd_m);
  const auto candidates = orthoCandidates(surface, grid, photos);
  const OrthoTones tones(candidates, photos);
  std::vector<CameraModel> cameras;
  std::vector<double> limits;
  for (const OrthoPhoto& photo : photos) {
    cameras.push_back(photo.camera);
    limits.push_back(sightLimit(photo.camera));
  }
  const OrthoScene scene{surface, grid, photos, limits, candidates, tones};

  // Geometry first: then it is known which part of which photo each window needs.
  const std::vector<cv::Rect> windows = windowsOf(surface.size());
  std::vector<OrthoWindow> shared(windows.size());
  tbb::parallel_for(std::size_t{0}, windows.size(),
                    [&](std::size_t i) { shared[i] = shareOrthoWindow(scene, windows[i]); });
  std::vector<PhotoCrops::Parts> parts(photos.size());
  for (std::size_t i = 0; i < windows.size(); ++i)
    for (const OrthoShare& share : shared[i].shares)
      parts[static_cast<std::size_t>(share.photo)][i] = share.part;
  PhotoCrops crops(decode, cameras, std::move(parts), static_cast<std::size_t>(crops_mb) << 20);

  const int n = surface.pixelsPerNode();
  GeoTiffWriter out(path, GeoTiffWriter::Kind::kColours,
                    {surface.size().width * n, surface.size().height * n, surface.left(),
                     surface.top(), surface.node() / n, surface.crs()},
                    {{"AREA_OR_POINT", "Area"}});
  Progress progress("orthophoto", windows.size());
  std::size_t next = 0;
  tbb::parallel_pipeline(
      kWindowsAtOnce,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order,
                                          [&](tbb::flow_control& control) {
                                            if (next == windows.size()) control.stop();
                                            return next++;
                                          }) &
          tbb::make_filter<std::size_t, std::shared_ptr<Picture>>(
              tbb::filter_mode::parallel,
              [&](std::size_t i) {
                auto picture = std::make_shared<Picture>();
                picture->window = windows[i];
                if (!shared[i].shares.empty())
                  picture->pixels = paintOrthoWindow(scene, crops, i, shared[i]);
                shared[i] = {};
                return picture;
              }) &
          tbb::make_filter<std::shared_ptr<Picture>, void>(
              tbb::filter_mode::serial_in_order, [&](const std::shared_ptr<Picture>& picture) {
                if (!picture->pixels.empty())
                  out.write(picture->window.x * n, picture->window.y * n, picture->pixels);
                progress.advance();
              }));
  out.close();
}

}  // namespace cf
