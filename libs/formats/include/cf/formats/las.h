// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "cf/formats/atomic_file.h"

namespace cf {

struct LasPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< easting, northing, height
  std::array<std::uint8_t, 3> rgb = {0, 0, 0};
  std::uint8_t user_data = 0;
};

/// Writes points as they come in the form of LAS 1.4 (ASPRS, revision 15): point data record
/// format 7, coordinates to a millimetre, colours spread to 16 bits, each point the only return of
/// its pulse, never classified (class 0), GPS time 0 because no single time belongs to a fused
/// point. The day of creation is left 0, so that the same run gives the same bytes.
///
/// Only the header's figures and a few points are in memory; the file appears under its name at
/// close(), which must be called. Throws RunError naming the file.
class LasWriter {
 public:
  static constexpr double kScale_m = 0.001;

  /// Coordinates are stored relative to `offset_m` (rounded to whole metres), within 2,147 km of
  /// it. `wkt`: the reference system; empty: the file says of none.
  LasWriter(const std::filesystem::path& path, const Eigen::Vector3d& offset_m,
            const std::string& wkt);
  void add(const LasPoint& point);
  void close();
  std::uint64_t count() const { return count_; }

 private:
  std::string header() const;
  void writeBuffer();

  AtomicFile file_;
  Eigen::Vector3d offset_m_;
  std::string records_;  ///< variable length records between header and points
  std::uint32_t record_count_ = 0;
  Eigen::Array<std::int32_t, 3, 1> low_, high_;  ///< stored coordinates
  std::uint64_t count_ = 0;
  std::string buffer_;  ///< points on their way
};

}  // namespace cf
