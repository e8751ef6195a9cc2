// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/import/strips.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cf {
namespace {

using Track = std::vector<Eigen::Vector2d>;

constexpr double kPricePerPiece = 25;  // noise alone gains far less by a cut
constexpr std::size_t kShortest = 3;   // photos of a strip
constexpr double kShortPart = 0.35;    // of the usual strip: shorter pieces are turns

/// Photos begin..end-1 of the track.
struct Piece {
  std::size_t begin, end;
  std::size_t size() const { return end - begin; }
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double stepOf(const Track& track) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < track.size(); ++i) steps.push_back((track[i] - track[i - 1]).norm());
  return median(steps);
}

/// Scatter across the track that is no turn: a quarter of a step, or what the positions' noise is
/// by each photo's offset from the middle of its neighbours, whichever is more.
double noiseOf(const Track& track, double step) {
  std::vector<double> offsets;
  for (std::size_t i = 1; i + 1 < track.size(); ++i) {
    const Eigen::Vector2d chord = track[i + 1] - track[i - 1];
    if (chord.norm() < 1e-6) continue;
    const Eigen::Vector2d offset = track[i] - (track[i + 1] + track[i - 1]) / 2;
    offsets.push_back(std::abs(chord.x() * offset.y() - chord.y() * offset.x()) / chord.norm());
  }
  constexpr double kSigmaPerMad = 1.4826;
  const double sigma = kSigmaPerMad * median(offsets) / std::sqrt(1.5);
  constexpr double kStepPart = 0.25, kMargin = 1.5, kLeast_m = 0.05;
  return std::max({kStepPart * step, kMargin * sigma, kLeast_m});
}

/// Sums over the first photos, so that any piece's scatter takes constant time.
class Scatter {
 public:
  explicit Scatter(const Track& track) : sums_(track.size() + 1) {
    for (std::size_t i = 0; i < track.size(); ++i) {
      const Eigen::Vector2d p = track[i] - track[0];
      sums_[i + 1] = {sums_[i].first + p, sums_[i].second + p * p.transpose()};
    }
  }
  /// Sum of the squared distances from the piece's best line.
  double across(Piece piece) const {
    const Eigen::Vector2d sum = sums_[piece.end].first - sums_[piece.begin].first;
    const Eigen::Matrix2d squares = sums_[piece.end].second - sums_[piece.begin].second;
    const Eigen::Matrix2d m = squares - sum * sum.transpose() / static_cast<double>(piece.size());
    const double half = m.trace() / 2;
    return std::max(0.0, half - std::hypot((m(0, 0) - m(1, 1)) / 2, m(0, 1)));
  }

 private:
  struct Sums {
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  };
  std::vector<Sums> sums_;
};

/// The cheapest division into straight pieces.
std::vector<Piece> straightPieces(const Track& track, double noise) {
  const Scatter scatter(track);
  const std::size_t n = track.size();
  std::vector<double> cost(n + 1, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> from(n + 1, 0);
  cost[0] = 0;
  for (std::size_t end = 1; end <= n; ++end) {
    for (std::size_t begin = 0; begin < end; ++begin) {
      const double c =
          cost[begin] + kPricePerPiece + scatter.across({begin, end}) / (noise * noise);
      if (c < cost[end]) {
        cost[end] = c;
        from[end] = begin;
      }
    }
  }
  std::vector<Piece> pieces;
  for (std::size_t end = n; end > 0; end = from[end]) pieces.push_back({from[end], end});
  std::reverse(pieces.begin(), pieces.end());
  return pieces;
}

/// Cuts a piece at its far point if it comes back from there on the same line.
void cutReversals(const Track& track, Piece piece, double least_m, std::vector<Piece>& out) {
  const Eigen::Vector2d first = track[piece.begin], last = track[piece.end - 1];
  std::size_t far = piece.begin;
  double far_m = 0;  // how far it goes beyond both ends
  for (std::size_t i = piece.begin; i < piece.end; ++i) {
    const double beyond = std::min((track[i] - first).norm(), (track[i] - last).norm());
    const bool between = (track[i] - first).dot(track[i] - last) < 0;
    if (!between && beyond > far_m) {
      far = i;
      far_m = beyond;
    }
  }
  if (far_m < least_m) {
    out.push_back(piece);
    return;
  }
  cutReversals(track, {piece.begin, far + 1}, least_m, out);
  cutReversals(track, {far + 1, piece.end}, least_m, out);
}

/// Shares a short piece out to its neighbours, at the place that leaves both straightest.
void dissolve(const Scatter& scatter, std::vector<Piece>& pieces, std::size_t i) {
  const Piece piece = pieces[i];
  if (i == 0) {
    pieces[1].begin = piece.begin;
  } else if (i + 1 == pieces.size()) {
    pieces[i - 1].end = piece.end;
  } else {
    std::size_t best = piece.begin;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t cut = piece.begin; cut <= piece.end; ++cut) {
      const double c =
          scatter.across({pieces[i - 1].begin, cut}) + scatter.across({cut, pieces[i + 1].end});
      if (c < least) {
        least = c;
        best = cut;
      }
    }
    pieces[i - 1].end = pieces[i + 1].begin = best;
  }
  pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(i));
}

void dissolveTurns(const Track& track, std::vector<Piece>& pieces) {
  const Scatter scatter(track);
  while (pieces.size() > 1) {
    // The usual strip: the median over photos, so that many short turns do not count for more.
    std::vector<double> sizes;
    for (const Piece& p : pieces)
      sizes.insert(sizes.end(), p.size(), static_cast<double>(p.size()));
    const double least = std::max(static_cast<double>(kShortest), kShortPart * median(sizes));
    const auto shortest =
        std::min_element(pieces.begin(), pieces.end(),
                         [](const Piece& a, const Piece& b) { return a.size() < b.size(); });
    if (static_cast<double>(shortest->size()) >= least) return;
    dissolve(scatter, pieces, static_cast<std::size_t>(shortest - pieces.begin()));
  }
}

}  // namespace

std::vector<int> stripsOf(const std::vector<std::optional<Eigen::Vector2d>>& positions) {
  Track track;
  for (const auto& p : positions)
    if (p) track.push_back(*p);
  if (track.size() < 2) return {};

  const double step = stepOf(track), noise = noiseOf(track, step);
  std::vector<Piece> pieces;
  constexpr double kReversalSteps = 2.5, kReversalNoises = 6;
  for (const Piece& piece : straightPieces(track, noise))
    cutReversals(track, piece, std::max(kReversalSteps * step, kReversalNoises * noise), pieces);
  dissolveTurns(track, pieces);

  std::vector<int> strips;
  std::size_t at = 0, piece = 0;
  for (const auto& p : positions) {
    if (p) {
      while (at >= pieces[piece].end) ++piece;
      ++at;
    }
    strips.push_back(static_cast<int>(piece));
  }
  return strips;
}

}  // namespace cf
