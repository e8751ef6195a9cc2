// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace cf::support {

/// Builds an EXIF block (little-endian TIFF with IFD0, Exif and GPS directories) and puts it, with
/// an XMP packet, into a small JPEG.
class ExifJpeg {
 public:
  enum Directory { kMain, kExif, kGps };

  ExifJpeg& text(Directory d, std::uint16_t tag, const std::string& value) {
    return add(d, tag, 2, value.size() + 1, std::string(value.c_str(), value.size() + 1));
  }
  ExifJpeg& byte(Directory d, std::uint16_t tag, std::uint8_t value) {
    return add(d, tag, 1, 1, std::string(1, static_cast<char>(value)));
  }
  ExifJpeg& word(Directory d, std::uint16_t tag, std::uint16_t value) {
    return add(d, tag, 3, 1, little(value, 2));
  }
  ExifJpeg& rationals(Directory d, std::uint16_t tag, const std::vector<double>& values,
                      std::uint32_t denominator) {
    std::string bytes;
    for (const double v : values)
      bytes +=
          little(static_cast<std::uint32_t>(v * denominator + 0.5), 4) + little(denominator, 4);
    return add(d, tag, 5, values.size(), bytes);
  }
  ExifJpeg& xmp(const std::string& description_attributes) {
    xmp_ =
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/"
        "22-rdf-syntax-ns#\"><rdf:Description rdf:about=\"\" xmlns:drone-dji=\"http://www.dji."
        "com/drone-dji/1.0/\" " +
        description_attributes + "/></rdf:RDF></x:xmpmeta>";
    return *this;
  }

  ExifJpeg& dateTime(const std::string& value) { return text(kExif, 0x9003, value); }
  ExifJpeg& position(double latitude_deg, double longitude_deg, double altitude_m) {
    const auto dms = [](double a) {
      a = a < 0 ? -a : a;
      const int d = static_cast<int>(a), m = static_cast<int>((a - d) * 60);
      return std::vector<double>{double(d), double(m), (a - d - m / 60.0) * 3600};
    };
    text(kGps, 1, latitude_deg < 0 ? "S" : "N").rationals(kGps, 2, dms(latitude_deg), 10000);
    text(kGps, 3, longitude_deg < 0 ? "W" : "E").rationals(kGps, 4, dms(longitude_deg), 10000);
    byte(kGps, 5, altitude_m < 0 ? 1 : 0);
    return rationals(kGps, 6, {altitude_m < 0 ? -altitude_m : altitude_m}, 1000);
  }

  /// Grey picture of that size with the tags.
  void write(const std::filesystem::path& file, int width, int height) const {
    std::vector<unsigned char> jpeg;
    cv::imencode(".jpg", cv::Mat(height, width, CV_8UC3, cv::Scalar(90, 120, 100)), jpeg);
    write(file, jpeg);
  }
  /// An encoded picture with the tags.
  void write(const std::filesystem::path& file, const std::vector<unsigned char>& jpeg) const {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream out(file, std::ios::binary);
    out << "\xFF\xD8" << segment(std::string("Exif\0\0", 6) + tiff());
    if (!xmp_.empty()) out << segment(std::string("http://ns.adobe.com/xap/1.0/") + '\0' + xmp_);
    out.write(reinterpret_cast<const char*>(jpeg.data()) + 2,
              static_cast<std::streamsize>(jpeg.size() - 2));
    if (!out) throw std::runtime_error("cannot write " + file.string());
  }

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count;
    std::string bytes;
  };
  ExifJpeg& add(Directory d, std::uint16_t tag, std::uint16_t type, std::size_t count,
                std::string bytes) {
    entries_[d].push_back({tag, type, static_cast<std::uint32_t>(count), std::move(bytes)});
    return *this;
  }
  static std::string little(std::uint32_t value, int bytes) {
    std::string out;
    for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
    return out;
  }
  static std::string segment(const std::string& payload) {
    const std::size_t n = payload.size() + 2;
    return std::string("\xFF\xE1") + static_cast<char>(n >> 8) + static_cast<char>(n & 0xFF) +
           payload;
  }
  static std::string directory(const std::vector<Entry>& entries, std::size_t offset) {
    std::string table = little(static_cast<std::uint32_t>(entries.size()), 2), data;
    const std::size_t data_at = offset + 2 + 12 * entries.size() + 4;
    for (const Entry& e : entries) {
      table += little(e.tag, 2) + little(e.type, 2) + little(e.count, 4);
      if (e.bytes.size() <= 4) {
        table += e.bytes + std::string(4 - e.bytes.size(), '\0');
      } else {
        table += little(static_cast<std::uint32_t>(data_at + data.size()), 4);
        data += e.bytes + std::string(e.bytes.size() % 2, '\0');
      }
    }
    return table + little(0, 4) + data;
  }
  std::string tiff() const {
    const std::size_t exif_at = 8 + directory(main(0, 0), 8).size();
    const std::size_t gps_at = exif_at + directory(entries_[kExif], exif_at).size();
    return "II" + little(42, 2) + little(8, 4) + directory(main(exif_at, gps_at), 8) +
           directory(entries_[kExif], exif_at) + directory(entries_[kGps], gps_at);
  }
  std::vector<Entry> main(std::size_t exif_at, std::size_t gps_at) const {
    std::vector<Entry> out = entries_[kMain];
    out.push_back({0x8769, 4, 1, little(static_cast<std::uint32_t>(exif_at), 4)});
    if (!entries_[kGps].empty())
      out.push_back({0x8825, 4, 1, little(static_cast<std::uint32_t>(gps_at), 4)});
    return out;
  }

  std::vector<Entry> entries_[3];
  std::string xmp_;
};

}  // namespace cf::support
