// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <zlib.h>

#include <cmath>
#include <fstream>

#include "cf/rawlog/rawlog_follower.h"
#include "fuzz/fuzz_target.h"
#include "support/mrpt_leak.h"
#include "support/recordings.h"
#include "support/temp_folder.h"

namespace {

std::string unzipped(const std::filesystem::path& file) {
  std::string bytes(1 << 16, '\0');
  gzFile in = gzopen(file.c_str(), "rb");
  bytes.resize(static_cast<std::size_t>(
      std::max(0, gzread(in, bytes.data(), static_cast<unsigned>(bytes.size())))));
  gzclose(in);
  return bytes;
}

}  // namespace

std::vector<std::string> cf::fuzz::seeds() {
  const support::TempFolder folder;
  const auto path = folder / "uav.rawlog";
  std::vector<std::string> made;
  for (const int photos : {0, 1, 3}) {
    RawlogWriter writer(path);
    for (int i = 0; i < photos; ++i) {
      writer.write(support::fullPhoto(path, i));
      writer.write(support::fullFix(i));
    }
    if (photos == 0) writer.write(support::fullFix(0));
    writer.finish();
    // Mutations of compressed bytes seldom get past the decompression.
    if (photos == 1) made.push_back(support::fileText(path));
    for (int copies = 0; copies < 3; ++copies) made.push_back(unzipped(path));
  }
  return made;
}

namespace {

/// The same bytes, of which a part comes first.
void followInTwoParts(cf::fuzz::InputFile& file, const std::uint8_t* data, std::size_t size) {
  const auto& path = file.put(data, size / 2);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    cf::RawlogFollower follower(path);
    std::vector<cf::ImageFrame> photos = follower.poll().photos;
    std::ofstream(path, std::ios::binary | std::ios::app)
        .write(reinterpret_cast<const char*>(data) + size / 2,
               static_cast<std::streamsize>(size - size / 2));
    for (const cf::UavRecording& r : {follower.poll(), follower.finish()})
      photos.insert(photos.end(), r.photos.begin(), r.photos.end());
    for (std::size_t i = 0; i < photos.size(); ++i)
      cf::fuzz::require(photos[i].id.index == i && (i == 0 || photos[i - 1].time <= photos[i].time),
                        "photos in time order, whenever they come");
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static cf::fuzz::InputFile file("uav.rawlog");
  const auto& path = file.put(data, size);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    const cf::UavRecording r = cf::readRecording(path);
    using cf::fuzz::require;
    for (std::size_t i = 0; i < r.photos.size(); ++i) {
      const cf::ImageFrame& p = r.photos[i];
      require(p.id.index == i && (i == 0 || r.photos[i - 1].time <= p.time),
              "photos in time order");
      require(p.name.find('/') == std::string::npos && !p.name.empty(), "base names");
      require(p.file.string().find("/../") == std::string::npos, "files in the folder of images");
      const cf::CameraModel& c = p.camera;
      require(c.fx <= 0 || (c.fy > 0 && c.width > 0 && c.height > 0 &&
                            std::isfinite(c.fx + c.fy + c.cx + c.cy + c.k1 + c.k2 + c.p1 + c.p2 +
                                          c.k3 + c.focal_sigma + c.k1_sigma + c.k2_sigma)),
              "a calibration is whole and finite");
      require(!p.attitude ||
                  std::isfinite(p.attitude->yaw_deg + p.attitude->pitch_deg + p.attitude->roll_deg),
              "finite attitudes");
      require(!p.height_above_ground_m || std::isfinite(*p.height_above_ground_m),
              "finite heights above ground");
    }
    for (const cf::GnssFix& fix : r.fixes) {
      require(std::abs(fix.latitude_deg) <= 90 && std::abs(fix.longitude_deg) <= 180 &&
                  std::abs(fix.height_m) < 1e6,
              "places on Earth");
      require(fix.sigma_enu_m.allFinite() && fix.sigma_enu_m.minCoeff() > 0, "sigmas above zero");
    }
    for (const std::string& warning : r.warnings)
      require(warning.find('\n') == std::string::npos, "warnings of one line");
  });
  followInTwoParts(file, data, size);
  return 0;
}
