// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "segment.h"

namespace cf {

/// How world poses and scale of a UAV's segments follow from increments, fixes and attitudes. Both
/// methods build the same graph and solve it on the same schedule; they differ in what is a state
/// and how measurements are weighed.
class GeoreferenceMethod {
 public:
  explicit GeoreferenceMethod(const GeoreferenceOptions& options) : options_(options) {}
  virtual ~GeoreferenceMethod() = default;

  /// The last node of segments[changed] is new: estimates that segment.
  virtual void update(std::vector<Segment>& segments, std::size_t changed) const = 0;
  /// Nothing more will come: estimates all segments in full.
  virtual void finish(std::vector<Segment>& segments) const = 0;

  /// Whether the graph has a scale of its own, or the segment's is held.
  virtual bool scaleIsState() const = 0;
  /// From node j - 1 to node j.
  virtual Increment increment(const Segment& segment, std::size_t j) const = 0;
  /// By which the tagged sigmas of fixes are multiplied.
  virtual Noise weights(const std::vector<Segment>& segments) const = 0;
  /// What is told as the scale of a segment [m per VO unit].
  virtual double scaleOf(const Segment& segment) const = 0;

  const GeoreferenceOptions& options() const { return options_; }

 protected:
  /// A short segment is solved as a whole at each node.
  bool isShort(const Segment& segment) const;
  /// A longer one whenever it has grown by a tenth, and in between from windowStart() on, so that
  /// the mean cost of a keyframe is bounded.
  bool fullSolveDue(const Segment& segment) const;
  std::size_t windowStart(const Segment& segment) const;

 private:
  const GeoreferenceOptions options_;
};

/// Names that makeMethod() knows.
const std::vector<std::string>& georeferenceMethods();
/// By `options.method`; throws UsageError if there is none of that name.
std::unique_ptr<GeoreferenceMethod> makeMethod(const GeoreferenceOptions& options);
std::unique_ptr<GeoreferenceMethod> makeTwoStage(const GeoreferenceOptions& options);
std::unique_ptr<GeoreferenceMethod> makeGlobalFusion(const GeoreferenceOptions& options);

/// Minimises residuals (5), (6) and the attitude priors over nodes from `first_free` on, and over
/// the scale if that is 0 and the scale is a state; then sets covariances and `segment.noise` of
/// all nodes. A segment whose estimate is not finite ends unsolved. The sigma of the scale is that
/// of a graph with the scale as a state, whether it is one or not.
void solve(Segment& segment, const Noise& weights, const GeoreferenceMethod& method,
           std::size_t first_free);

/// MRPT text of the graph of all segments.
std::string poseGraphText(const std::vector<Segment>& segments,
                          const std::vector<GeoSegment>& published,
                          const GeoreferenceMethod& method);

}  // namespace cf
