// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Dense matching of a simulated flight against its truth:
//   bench_dense SIMULATION [--run RUN] [--every N] [--draw PREFIX] [--repeat N]
//               [--megapixels M] [--matcher sgm] [--partners N]
// SIMULATION is a folder of cf-simulate. With --run the poses and cameras are those that cf-run
// found, otherwise the true ones. Every N-th photo is matched with its partners, on one thread.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <opencv2/core/utility.hpp>

#include "dense_figures.h"
#include "truth_flight.h"

namespace {

using namespace cf;
using namespace cf::bench;

constexpr int kPhotoStride = 12;  // px, of the samples for completeness

double cpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Ground that another photo sees, by sampled pixels of the photo, and how much of it one of the
/// frames has within 3 d.
void addCompleteness(const TruthFlight& flight, const TruePhoto& photo,
                     const std::vector<DepthFrame>& frames,
                     const std::vector<ComparedFrame>& compared, double cpu_s,
                     DenseFigures& figures) {
  std::size_t seen = 0, complete = 0;
  for (int y = kPhotoStride / 2; y < photo.camera.height; y += kPhotoStride) {
    for (int x = kPhotoStride / 2; x < photo.camera.width; x += kPhotoStride) {
      const Eigen::Vector2d pixel(x, y);
      const double z = flight.depth(photo).at(pixel);
      if (z <= 0) continue;
      const Eigen::Vector3d p =
          photo.T_world_cam * (z * photo.camera.undistort(pixel).homogeneous());
      bool other = false;
      for (const TruePhoto& q : flight.photos()) {
        other = other || (q.name != photo.name && flight.sees(q, p));
      }
      if (!other) continue;
      ++seen;
      bool found = false;
      for (std::size_t k = 0; k < frames.size() && !found; ++k) {
        const RectifiedView& view = frames[k].reference_view;
        const Eigen::Vector3d ray =
            view.R_rect_cam * frames[k].reference_camera.undistort(pixel).homogeneous();
        const int u = static_cast<int>(std::lround(view.f * ray.x() / ray.z() + view.cx));
        const int v = static_cast<int>(std::lround(view.f * ray.y() / ray.z() + view.cy));
        if (u < 0 || v < 0 || u >= view.width || v >= view.height) continue;
        const double estimate = compared[k].estimate.at<float>(v, u);
        found = estimate > 0 && std::abs(estimate - z) <= 3 * z / view.f;
      }
      complete += found;
    }
  }
  figures.addPhoto(seen, complete, cpu_s);
}

struct Settings {
  DensifyOptions options;
  int every = 6, repeat = 1;
  std::string draw;
};

void run(const TruthFlight& flight, const Settings& settings) {
  const DensifyOptions& options = settings.options;
  DenseFigures figures;
  const std::vector<DenseView> views = flight.views();
  const auto every = static_cast<std::size_t>(settings.every);
  for (std::size_t k = every / 2; k < views.size(); k += every) {
    const TruePhoto& photo = flight.photo(views[k].id);
    const cv::Mat image = decoded(photo, 2 * options.megapixels);
    std::vector<DepthFrame> frames;
    std::vector<ComparedFrame> compared;
    double photo_s = 0;
    for (const FrameId id : choosePartners(views[k], views, options)) {
      const TruePhoto& partner = flight.photo(id);
      const cv::Mat partner_image = decoded(partner, 2 * options.megapixels);
      double start = cpuSeconds();
      const auto frame = matchPair(views[k], image, partner.view, partner_image, options);
      double cpu_s = cpuSeconds() - start;
      for (int repeat = 1; repeat < settings.repeat; ++repeat) {
        start = cpuSeconds();
        (void)matchPair(views[k], image, partner.view, partner_image, options);
        cpu_s = std::min(cpu_s, cpuSeconds() - start);
      }
      photo_s += cpu_s;
      figures.addPair(cpu_s, frame.ok(),
                      frame.ok() ? 1e-6 * static_cast<double>(frame->disparity.total()) : 0);
      if (!frame) {
        fmt::print("{} - {}: {} {}\n", photo.name, partner.name, frame.failure().code,
                   frame.failure().detail);
        continue;
      }
      frames.push_back(*frame);
      compared.push_back(compareFrame(flight, *frame));
      figures.add(compared.back(), *frame);
      if (!settings.draw.empty()) {
        drawFrame(fmt::format("{}{}_{}", settings.draw, k, frames.size()), compared.back(), *frame);
      }
    }
    addCompleteness(flight, photo, frames, compared, photo_s, figures);
  }
  fmt::print("{}", figures.text());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Dense matching against the truth of a simulated flight");
  std::string simulation, poses;
  Settings settings;
  DensifyOptions& options = settings.options;
  app.add_option("SIMULATION", simulation, "folder written by cf-simulate")->required();
  app.add_option("--run", poses, "poses and cameras of this result of cf-run");
  app.add_option("--every", settings.every, "match every N-th photo");
  app.add_option("--draw", settings.draw, "write pictures whose paths begin with this");
  app.add_option("--repeat", settings.repeat, "match each pair N times, to time it");
  app.add_option("--megapixels", options.megapixels);
  app.add_option("--matcher", options.matcher);
  app.add_option("--partners", options.partners);
  app.add_option("--min-confidence", options.min_confidence);
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  try {
    run(TruthFlight(simulation, poses), settings);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
