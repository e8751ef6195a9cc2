// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <opencv2/core/mat.hpp>

#include "cf/formats/geotiff.h"

namespace cf {

/// The surface on which photos are laid: nodes as far apart as the surface model's cells, or, for a
/// coarser orthophoto, as its pixels. Without holes, but it is known where the model has data.
class OrthoSurface {
 public:
  /// Nodes along a side of a cell of the lattice, on which all is decided that varies slowly.
  static constexpr int kLattice = 32;

  /// `gsd_m` asked for.
  OrthoSurface(const std::filesystem::path& dsm, double gsd_m);

  int pixelsPerNode() const { return pixels_per_node_; }
  double node() const { return node_m_; }
  double left() const { return dsm_.grid().left_m; }
  double top() const { return dsm_.grid().top_m; }
  cv::Size size() const { return size_; }  ///< in nodes
  const std::string& crs() const { return dsm_.grid().crs; }

  /// Heights [m] at the lattice's cells, CV_32FC1; all have one.
  const cv::Mat& lattice() const { return lattice_; }
  /// Greatest height within three cells of a cell, as far as the model has data.
  const cv::Mat& latticeTop() const { return lattice_top_; }

  struct Window {
    cv::Mat heights;  ///< CV_32FC1 [m], no holes
    cv::Mat shown;    ///< CV_8UC1, 255 where the orthophoto has a picture
  };
  /// `area` in nodes; may leave the surface. Thread-safe. The same node has the same height in
  /// every window.
  Window window(const cv::Rect& area) const;

 private:
  cv::Mat nodes(const cv::Rect& area) const;

  GeoTiffReader dsm_;
  mutable std::mutex mutex_;
  int pixels_per_node_ = 1, cells_per_node_ = 1;
  double node_m_ = 0;
  cv::Size size_;
  cv::Mat lattice_, lattice_top_;
  cv::Mat smooth_;  ///< CV_32FC1 by cell: heights for large holes
  cv::Mat inside_;  ///< CV_8UC1 by cell: 255 well inside of where data are, or surround a hole
};

}  // namespace cf
