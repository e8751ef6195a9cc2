// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/evaluate/change.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"
#include "cf/formats/float_raster.h"
#include "cf/geodesy/crs.h"
#include "change_picture.h"
#include "change_regions.h"
#include "figures.h"
#include "height_change.h"
#include "run_surface.h"
#include "surface_registration.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kListed = 50;
constexpr double kDegrees = 180 / M_PI;

Json registrationJson(const SurfaceRegistration& r) {
  const Eigen::AngleAxisd turn(r.rotation);
  const Eigen::Matrix<double, 7, 1> sigma = r.covariance.diagonal().cwiseSqrt();
  return {{"shift_m", triple(r.shift_m)},
          {"shift_sigma_m", triple(sigma.head<3>())},
          {"rotation_deg", triple(turn.angle() * kDegrees * turn.axis())},
          {"rotation_sigma_deg", triple(sigma.segment<3>(3) * kDegrees)},
          {"scale", finite(r.scale)},
          {"scale_sigma", finite(sigma[6] * r.scale)},
          {"about", triple(r.middle_m)},
          {"stable_share", finite(r.stable_share)},
          {"nmad_m", finite(r.nmad_m)},
          {"samples", r.samples},
          {"sample_m", finite(r.sample_m)}};
}

Json stableJson(const HeightChange& change) {
  Json blocks = Json::array();
  for (const auto& spread : change.block_spreads)
    blocks.push_back(
        {{"side_m", spread.side_m}, {"nmad_m", spread.nmad_m}, {"count", spread.blocks}});
  const auto& s = change.stable;
  return {{"cells", s.cells},
          {"share", finite(s.share)},
          {"bias_m", finite(s.bias_m)},
          {"nmad_m", finite(s.nmad_m)},
          {"beyond_2_sigma", finite(s.beyond_2_sigma)},
          {"beyond_3_sigma", finite(s.beyond_3_sigma)},
          {"noise",
           {{"constant_m", finite(change.noise.constant_m)},
            {"per_confidence", finite(change.noise.per_confidence)},
            {"factor", finite(change.noise.factor)}}},
          {"means_over_squares", blocks}};
}

Json regionJson(const ChangeRegion& region, std::size_t number, const Crs& crs, double height) {
  Json out = {{"number", number},
              {"kind", region.gain ? "gain" : "loss"},
              {"area_m2", finite(region.area_m2)},
              {"mean_height_m", finite(region.mean_m)},
              {"largest_height_m", finite(region.extreme_m)},
              {"volume_m3", finite(region.volume_m3)},
              {"volume_sigma_m3", finite(region.volume_sigma_m3)},
              {"easting", finite(region.middle_m.x())},
              {"northing", finite(region.middle_m.y())},
              {"lat", nullptr},
              {"lon", nullptr}};
  if (const auto place = geodeticFrom(crs, {region.middle_m.x(), region.middle_m.y(), height})) {
    out["lat"] = finite(place->latitude_deg);
    out["lon"] = finite(place->longitude_deg);
  }
  return out;
}

/// Sums of all regions of one sign. Their errors are taken to be independent.
Json sumJson(const std::vector<ChangeRegion>& regions, bool gain) {
  std::size_t count = 0;
  double area = 0, volume = 0, variance = 0;
  for (const ChangeRegion& region : regions) {
    if (region.gain != gain) continue;
    ++count;
    area += region.area_m2;
    volume += region.volume_m3;
    variance += region.volume_sigma_m3 * region.volume_sigma_m3;
  }
  return {{"changes", count},
          {"area_m2", area},
          {"volume_m3", volume},
          {"volume_sigma_m3", std::sqrt(variance)}};
}

Crs crsOf(const RunSurface& surface) {
  const auto crs = crsFromText(surface.crs);
  if (!crs) throw RunError("dsm.tif: " + crs.failure().detail);
  return *crs;
}

}  // namespace

std::string evaluateChange(const fs::path& out_a, const fs::path& out_b,
                           const ChangeOptions& options) {
  RunSurface a = readRunSurface(out_a, options.min_views),
             b = readRunSurface(out_b, options.min_views);
  const std::string both = out_a.string() + " and " + out_b.string();
  if (a.crs != b.crs)
    throw RunError(
        fmt::format("{} lie in different grids ({}, {}): run one of them with the "
                    "other's origin in [world]",
                    both, a.crs, b.crs));
  const auto registration = registerSurfaces(a, b);
  if (!registration) throw RunError(both + " cannot be compared: " + registration.failure().detail);
  const double cell_m = options.cell_m.value_or(std::min(a.cell(), b.cell()));
  a = averaged(a, cell_m);
  b = averaged(b, cell_m);
  const HeightChange change = heightChange(a, b, *registration, cell_m);
  const ChangeRegions regions = changeRegions(change, *registration, options.min_area_m2);

  std::error_code error;
  fs::create_directories(options.outdir, error);
  if (error) throw RunError(options.outdir.string() + ": cannot be made: " + error.message());
  const auto write = [&](const char* name, const cv::Mat& values) {
    FloatRaster raster;
    raster.values = values;
    raster.geotransform =
        std::array<double, 6>{change.west_m, cell_m, 0, change.north_m, 0, -cell_m};
    raster.crs_wkt_or_epsg = a.crs;
    raster.metadata = {{"AREA_OR_POINT", "Area"}, {"HEIGHT_DATUM", a.height_datum}};
    writeFloatRaster(options.outdir / name, raster);
  };
  cv::Mat significance;
  cv::divide(change.difference, change.sigma, significance);
  write("difference.tif", change.difference);
  write("sigma.tif", change.sigma);
  write("significance.tif", significance);
  writeChangePicture(options.outdir / "change.png", change, regions);

  const cv::Mat measured = change.difference.clone();
  cv::patchNaNs(measured, 1e9);
  const int common = cv::countNonZero(measured < 1e8);
  const Crs crs = crsOf(a);
  Json list = Json::array();
  for (std::size_t k = 0; k < std::min(kListed, regions.regions.size()); ++k)
    list.push_back(regionJson(regions.regions[k], k + 1, crs, registration->middle_m.z()));
  const Json out = {{"a", out_a.string()},
                    {"b", out_b.string()},
                    {"crs", a.crs},
                    {"height_datum", {a.height_datum, b.height_datum}},
                    {"cell_m", cell_m},
                    {"compared_m2", common * change.area()},
                    {"registration", registrationJson(*registration)},
                    {"stable_ground", stableJson(change)},
                    {"significance_limit", kSignificant},
                    {"min_area_m2", options.min_area_m2},
                    {"min_views", options.min_views},
                    {"gain", sumJson(regions.regions, true)},
                    {"loss", sumJson(regions.regions, false)},
                    {"changes_found", regions.regions.size()},
                    {"changes", list}};
  const std::string text = out.dump(2);
  writeFileAtomically(options.outdir / "change.json", text + "\n");
  return text;
}

}  // namespace cf
