// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "cf/import/geo_txt.h"
#include "fuzz/fuzz_target.h"

std::vector<std::string> cf::fuzz::seeds() {
  return {
      "EPSG:4326\nDJI_0001.JPG -91.9937 46.8429 198.3\nDJI_0002.JPG -91.9938 46.8430 198.4\n",
      "EPSG:4979 # ellipsoid\n100MEDIA/a.jpg -91.99 46.84 198.3 -131.3 -89.9 0.1 0.02 0.04\n",
      "WGS84 UTM 15N\nDJI_0001.JPG 576700.5 5188200.25 198.3 0.5 1\r\n\r\n# end\n",
      "+proj=utm +zone=17 +south +datum=WGS84 +units=m +no_defs\na.jpg 500000 4649776 10 1 2 3\n",
      "\xEF\xBB\xBF"
      "EPSG:32615\na.jpg 576700.5 5188200.25 198.3\n"};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cf::fuzz::InputFile file("geo.txt");
  const auto& path = file.put(data, size);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    for (const cf::GeoEntry& entry : cf::readGeoTxt(path).entries) {
      const cf::Geodetic& p = entry.position;
      cf::fuzz::require(std::abs(p.latitude_deg) <= 90 && std::abs(p.longitude_deg) <= 540 &&
                            std::isfinite(p.height_m),
                        "places on Earth");
      cf::fuzz::require(!entry.sigma_m || entry.sigma_m->minCoeff() > 0, "sigmas above zero");
    }
  });
  return 0;
}
