// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/formats/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr std::size_t kBufferBytes = 1 << 16;
constexpr char kHeaderStart[] = "ply\nformat binary_little_endian 1.0\nelement vertex ";
constexpr char kHeaderEnd[] =
    "property float x\nproperty float y\nproperty float z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
/// The count and a comment that fills up to a fixed width, so that it can be patched in place.
std::string countText(std::uint64_t count) {
  const std::string digits = std::to_string(count);
  return digits + "\ncomment ClusterFusion " + std::string(20 - digits.size(), '.') + "\n";
}

constexpr std::size_t kBlockVertices = 4096;

template <class T>
double binaryNumber(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<double>(value);
}

/// Integer colours are 0..255, floating ones 0..1; what is no number is black.
std::uint8_t colourOf(double value, bool floating) {
  const double level = std::round(floating ? 255 * value : value);
  return level > 0 ? static_cast<std::uint8_t>(std::min(level, 255.)) : std::uint8_t{0};
}

}  // namespace

PlyWriter::PlyWriter(const std::filesystem::path& path) : file_(path) {
  const std::string start = kHeaderStart;
  count_offset_ = start.size();
  file_.write(start + countText(0) + kHeaderEnd);
}

void PlyWriter::add(const Eigen::Vector3f& position_m, const std::array<std::uint8_t, 3>& rgb) {
  char record[15];
  std::memcpy(record, position_m.data(), 12);
  std::memcpy(record + 12, rgb.data(), 3);
  buffer_.append(record, sizeof(record));
  if (buffer_.size() >= kBufferBytes) writeBuffer();
  ++count_;
}

void PlyWriter::writeBuffer() {
  file_.write(buffer_);
  buffer_.clear();
}

void PlyWriter::close() {
  writeBuffer();
  file_.overwrite(count_offset_, countText(count_));
  file_.commit();
}

PlyReader::PlyReader(const std::filesystem::path& path) : path_(path), buffer_(1 << 20) {
  in_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  in_.open(path, std::ios::binary);
  if (!in_ || std::filesystem::is_directory(path)) fail("cannot be read");
  const std::vector<Element> elements = readHeader();
  const auto vertex = std::find_if(elements.begin(), elements.end(),
                                   [](const Element& e) { return e.name == "vertex"; });
  if (vertex == elements.end()) fail("has no vertex element");
  const auto has = [&](Role role) {
    return std::any_of(vertex->properties.begin(), vertex->properties.end(),
                       [&](const Property& p) { return p.role == role && !p.list; });
  };
  if (!has(Role::kX) || !has(Role::kY) || !has(Role::kZ)) fail("its vertices have no x, y, z");
  coloured_ = has(Role::kRed) && has(Role::kGreen) && has(Role::kBlue);
  count_ = vertex->count;
  vertex_ = vertex->properties;
  for (auto e = elements.begin(); e != vertex; ++e)
    for (std::uint64_t i = 0; i < e->count && !e->properties.empty(); ++i)
      readRecord(e->properties, nullptr);
  const auto isList = [](const Property& p) { return p.list; };
  if (ascii_ || std::any_of(vertex_.begin(), vertex_.end(), isList)) return;
  for (const Property& property : vertex_) vertex_bytes_ += bytesOf(property.type);
}

void PlyReader::fail(const std::string& what) const {
  throw RunError(path_.string() + ": " + what);
}

PlyReader::Type PlyReader::typeOf(const std::string& name) const {
  static const std::vector<std::pair<std::string, Type>> kTypes = {
      {"char", Type::kInt8},     {"int8", Type::kInt8},     {"uchar", Type::kUint8},
      {"uint8", Type::kUint8},   {"short", Type::kInt16},   {"int16", Type::kInt16},
      {"ushort", Type::kUint16}, {"uint16", Type::kUint16}, {"int", Type::kInt32},
      {"int32", Type::kInt32},   {"uint", Type::kUint32},   {"uint32", Type::kUint32},
      {"float", Type::kFloat},   {"float32", Type::kFloat}, {"double", Type::kDouble},
      {"float64", Type::kDouble}};
  for (const auto& [known, type] : kTypes)
    if (known == name) return type;
  fail("PLY header: unknown type '" + name + "'");
}

std::vector<PlyReader::Element> PlyReader::readHeader() {
  static const std::vector<std::pair<std::string, Role>> kRoles = {
      {"x", Role::kX},     {"y", Role::kY},         {"z", Role::kZ},
      {"red", Role::kRed}, {"green", Role::kGreen}, {"blue", Role::kBlue},
      {"r", Role::kRed},   {"g", Role::kGreen},     {"b", Role::kBlue}};
  std::vector<Element> elements;
  std::string line;
  bool format_known = false;
  for (bool first = true; std::getline(in_, line); first = false) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream words(line);
    std::string keyword, word, name;
    words >> keyword;
    if (first) {
      if (line != "ply") fail("is not a PLY file");
    } else if (keyword == "format") {
      words >> word;
      if (word != "ascii" && word != "binary_little_endian")
        fail("PLY format '" + word + "' is not read, ascii and binary_little_endian are");
      ascii_ = word == "ascii";
      format_known = true;
    } else if (keyword == "element") {
      Element element;
      words >> element.name >> element.count;
      if (!words) fail("PLY header: '" + line + "' is not understood");
      elements.push_back(element);
    } else if (keyword == "property") {
      if (elements.empty()) fail("PLY header: '" + line + "' belongs to no element");
      Property property;
      words >> word;
      property.list = word == "list";
      if (property.list) {
        words >> word;
        property.count_type = typeOf(word);
        words >> word;
      }
      property.type = typeOf(word);
      words >> name;
      for (const auto& [known, role] : kRoles)
        if (known == name) property.role = role;
      elements.back().properties.push_back(property);
    } else if (keyword == "end_header") {
      if (!format_known) fail("PLY header: has no format line");
      return elements;
    }
  }
  fail("PLY header: has no end");
}

std::size_t PlyReader::bytesOf(Type type) {
  switch (type) {
    case Type::kInt8:
    case Type::kUint8:
      return 1;
    case Type::kInt16:
    case Type::kUint16:
      return 2;
    case Type::kInt32:
    case Type::kUint32:
    case Type::kFloat:
      return 4;
    case Type::kDouble:
      return 8;
  }
  return 0;
}

double PlyReader::numberOf(Type type, const char* bytes) {
  switch (type) {
    case Type::kInt8:
      return binaryNumber<std::int8_t>(bytes);
    case Type::kUint8:
      return binaryNumber<std::uint8_t>(bytes);
    case Type::kInt16:
      return binaryNumber<std::int16_t>(bytes);
    case Type::kUint16:
      return binaryNumber<std::uint16_t>(bytes);
    case Type::kInt32:
      return binaryNumber<std::int32_t>(bytes);
    case Type::kUint32:
      return binaryNumber<std::uint32_t>(bytes);
    case Type::kFloat:
      return binaryNumber<float>(bytes);
    case Type::kDouble:
      return binaryNumber<double>(bytes);
  }
  return 0;
}

double PlyReader::readNumber(Type type) {
  if (ascii_) {
    double value = 0;
    in_ >> value;
    return value;
  }
  char bytes[8] = {};
  in_.read(bytes, static_cast<std::streamsize>(bytesOf(type)));
  return numberOf(type, bytes);
}

void PlyReader::assign(const Property& property, double value, PlyPoint& point) {
  const bool floating = property.type == Type::kFloat || property.type == Type::kDouble;
  switch (property.role) {
    case Role::kX:
      point.position_m.x() = value;
      break;
    case Role::kY:
      point.position_m.y() = value;
      break;
    case Role::kZ:
      point.position_m.z() = value;
      break;
    case Role::kRed:
      point.rgb[0] = colourOf(value, floating);
      break;
    case Role::kGreen:
      point.rgb[1] = colourOf(value, floating);
      break;
    case Role::kBlue:
      point.rgb[2] = colourOf(value, floating);
      break;
    case Role::kOther:
      break;
  }
}

void PlyReader::readRecord(const std::vector<Property>& properties, PlyPoint* point) {
  for (const Property& property : properties) {
    if (property.list) {
      const double length = readNumber(property.count_type);
      for (double i = 0; i < length && in_; ++i) readNumber(property.type);
      continue;
    }
    const double value = readNumber(property.type);
    if (point) assign(property, value, *point);
  }
  if (!in_) fail("ends or is unreadable before its last vertex");
}

/// The next vertex of fixed size.
const char* PlyReader::nextBytes() {
  if (block_at_ == block_.size()) {
    const std::uint64_t wanted = std::min<std::uint64_t>(kBlockVertices, count_ - read_);
    block_.resize(static_cast<std::size_t>(wanted) * vertex_bytes_);
    in_.read(block_.data(), static_cast<std::streamsize>(block_.size()));
    block_.resize(static_cast<std::size_t>(in_.gcount()) / vertex_bytes_ * vertex_bytes_);
    if (block_.empty()) fail("ends or is unreadable before its last vertex");
    block_at_ = 0;
  }
  const char* const bytes = block_.data() + block_at_;
  block_at_ += vertex_bytes_;
  return bytes;
}

bool PlyReader::next(PlyPoint& point) {
  if (read_ == count_) return false;
  if (vertex_bytes_ > 0) {
    const char* bytes = nextBytes();
    for (const Property& property : vertex_) {
      if (property.role != Role::kOther) assign(property, numberOf(property.type, bytes), point);
      bytes += bytesOf(property.type);
    }
  } else {
    readRecord(vertex_, &point);
  }
  ++read_;
  return true;
}

bool PlyReader::skip() {
  if (read_ == count_) return false;
  if (vertex_bytes_ > 0)
    nextBytes();
  else
    readRecord(vertex_, nullptr);
  ++read_;
  return true;
}

std::vector<PlyPoint> readPly(const std::filesystem::path& path) {
  PlyReader reader(path);
  std::vector<PlyPoint> points;
  PlyPoint point;
  while (reader.next(point)) points.push_back(point);
  return points;
}

}  // namespace cf
