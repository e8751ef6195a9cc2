// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "gps_tags.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "cf/base/text.h"

namespace cf {
namespace {

/// All numbers in a text such as "(46) (50) (33.3855)", which is how GDAL writes rationals.
std::vector<double> numbersIn(const std::string& text) {
  std::string plain = text;
  for (char& c : plain)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::vector<double> values;
  for (const std::string& word : wordsOf(plain))
    if (const std::optional<double> value = numberFrom(word)) values.push_back(*value);
  return values;
}

/// Days since 1970-01-01 of a proleptic Gregorian date (H. Hinnant, "chrono-Compatible Low-Level
/// Date Algorithms", days_from_civil).
std::int64_t daysFromCivil(int year, int month, int day) {
  const std::int64_t y = month <= 2 ? year - 1 : year;
  const std::int64_t era = (y >= 0 ? y : y - 399) / 400;
  const std::int64_t year_of_era = y - era * 400;
  const std::int64_t day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const std::int64_t day_of_era =
      year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
  return era * 146097 + day_of_era - 719468;
}

std::optional<TimeNs> dateFrom(int year, int month, int day) {
  // A camera whose clock was never set writes 0000:00:00.
  if (year < 1980 || year > 2200 || month < 1 || month > 12 || day < 1 || day > 31)
    return std::nullopt;
  return daysFromCivil(year, month, day) * 86400 * kNsPerSecond;
}

/// "2016:06:23 16:31:59", also with '-' in the date.
std::optional<TimeNs> dateTimeFrom(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  if (std::sscanf(text.c_str(), "%4d%*[:-]%2d%*[:-]%2d %2d:%2d:%2d", &year, &month, &day, &hour,
                  &minute, &second) != 6)
    return std::nullopt;
  const std::optional<TimeNs> date = dateFrom(year, month, day);
  if (!date || hour < 0 || hour > 23 || minute < 0 || minute > 59 || second < 0 || second > 60)
    return std::nullopt;
  return *date + (hour * 3600 + minute * 60 + second) * kNsPerSecond;
}

/// "+05:30" in nanoseconds.
std::optional<TimeNs> offsetFrom(const std::string& text) {
  int hours = 0, minutes = 0;
  char sign = 0;
  if (text == "Z") return 0;
  if (std::sscanf(text.c_str(), "%c%2d:%2d", &sign, &hours, &minutes) != 3 ||
      (sign != '+' && sign != '-') || hours < 0 || hours > 14 || minutes < 0 || minutes > 59)
    return std::nullopt;
  return (sign == '-' ? -1 : 1) * (hours * 3600 + minutes * 60) * kNsPerSecond;
}

std::optional<TimeNs> gpsTimeFrom(const ExifItems& exif) {
  int year = 0, month = 0, day = 0;
  if (std::sscanf(item(exif, "EXIF_GPSDateStamp").c_str(), "%4d%*[:-]%2d%*[:-]%2d", &year, &month,
                  &day) != 3)
    return std::nullopt;
  const std::optional<TimeNs> date = dateFrom(year, month, day);
  const std::vector<double> hms = numbersIn(item(exif, "EXIF_GPSTimeStamp"));
  if (!date || hms.size() != 3 || hms[0] < 0 || hms[0] >= 24 || hms[1] < 0 || hms[1] >= 60 ||
      hms[2] < 0 || hms[2] >= 61)
    return std::nullopt;
  const double seconds_of_day = hms[0] * 3600 + hms[1] * 60 + hms[2];
  return *date + std::llround(seconds_of_day * 1e6) * 1000;
}

/// Degrees, minutes, seconds with N, S, E or W.
std::optional<double> angleFrom(const ExifItems& exif, const std::string& name, char negative) {
  const std::vector<double> dms = numbersIn(item(exif, name));
  if (dms.empty() || dms.size() > 3) return std::nullopt;
  double degrees = 0, unit = 1;
  for (const double part : dms) {
    degrees += part / unit;
    unit *= 60;
  }
  const std::string ref = item(exif, name + "Ref");
  return !ref.empty() && ref[0] == negative ? -degrees : degrees;
}

bool isPlace(double latitude_deg, double longitude_deg) {
  // Receivers without a fix tag 0, 0.
  return std::abs(latitude_deg) <= 90 && std::abs(longitude_deg) <= 180 &&
         (latitude_deg != 0 || longitude_deg != 0);
}

bool isHeight(double height_m) { return std::abs(height_m) <= 1e5; }

std::optional<PhotoPosition> exifPosition(const ExifItems& exif) {
  const auto latitude = angleFrom(exif, "EXIF_GPSLatitude", 'S');
  const auto longitude = angleFrom(exif, "EXIF_GPSLongitude", 'W');
  if (!latitude || !longitude || !isPlace(*latitude, *longitude)) return std::nullopt;
  if (item(exif, "EXIF_GPSStatus") == "V") return std::nullopt;  // void
  PhotoPosition position;
  position.latitude_deg = *latitude;
  position.longitude_deg = *longitude;
  const std::vector<double> altitude = numbersIn(item(exif, "EXIF_GPSAltitude"));
  if (!altitude.empty() && isHeight(altitude[0])) {
    // 0: above, 1: below sea level, but drones write any datum under these. 2 and 3 (EXIF 2.32):
    // above and below the ellipsoid.
    const std::string text = item(exif, "EXIF_GPSAltitudeRef");
    const char ref = text.empty() ? '0' : text.back();
    position.height_m = ref == '1' || ref == '3' ? -altitude[0] : altitude[0];
    if (ref == '2' || ref == '3') position.datum = HeightDatum::kEllipsoid;
  }
  return position;
}

/// Standard deviations and the datum of an RTK receiver, and XMP's finer position.
void refineByXmp(const std::string& xmp, std::optional<PhotoPosition>& position) {
  const auto value = [&xmp](const char* name) { return numberFrom(xmpValue(xmp, name)); };
  const auto latitude = value("GpsLatitude");
  auto longitude = value("GpsLongitude");
  if (!longitude) longitude = value("GpsLongtitude");  // as early firmware spells it
  const auto sigma_n = value("RtkStdLat"), sigma_e = value("RtkStdLon"),
             sigma_u = value("RtkStdHgt");
  const auto isSigma = [](const std::optional<double>& s) { return s && *s > 1e-5 && *s < 1e6; };
  const bool rtk = isSigma(sigma_n) && isSigma(sigma_e) && isSigma(sigma_u);
  const auto altitude = value("AbsoluteAltitude");

  if (latitude && longitude && isPlace(*latitude, *longitude)) {
    if (!position) position.emplace();
    position->latitude_deg = *latitude;
    position->longitude_deg = *longitude;
  }
  if (!position) return;
  if (altitude && isHeight(*altitude) && (rtk || !position->height_m))
    position->height_m = *altitude;
  if (rtk) {
    position->sigma_enu_m = Eigen::Vector3d(*sigma_e, *sigma_n, *sigma_u);
    position->datum = HeightDatum::kEllipsoid;
  }
}

}  // namespace

std::string item(const ExifItems& exif, const std::string& name) {
  const auto it = exif.find(name);
  return it == exif.end() ? std::string() : trimmed(it->second);
}

double firstNumber(const ExifItems& exif, const std::string& name) {
  const std::vector<double> values = numbersIn(item(exif, name));
  return values.empty() ? 0 : values[0];
}

std::optional<PhotoPosition> positionFrom(const ExifItems& exif, const std::string& xmp) {
  std::optional<PhotoPosition> position = exifPosition(exif);
  refineByXmp(xmp, position);
  return position;
}

PhotoTime timeFrom(const ExifItems& exif) {
  PhotoTime time;
  time.gps = gpsTimeFrom(exif);
  time.camera = dateTimeFrom(item(exif, "EXIF_DateTimeOriginal"));
  if (!time.camera) return time;
  if (const auto offset = offsetFrom(item(exif, "EXIF_OffsetTimeOriginal")))
    *time.camera -= *offset;
  std::string digits = item(exif, "EXIF_SubSecTime_Original");
  if (digits.empty()) digits = item(exif, "EXIF_SubSecTimeOriginal");
  const bool valid =
      !digits.empty() && digits.size() <= 9 &&
      std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (valid) {
    digits.resize(9, '0');
    *time.camera += std::stoll(digits);
    time.sub_seconds = true;
  }
  return time;
}

}  // namespace cf
