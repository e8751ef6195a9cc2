// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ortho_shares.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cf/base/error.h"

namespace cf {
namespace {

constexpr int kLattice = OrthoSurface::kLattice;
constexpr int kToneCell = OrthoWindow::kToneCell;
/// Seams: demerit over which a photo fades, and beyond which it does not count.
constexpr float kFade = 0.008F, kFadeEnd = 4 * kFade;
constexpr float kVisible = 0.5F;
constexpr std::size_t kMostPhotos = 8;  ///< looked at for one node
constexpr float kNotAsked = -1;
constexpr float kToneFade = 0.15F;   ///< of demerit
constexpr float kToneNoise = 0.25F;  ///< of a difference of logarithms of colours

struct Ranked {
  std::size_t view = 0;
  float demerit = 0;
  float free = kNotAsked;  ///< then the photo's share
};

class Sharing {
 public:
  Sharing(const OrthoScene& scene, const OrthoGround& ground) : scene_(scene), ground_(ground) {}

  void shareCell(int column, int row) {
    const auto& cell =
        scene_.candidates[static_cast<std::size_t>(row * scene_.surface.lattice().cols + column)];
    const std::size_t count = orthoShortlist(cell);
    if (count == 0) return;
    std::vector<PhotoProjection> views;
    for (std::size_t k = 0; k < count; ++k) views.push_back(ground_.projection(cell[k].photo));
    const float top = scene_.surface.latticeTop().at<float>(row, column);
    const cv::Rect& nodes = ground_.nodes();
    const cv::Rect area = cv::Rect(column * kLattice, row * kLattice, kLattice, kLattice) & nodes;
    std::vector<Ranked> ranked;
    for (int y = area.y - nodes.y; y < area.br().y - nodes.y; ++y)
      for (int x = area.x - nodes.x; x < area.br().x - nodes.x; ++x) {
        if (!ground_.shown(x, y)) continue;
        const Eigen::Vector3d place = ground_.local(x, y);
        ranked.clear();
        std::size_t best = 0;
        for (std::size_t k = 0; k < count; ++k) {
          float d = 0;
          if (cell[k].whole) {
            d = views[k].steepness(place);
          } else {
            const auto sight = views[k].project(place);
            if (sight.border < 0) continue;
            d = demerit(sight);
          }
          if (ranked.empty() || d < ranked[best].demerit) best = ranked.size();
          ranked.push_back({k, d, kNotAsked});
        }
        const auto free = [&](const Ranked& r) {
          return ground_.free(views[r.view], place, x, y, top);
        };
        shareNode(ranked, best, free);
        for (const Ranked& r : ranked)
          if (r.free > 0)
            weights(cell[r.view].photo).at<std::uint8_t>(y, x) =
                static_cast<std::uint8_t>(std::lround(255 * r.free));
      }
  }

  /// After all cells.
  cv::Mat tones() const {
    const cv::Rect& nodes = ground_.nodes();
    cv::Mat tones(nodes.height / kToneCell, nodes.width / kToneCell, CV_32FC3, cv::Scalar::all(0));
    std::map<int, PhotoProjection> views;
    for (int y = 0; y < tones.rows; ++y)
      for (int x = 0; x < tones.cols; ++x) {
        const cv::Point node(x * kToneCell + kToneCell / 2, y * kToneCell + kToneCell / 2);
        const int chosen = chosenAt(node);
        if (chosen >= 0) tones.at<cv::Vec3f>(y, x) = toneAt(node, chosen, views);
      }
    return tones;
  }

  std::vector<OrthoShare> packed() const {
    std::vector<OrthoShare> shares;
    for (const auto& [photo, weights] : weights_) {
      OrthoShare share;
      share.photo = photo;
      share.nodes = cv::boundingRect(weights);
      if (share.nodes.empty()) continue;
      const std::vector<int> fast = {cv::IMWRITE_PNG_COMPRESSION, 1};
      if (!cv::imencode(".png", weights(share.nodes), share.weights, fast))
        throw RunError("the orthophoto's seams cannot be kept");
      share.part = partOf(photo, share.nodes, weights);
      shares.push_back(std::move(share));
    }
    return shares;
  }

 private:
  /// Leaves the shares in `free`. `best`: the one of the least demerit.
  template <class Free>
  static void shareNode(std::vector<Ranked>& ranked, std::size_t best, const Free& free) {
    if (ranked.empty()) return;
    // Mostly one photo is clearly the best and sees the place.
    const float end = ranked[best].demerit + kFadeEnd;
    const auto rivals = std::count_if(ranked.begin(), ranked.end(),
                                      [&](const Ranked& r) { return r.demerit < end; });
    ranked[best].free = free(ranked[best]);
    if (rivals == 1 && ranked[best].free >= kVisible) {
      ranked[0] = {ranked[best].view, 0, 1};
      ranked.resize(1);
      return;
    }
    std::sort(ranked.begin(), ranked.end(),
              [](const Ranked& a, const Ranked& b) { return a.demerit < b.demerit; });
    if (ranked.size() > kMostPhotos) ranked.resize(kMostPhotos);
    std::size_t first = 0;
    for (; first < ranked.size(); ++first) {
      if (ranked[first].free <= kNotAsked) ranked[first].free = free(ranked[first]);
      if (ranked[first].free >= kVisible) break;
    }
    if (first == ranked.size()) {
      // Hidden everywhere: the surface is wrong, or a gap too narrow. The freest one then.
      const std::size_t view =
          std::max_element(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
            return a.free < b.free;
          })->view;
      for (Ranked& r : ranked) r.free = r.view == view ? 1.F : 0.F;
      return;
    }
    float sum = 0;
    for (Ranked& r : ranked) {
      const float worse = r.demerit - ranked[first].demerit;
      if (worse > kFadeEnd) {
        r.free = 0;
        continue;
      }
      if (r.free <= kNotAsked) r.free = free(r);
      static const float kEnd = std::exp(-kFadeEnd / kFade);
      r.free *= std::exp(-std::max(0.F, worse) / kFade) - kEnd;
      sum += r.free;
    }
    for (Ranked& r : ranked) r.free /= sum;
  }

  /// The photo with the largest share, -1: none.
  int chosenAt(const cv::Point& node) const {
    int chosen = -1, best = 0;
    for (const auto& [photo, weights] : weights_)
      if (weights.at<std::uint8_t>(node) > best) {
        best = weights.at<std::uint8_t>(node);
        chosen = photo;
      }
    return chosen;
  }

  cv::Vec3f toneAt(const cv::Point& node, int chosen, std::map<int, PhotoProjection>& views) const {
    const auto sightOf = [&](int photo) {
      auto view = views.find(photo);
      if (view == views.end()) view = views.emplace(photo, ground_.projection(photo)).first;
      return view->second.project(ground_.local(node.x, node.y));
    };
    const auto own = sightOf(chosen);
    const cv::Vec3f own_tone = scene_.tones.corrected(chosen, own.u, own.v);
    const cv::Point cell((ground_.nodes().x + node.x) / kLattice,
                         (ground_.nodes().y + node.y) / kLattice);
    const auto& candidates =
        scene_
            .candidates[static_cast<std::size_t>(cell.y * scene_.surface.lattice().cols + cell.x)];
    cv::Vec3f sum = cv::Vec3f::all(0);
    float weight = 0;
    for (const OrthoCandidate& c : candidates) {
      const auto sight = c.photo == chosen ? own : sightOf(c.photo);
      if (sight.border < 0) continue;
      const cv::Vec3f tone = scene_.tones.corrected(c.photo, sight.u, sight.v);
      const cv::Vec3f difference = tone - own_tone;
      const float w = std::exp(-demerit(sight) / kToneFade -
                               difference.dot(difference) / (2 * kToneNoise * kToneNoise));
      sum += w * tone;
      weight += w;
    }
    return weight > 0 ? sum / weight : own_tone;
  }

  cv::Mat& weights(int photo) {
    cv::Mat& weights = weights_[photo];
    if (weights.empty()) weights = cv::Mat::zeros(ground_.nodes().size(), CV_8UC1);
    return weights;
  }

  /// Pixels of the photo that the nodes with a weight and those next to them need: where their rim
  /// falls.
  cv::Rect2f partOf(int photo, const cv::Rect& nodes, const cv::Mat& weights) const {
    const PhotoProjection view = ground_.projection(photo);
    const cv::Rect wide = cv::Rect(nodes.x - 1, nodes.y - 1, nodes.width + 2, nodes.height + 2) &
                          cv::Rect({0, 0}, weights.size());
    cv::Mat grown, shrunk;
    cv::dilate(weights(wide), grown, cv::Mat());
    cv::erode(weights(wide), shrunk, cv::Mat(), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    float low_u = 1e9F, low_v = 1e9F, high_u = -1e9F, high_v = -1e9F;
    for (int y = 0; y < wide.height; ++y)
      for (int x = 0; x < wide.width; ++x) {
        if (grown.at<std::uint8_t>(y, x) == 0 || shrunk.at<std::uint8_t>(y, x) != 0) continue;
        const auto sight = view.place(ground_.local(wide.x + x, wide.y + y));
        if (sight.border <= -1) continue;  // behind the camera
        low_u = std::min(low_u, sight.u);
        low_v = std::min(low_v, sight.v);
        high_u = std::max(high_u, sight.u);
        high_v = std::max(high_v, sight.v);
      }
    return {low_u, low_v, high_u - low_u, high_v - low_v};
  }

  const OrthoScene& scene_;
  const OrthoGround& ground_;
  std::map<int, cv::Mat> weights_;
};

}  // namespace

cv::Mat OrthoShare::decoded() const { return cv::imdecode(weights, cv::IMREAD_GRAYSCALE); }

OrthoWindow shareOrthoWindow(const OrthoScene& scene, const cv::Rect& area) {
  constexpr int kMargin = OrthoWindow::kMargin;
  OrthoWindow window;
  window.nodes = cv::Rect(area.x - kMargin, area.y - kMargin, area.width + 2 * kMargin,
                          area.height + 2 * kMargin);
  const OrthoGround ground(scene, window.nodes, true);
  Sharing sharing(scene, ground);
  const cv::Rect& nodes = window.nodes;
  const cv::Size lattice = scene.surface.lattice().size();
  for (int row = std::max(0, nodes.y / kLattice);
       row <= std::min(lattice.height - 1, (nodes.br().y - 1) / kLattice); ++row)
    for (int column = std::max(0, nodes.x / kLattice);
         column <= std::min(lattice.width - 1, (nodes.br().x - 1) / kLattice); ++column)
      sharing.shareCell(column, row);
  window.shares = sharing.packed();
  window.tones = sharing.tones();
  return window;
}

}  // namespace cf
