// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/gcp_list.h"
#include "fuzz/fuzz_target.h"

std::vector<std::string> cf::fuzz::seeds() {
  return {
      "EPSG:32615\n576700.5 5188200.25 198.3 1200.5 800 DJI_0001.JPG p1\n"
      "576700.5 5188200.25 198.3 100.5 900 DJI_0002.JPG p1\n",
      "+proj=utm +zone=10 +ellps=WGS84 +datum=WGS84 +units=m +no_defs\n# x y z px py image\n"
      "544256.7 5320919.9 5 3044 2622 north/IMG_0525.jpg\n\n544157.7 5320899.2 5 4193 1552 "
      "a.jpg\n"};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cf::fuzz::InputFile file("gcp_list.txt");
  const auto& path = file.put(data, size);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    const cf::GcpList list = cf::readGcpList(path);
    cf::fuzz::require(!list.crs.empty() && !list.points.empty(), "a CRS and points");
    for (const auto& point : list.points) {
      cf::fuzz::require(!point.name.empty() && !point.marks.empty(), "names and marks");
      cf::fuzz::require(point.surveyed.allFinite(), "finite points");
    }
  });
  return 0;
}
