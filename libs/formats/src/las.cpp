// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/las.h"

#include <fmt/format.h>

#include <algorithm>
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
constexpr char kOnlyReturn = 1 | 1 << 4;  ///< return 1 of 1
constexpr std::uint16_t kTo16Bits = 257;  ///< 255 becomes 65535
constexpr std::size_t kBufferBytes = 1 << 16;

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
  std::int32_t xyz[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double stored = (point.position_m[axis] - offset_m_[axis]) / kScale_m;
    if (!(std::abs(stored) < std::numeric_limits<std::int32_t>::max()))
      throw RunError(fmt::format("{}: cannot be written: a point at {}, {}, {} is too far away",
                                 file_.path().string(), point.position_m.x(), point.position_m.y(),
                                 point.position_m.z()));
    xyz[axis] = static_cast<std::int32_t>(stored + (stored < 0 ? -0.5 : 0.5));  // rounds
    low_[axis] = std::min(low_[axis], xyz[axis]);
    high_[axis] = std::max(high_[axis], xyz[axis]);
  }
  // Zero: intensity, flags and channel, classification (created, never classified), scan angle,
  // point source and GPS time.
  char record[kPointBytes] = {};
  std::memcpy(record, xyz, sizeof(xyz));
  record[14] = kOnlyReturn;
  record[17] = static_cast<char>(point.user_data);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::uint16_t>(point.rgb[c] * kTo16Bits);
    std::memcpy(record + 30 + 2 * c, &channel, sizeof(channel));
  }
  buffer_.append(record, kPointBytes);
  if (buffer_.size() >= kBufferBytes) writeBuffer();
  ++count_;
}

void LasWriter::writeBuffer() {
  file_.write(buffer_);
  buffer_.clear();
}

void LasWriter::close() {
  writeBuffer();
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
