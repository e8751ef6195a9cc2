// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A whole run against the time that merely decoding its photos takes:
//   bench_run CONFIG OUT [-s section.key=value]...
// Runs the flight of CONFIG into OUT (an earlier result there is replaced), then decodes the same
// photos at their full size on one thread, and prints both and their ratio, which depends on the
// machine much less than seconds do.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "cf/base/stopwatch.h"
#include "cf/config/config.h"
#include "cf/formats/jpeg.h"
#include "cf/pipeline/flight_run.h"
#include "cf/rawlog/rawlog_reader.h"

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

std::vector<fs::path> photosOf(const cf::Config& config, const cf::RunOptions& options) {
  std::vector<fs::path> files;
  for (const cf::UavOptions& uav : options.uavs)
    for (const cf::ImageFrame& photo :
         cf::readRecording(config.resolve(uav.rawlog), {uav.image_label, uav.gnss_label}).photos)
      files.push_back(photo.file);
  return files;
}

Bytes bytesOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
}

struct Decoding {
  double opencv_s = 0;   ///< cv::imdecode
  double library_s = 0;  ///< libjpeg-turbo, as our own code calls it; JPEGs alone
  double megapixels = 0;
};

Decoding decodeAll(const std::vector<fs::path>& files) {
  cv::setNumThreads(1);
  Decoding sum;
  for (const fs::path& file : files) {
    const Bytes bytes = bytesOf(file);
    if (bytes.empty()) continue;
    double start = cf::wallSeconds();
    const cv::Mat image = cv::imdecode(bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    sum.opencv_s += cf::wallSeconds() - start;
    sum.megapixels += 1e-6 * static_cast<double>(image.total());
    start = cf::wallSeconds();
    cf::decodeJpeg(bytes.data(), bytes.size());
    sum.library_s += cf::wallSeconds() - start;
  }
  return sum;
}

void bench(const fs::path& ini, const fs::path& out, const std::vector<std::string>& assignments) {
  cf::Config config = cf::Config::fromFile(ini);
  for (const std::string& assignment : assignments) config.override(assignment);
  cf::FlightRunRequest request;
  request.outdir = out;
  request.overwrite = true;
  request.version = "bench";
  const double cpu_start = cf::processCpuSeconds();
  const cf::RunRecord record = cf::runFlight(config, request);
  const double cpu_s = cf::processCpuSeconds() - cpu_start;
  cf::Config again = cf::Config::fromFile(ini);
  for (const std::string& assignment : assignments) again.override(assignment);
  const std::vector<fs::path> files = photosOf(config, cf::loadRunOptions(again));
  const Decoding decoding = decodeAll(files);
  const auto photos = static_cast<double>(files.size());
  fmt::print("photos        {} of {:.1f} MP\n", files.size(), decoding.megapixels / photos);
  fmt::print("run           {:.1f} s wall, {:.1f} s CPU; {:.2f} and {:.2f} s a photo\n",
             record.wall_s, cpu_s, record.wall_s / photos, cpu_s / photos);
  fmt::print("peak memory   {:.0f} MB\n", record.peak_rss_mb);
  fmt::print("decoding      {:.1f} s on one thread (OpenCV), {:.1f} s (libjpeg-turbo)\n",
             decoding.opencv_s, decoding.library_s);
  fmt::print("ratio         {:.2f} (OpenCV), {:.2f} (libjpeg-turbo)\n",
             record.wall_s / decoding.opencv_s, record.wall_s / decoding.library_s);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("A whole run against decoding its photos on one thread");
  std::string config, out;
  std::vector<std::string> assignments;
  app.add_option("CONFIG", config, "configuration of cf-run")->required();
  app.add_option("OUT", out, "folder for the result")->required();
  app.add_option("-s,--set", assignments, "section.key=value");
  CLI11_PARSE(app, argc, argv);
  try {
    bench(config, out, assignments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
