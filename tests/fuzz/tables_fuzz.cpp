// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Readers of what a run has written: TUM, CSV, covariances, PLY. The first byte chooses.
#include "cf/formats/csv.h"
#include "cf/formats/ply.h"
#include "cf/formats/pose_covariance_csv.h"
#include "cf/formats/tum.h"
#include "fuzz/fuzz_target.h"
#include "support/temp_folder.h"

namespace {

std::string covariances() {
  const cf::support::TempFolder folder;
  cf::writePoseCovariances(folder / "a.csv", {{"DJI_0001.JPG", cf::kNsPerSecond, 0, {}}});
  return cf::support::fileText(folder / "a.csv");
}

}  // namespace

std::vector<std::string> cf::fuzz::seeds() {
  const std::string xyz(12, '\x41');
  return {
      "v" + covariances(),
      "t# t tx ty tz qx qy qz qw\n1466699519.000000000 1.5 -2 3 0 0 0 1\n1466699520 0 0 0 .5 .5 .5 "
      ".5\n",
      "cimage,t,status\nDJI_0001.JPG,1466699519.0,posed\n\"a \"\"b\"\", c\",2,\"un\nposed\"\r\n",
      "pply\nformat ascii 1.0\ncomment c\nelement face 1\nproperty list uchar int vertex_indices\n"
      "element vertex 2\nproperty float x\nproperty double y\nproperty short z\nproperty uchar "
      "red\n"
      "property uchar green\nproperty uchar blue\nend_header\n3 0 1 2\n1 2 3 4 5 6\n7 8 9 10 11 "
      "12\n",
      "pply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float "
      "y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "end_header\n" +
          xyz + "rgb" + xyz + "RGB"};
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static cf::fuzz::InputFile file("table");
  const auto& path = file.put(data + 1, size - 1);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    switch (data[0]) {
      case 't':
        for (const cf::TimedPose& pose : cf::readTum(path))
          cf::fuzz::require(pose.T_world_cam.matrix().allFinite(), "finite poses");
        break;
      case 'c':
        cf::CsvTable(path).rows();
        break;
      case 'v':
        cf::readPoseCovariances(path);
        break;
      default:
        cf::readPly(path);
    }
  });
  return 0;
}
