// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "cf/formats/atomic_file.h"

namespace cf {

struct PlyPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::array<std::uint8_t, 3> rgb = {0, 0, 0};
};

/// Writes coloured points as they come: binary little endian; float x y z, uchar red green blue.
/// The file appears under its name at close(), which must be called; its count is patched in then.
class PlyWriter {
 public:
  explicit PlyWriter(const std::filesystem::path& path);
  void add(const Eigen::Vector3f& position_m, const std::array<std::uint8_t, 3>& rgb);
  void close();
  std::uint64_t count() const { return count_; }

 private:
  void writeBuffer();

  AtomicFile file_;
  std::uint64_t count_ = 0;
  std::uint64_t count_offset_ = 0;
  std::string buffer_;  ///< points on their way
};

/// Reads the vertices of a PLY file one by one: ASCII or binary little endian, properties in any
/// order and of any type, further properties, lists and elements skipped, colours optional.
/// Throws RunError naming the file on anything else.
class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& path);
  std::uint64_t count() const { return count_; }  ///< of vertices, as the header says
  bool coloured() const { return coloured_; }
  /// False after the last vertex.
  bool next(PlyPoint& point);
  /// Passes one over: false after the last vertex.
  bool skip();

 private:
  enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
  enum class Role { kOther, kX, kY, kZ, kRed, kGreen, kBlue };
  struct Property {
    Role role = Role::kOther;
    Type type = Type::kFloat;
    bool list = false;
    Type count_type = Type::kUint8;
  };
  struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
  };

  [[noreturn]] void fail(const std::string& what) const;
  std::vector<Element> readHeader();
  Type typeOf(const std::string& name) const;
  static std::size_t bytesOf(Type type);
  static double numberOf(Type type, const char* bytes);
  static void assign(const Property& property, double value, PlyPoint& point);
  double readNumber(Type type);
  void readRecord(const std::vector<Property>& properties, PlyPoint* point);
  const char* nextBytes();

  std::filesystem::path path_;
  std::vector<char> buffer_;
  std::ifstream in_;
  bool ascii_ = false;
  bool coloured_ = false;
  std::uint64_t count_ = 0;
  std::uint64_t read_ = 0;
  std::vector<Property> vertex_;
  std::size_t vertex_bytes_ = 0;  ///< 0: of no fixed size
  std::vector<char> block_;       ///< vertices of fixed size read ahead
  std::size_t block_at_ = 0;
};

/// All points at once.
std::vector<PlyPoint> readPly(const std::filesystem::path& path);

}  // namespace cf
