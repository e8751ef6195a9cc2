// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/pcd.h"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cf/base/error.h"
#include "cf/formats/atomic_file.h"

namespace cf {
namespace {

constexpr std::size_t kRecordBytes = 22;
constexpr const char* kOffsetComment = "offset_m";

template <class T>
void put(char*& out, T value) {
  std::memcpy(out, &value, sizeof value);
  out += sizeof value;
}

template <class T>
T get(const char* in) {
  T value;
  std::memcpy(&value, in, sizeof value);
  return value;
}

std::uint32_t packedRgb(const std::uint8_t* bgr) {
  return static_cast<std::uint32_t>(bgr[0]) | static_cast<std::uint32_t>(bgr[1]) << 8 |
         static_cast<std::uint32_t>(bgr[2]) << 16;
}

struct Field {
  std::string name;
  std::size_t size = 0, count = 1;
  char type = 0;
  std::size_t start = 0;  ///< byte of the record
};

struct Header {
  std::vector<Field> fields;
  std::size_t points = 0, record_bytes = 0;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();

  const Field* find(const std::string& name) const {
    for (const Field& field : fields)
      if (field.name == name) return &field;
    return nullptr;
  }
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path), in_(path, std::ios::binary) {
    if (!in_) fail("no such file or no permission");
  }

  Tile read() {
    const Header header = readHeader();
    const Field* xyz[3] = {required(header, "x"), required(header, "y"), required(header, "z")};
    const Field* rgb = optional(header, "rgb", 4);
    const Field* confidence = optional(header, "confidence", 4);
    const Field* views = optional(header, "views", 2);

    std::vector<char> data(header.points * header.record_bytes);
    in_.read(data.data(), static_cast<std::streamsize>(data.size()));
    if (static_cast<std::size_t>(in_.gcount()) != data.size())
      fail(fmt::format("cut short: {} of {} bytes of points", in_.gcount(), data.size()));

    Tile tile;
    tile.offset_m = header.offset_m;
    tile.points.resize(header.points);
    const char* record = data.data();
    for (TilePoint& point : tile.points) {
      for (int k = 0; k < 3; ++k) point.position_m[k] = get<float>(record + xyz[k]->start);
      if (rgb)
        for (int k = 0; k < 3; ++k) point.bgr[k] = get<std::uint8_t>(record + rgb->start + k);
      if (confidence) point.confidence = get<float>(record + confidence->start);
      if (views) point.views = get<std::uint16_t>(record + views->start);
      record += header.record_bytes;
    }
    return tile;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw RunError(path_.string() + ": cannot be read: " + what);
  }

  const Field* required(const Header& header, const char* name) const {
    const Field* field = header.find(name);
    if (!field || field->type != 'F' || field->size != 4)
      fail(fmt::format("no 4-byte float field \"{}\"", name));
    return field;
  }

  const Field* optional(const Header& header, const char* name, std::size_t size) const {
    const Field* field = header.find(name);
    if (field && field->size != size) fail(fmt::format("field \"{}\" is not {} bytes", name, size));
    return field;
  }

  Header readHeader() {
    Header header;
    std::optional<std::size_t> points;
    std::string line;
    while (std::getline(in_, line)) {
      std::istringstream words(line);
      std::string key;
      if (!(words >> key)) continue;
      if (key == "#") {
        std::string word;
        if (words >> word && word == kOffsetComment)
          words >> header.offset_m.x() >> header.offset_m.y() >> header.offset_m.z();
      } else if (key == "FIELDS") {
        for (std::string name; words >> name;) header.fields.push_back({name});
      } else if (key == "SIZE") {
        for (Field& field : header.fields) words >> field.size;
      } else if (key == "TYPE") {
        for (Field& field : header.fields) words >> field.type;
      } else if (key == "COUNT") {
        for (Field& field : header.fields) words >> field.count;
      } else if (key == "POINTS") {
        std::size_t n = 0;
        if (words >> n) points = n;
      } else if (key == "DATA") {
        std::string encoding;
        words >> encoding;
        if (encoding != "binary") fail("DATA is \"" + encoding + "\", only binary is read");
        if (!points || header.fields.empty()) fail("header without FIELDS or POINTS");
        header.points = *points;
        checkSizes(header);
        return header;
      }
      if (words.fail() && !words.eof()) fail("header line \"" + line + "\" not understood");
    }
    fail("not a PCD file: no DATA line");
  }

  void checkSizes(Header& header) {
    for (Field& field : header.fields) {
      if (field.size == 0 || field.size > 8 || field.count == 0 || field.count > 65536)
        fail("field \"" + field.name + "\" has no sensible SIZE or COUNT");
      field.start = header.record_bytes;
      header.record_bytes += field.size * field.count;
    }
    const auto rest = std::filesystem::file_size(path_) - static_cast<std::size_t>(in_.tellg());
    if (header.points > rest / header.record_bytes)
      fail(fmt::format("cut short: {} points of {} bytes, {} bytes left", header.points,
                       header.record_bytes, rest));
  }

  std::filesystem::path path_;
  std::ifstream in_;
};

}  // namespace

void writePcd(const std::filesystem::path& path, const Tile& tile) {
  const std::string header = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\n"
      "# {} {} {} {}\n"
      "VERSION 0.7\n"
      "FIELDS x y z rgb confidence views\n"
      "SIZE 4 4 4 4 4 2\n"
      "TYPE F F F F F U\n"
      "COUNT 1 1 1 1 1 1\n"
      "WIDTH {}\n"
      "HEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\n"
      "POINTS {}\n"
      "DATA binary\n",
      kOffsetComment, tile.offset_m.x(), tile.offset_m.y(), tile.offset_m.z(), tile.points.size(),
      tile.points.size());
  std::vector<char> data(tile.points.size() * kRecordBytes);
  char* out = data.data();
  for (const TilePoint& point : tile.points) {
    for (int k = 0; k < 3; ++k) put(out, point.position_m[k]);
    put(out, packedRgb(point.bgr));
    put(out, point.confidence);
    put(out, point.views);
  }
  AtomicFile file(path);
  file.write(header);
  if (!data.empty()) file.write(data.data(), data.size());
  file.commit();
}

Tile readPcd(const std::filesystem::path& path) { return Reader(path).read(); }

}  // namespace cf
