// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "cf/formats/camera_ini.h"
#include "fuzz/fuzz_target.h"

std::vector<std::string> cf::fuzz::seeds() {
  return {"[camera]\nwidth = 4000\nheight = 2250\nfx = 2311.25\n",
          "; of a run\n[before]\nfx = 1\n[camera]\nwidth = 4000\nheight = 3000\nfx = 2311.25\n"
          "fy = 2312\ncx = 1999.5\ncy = 1499.5\nk1 = -0.014\nk2 = 0.0142 # radial\np1 = 0.0012\n"
          "p2 = -0.0028\nk3 = 1e-5\nfocal_sigma = 115.5\nk1_sigma = 0.1\nk2_sigma = 0.03\n"
          "[after]\nx = y\n"};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cf::fuzz::InputFile file("camera.ini");
  const auto& path = file.put(data, size);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    const cf::CameraModel c = cf::readCameraIni(path);
    cf::fuzz::require(c.width > 0 && c.height > 0 && c.fx > 0 && c.fy > 0,
                      "a size and a focal length");
    cf::fuzz::require(std::isfinite(c.fx + c.fy + c.cx + c.cy + c.k1 + c.k2 + c.p1 + c.p2 + c.k3),
                      "finite values");
    cf::fuzz::require(c.focal_sigma >= 0 && c.k1_sigma >= 0 && c.k2_sigma >= 0, "sigmas");
  });
  return 0;
}
