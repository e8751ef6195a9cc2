// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "cf/formats/image_header.h"
#include "cf/import/exif.h"
#include "cf/import/timing.h"
#include "fuzz/fuzz_target.h"
#include "support/exif_jpeg.h"
#include "support/temp_folder.h"

std::vector<std::string> cf::fuzz::seeds() {
  using support::ExifJpeg;
  const support::TempFolder folder;
  std::vector<std::string> made;
  const auto add = [&](const ExifJpeg& exif) {
    exif.write(folder / "a.jpg", 16, 9);
    made.push_back(support::fileText(folder / "a.jpg"));
  };
  const auto usual = [] {
    ExifJpeg exif;
    exif.dateTime("2016:06:23 16:31:59").position(46.8428646, -91.9936966, 198.309);
    exif.word(ExifJpeg::kExif, 0xA405, 28).rationals(ExifJpeg::kExif, 0x920A, {3.61}, 100);
    return exif;
  };
  add(ExifJpeg());
  add(usual());
  add(usual()
          .word(ExifJpeg::kMain, 0x0112, 6)
          .text(ExifJpeg::kExif, 0x9291, "123")
          .text(ExifJpeg::kExif, 0x9011, "+05:30")
          .rationals(ExifJpeg::kExif, 0xA20E, {2311.2}, 100)
          .word(ExifJpeg::kExif, 0xA210, 3)
          .text(ExifJpeg::kGps, 0x1D, "2016:06:23")
          .rationals(ExifJpeg::kGps, 7, {16, 31, 59.5}, 10));
  add(
      usual().xmp("drone-dji:GimbalYawDegree=\"-131.30\" drone-dji:GimbalPitchDegree=\"-89.90\" "
                  "drone-dji:GimbalRollDegree=\"+0.10\" drone-dji:RelativeAltitude=\"+39.80\" "
                  "drone-dji:GpsLatitude=\"46.84286461\" drone-dji:GpsLongtitude='-91.99369667' "
                  "drone-dji:AbsoluteAltitude=\"198.309\" drone-dji:RtkStdLon=\"0.0123\" "
                  "drone-dji:RtkStdLat=\"0.0145\" drone-dji:RtkStdHgt=\"0.0331\""));
  for (const char* extension : {".png", ".tif"}) {
    std::vector<unsigned char> bytes;
    cv::imencode(extension, cv::Mat(9, 16, CV_8UC3, cv::Scalar(1, 2, 3)), bytes);
    made.emplace_back(bytes.begin(), bytes.end());
  }
  return made;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cf::fuzz::InputFile file("photo.jpg");
  const cf::PhotoTags tags = cf::readPhotoTags(file.put(data, size));
  using cf::fuzz::require;
  const auto told = cf::imageSizeOf(data, size);
  require(!told || (told->width > 0 && told->height > 0), "a size above zero");
  if (!tags.readable) return 0;
  require(tags.width > 0 && tags.height > 0, "a readable photo has a size");
  require(tags.orientation >= 1 && tags.orientation <= 8, "an orientation");
  if (tags.position) {
    const cf::PhotoPosition& p = *tags.position;
    require(std::abs(p.latitude_deg) <= 90 && std::abs(p.longitude_deg) <= 180, "places on Earth");
    require(!p.height_m || std::isfinite(*p.height_m), "finite heights");
    require(!p.sigma_enu_m || (p.sigma_enu_m->allFinite() && p.sigma_enu_m->minCoeff() > 0),
            "sigmas above zero");
  }
  if (tags.attitude)
    require(
        std::isfinite(tags.attitude->yaw_deg + tags.attitude->pitch_deg + tags.attitude->roll_deg),
        "finite attitudes");
  const cf::FocalEstimate focal = cf::focalOf(tags.focal, tags.width, tags.height);
  require(std::isfinite(focal.focal_px) && focal.focal_px > 0, "a focal length");
  require(cf::flightTimes({tags.time, tags.time}).times.size() == 2, "a time for each photo");
  return 0;
}
