// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "fix_track.h"

#include <iterator>

namespace cf {
namespace {
/// A fix this close to a photo is the photo's own.
constexpr TimeNs kSameTime = 1'000'000;
}  // namespace

bool FixTrack::reaches(TimeNs time) const {
  return !fixes_.empty() && fixes_.rbegin()->first >= time - kSameTime;
}

std::optional<GnssPosition> FixTrack::at(TimeNs time) const {
  const auto after = fixes_.lower_bound(time);
  if (after != fixes_.end() && after->first - time <= kSameTime) return after->second;
  if (after == fixes_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (time - before->first <= kSameTime) return before->second;
  if (after == fixes_.end()) return std::nullopt;

  const double gap_s = seconds(after->first - before->first);
  if (gap_s > max_gap_s_) return std::nullopt;
  const double u = seconds(time - before->first) / gap_s;
  const GnssPosition &a = before->second, &b = after->second;
  // A path with acceleration c leaves the chord by c u (1-u) gap^2 / 2.
  const double bow_m = acceleration_sigma_mps2_ * u * (1 - u) * gap_s * gap_s / 2;
  GnssPosition out;
  out.position_m = (1 - u) * a.position_m + u * b.position_m;
  out.sigma_m = (((1 - u) * a.sigma_m).cwiseAbs2() + (u * b.sigma_m).cwiseAbs2() +
                 Eigen::Vector3d::Constant(bow_m * bow_m))
                    .cwiseSqrt();
  return out;
}

void FixTrack::forgetBefore(TimeNs time) {
  auto keep = fixes_.lower_bound(time - kSameTime);
  if (keep != fixes_.begin()) --keep;
  fixes_.erase(fixes_.begin(), keep);
}

}  // namespace cf
