// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/las.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr std::uint16_t kHeaderBytes = 375;
constexpr std::uint16_t kPointBytes = 36;
constexpr std::uint8_t kPointFormat = 7;
constexpr std::uint16_t kWktEncoding = 1 << 4;  ///< global encoding: the CRS is WKT
constexpr std::uint16_t kWktRecord = 2112;
constexpr std::uint8_t kOnlyReturn = 1 | 1 << 4;  ///< return 1 of 1
constexpr std::uint16_t kTo16Bits = 257;          ///< 255 becomes 65535

/// Appends in the file's order of bytes, little endian, which is ours.
template <class T>
void put(std::string& out, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  out.append(bytes, sizeof(T));
}

/// A text field of fixed width, filled up with zeros.
void putText(std::string& out, std::string text, std::size_t width) {
  text.resize(width, '\0');
  out += text;
}

std::string wktRecord(const std::string& wkt) {
  std::string out;
  put(out, std::uint16_t{0});
  putText(out, "LASF_Projection", 16);
  put(out, kWktRecord);
  put(out, static_cast<std::uint16_t>(wkt.size() + 1));
  putText(out, "OGC Coordinate System WKT", 32);
  return out + wkt + '\0';
}

}  // namespace

LasWriter::LasWriter(const std::filesystem::path& path, const Eigen::Vector3d& offset_m,
                     const std::string& wkt)
    : file_(path),
      offset_m_(offset_m.array().round()),
      low_(decltype(low_)::Constant(std::numeric_limits<std::int32_t>::max())),
      high_(decltype(high_)::Constant(std::numeric_limits<std::int32_t>::min())) {
  if (wkt.size() >= std::numeric_limits<std::uint16_t>::max())
    throw RunError(path.string() + ": cannot be written: its reference system is too long a text");
  if (!wkt.empty()) {
    records_ = wktRecord(wkt);
    record_count_ = 1;
  }
  file_.write(header() + records_);
}

void LasWriter::add(const LasPoint& point) {
  const Eigen::Array3d stored = ((point.position_m - offset_m_).array() / kScale_m).round();
  if (!(stored.abs() <= std::numeric_limits<std::int32_t>::max()).all())
    throw RunError(fmt::format("{}: cannot be written: a point at {}, {}, {} is too far away",
                               file_.path().string(), point.position_m.x(), point.position_m.y(),
                               point.position_m.z()));
  const Eigen::Array<std::int32_t, 3, 1> xyz = stored.cast<std::int32_t>();
  low_ = low_.min(xyz);
  high_ = high_.max(xyz);
  std::string record;
  record.reserve(kPointBytes);
  for (int axis = 0; axis < 3; ++axis) put(record, xyz[axis]);
  put(record, std::uint16_t{0});  // intensity
  put(record, kOnlyReturn);
  put(record, std::uint8_t{0});  // flags, scanner channel, scan direction, edge of flight line
  put(record, std::uint8_t{0});  // classification: created, never classified
  put(record, point.user_data);
  put(record, std::int16_t{0});   // scan angle
  put(record, std::uint16_t{0});  // point source
  put(record, 0.0);               // GPS time
  for (const std::uint8_t channel : point.rgb)
    put(record, static_cast<std::uint16_t>(channel * kTo16Bits));
  file_.write(record);
  ++count_;
}

void LasWriter::close() {
  file_.overwrite(0, header());
  file_.commit();
}

std::string LasWriter::header() const {
  const std::size_t points_at = kHeaderBytes + records_.size();
  std::string out = "LASF";
  put(out, std::uint16_t{0});  // file source
  put(out, kWktEncoding);
  putText(out, "", 16);  // GUID
  put(out, std::uint8_t{1});
  put(out, std::uint8_t{4});
  putText(out, "OTHER", 32);  // the system: none of a scanner, a merge, an extraction…
  putText(out, "ClusterFusion", 32);
  put(out, std::uint16_t{0});  // day and year of creation
  put(out, std::uint16_t{0});
  put(out, kHeaderBytes);
  put(out, static_cast<std::uint32_t>(points_at));
  put(out, record_count_);
  put(out, kPointFormat);
  put(out, kPointBytes);
  putText(out, "", 4 + 5 * 4);  // counts of older versions: 0 for point formats from 6 on
  for (int axis = 0; axis < 3; ++axis) put(out, kScale_m);
  for (int axis = 0; axis < 3; ++axis) put(out, offset_m_[axis]);
  for (int axis = 0; axis < 3; ++axis) {
    const bool any = count_ > 0;
    put(out, any ? high_[axis] * kScale_m + offset_m_[axis] : 0.0);
    put(out, any ? low_[axis] * kScale_m + offset_m_[axis] : 0.0);
  }
  put(out, std::uint64_t{0});  // wave forms
  put(out, std::uint64_t{0});  // extended records
  put(out, std::uint32_t{0});
  put(out, count_);
  put(out, count_);  // first returns
  putText(out, "", 14 * 8);
  return out;
}

}  // namespace cf
