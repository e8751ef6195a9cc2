// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

#include "cf/deliver/run_record.h"

namespace cf {

/// What the maps of the report are drawn on: pixels of a north-up picture of the run's grid.
struct MapFrame {
  Eigen::Affine3d T_grid_world = Eigen::Affine3d::Identity();
  double left_m = 0, top_m = 0, cell_m = 1;
  int width = 0, height = 0;
  cv::Mat orthophoto;  ///< CV_8UC3, white where there is none; empty without a file
  cv::Mat heights;     ///< CV_32FC1, NaN for none; empty without a file

  Eigen::Vector2d pixelOf(const Eigen::Vector3d& p_world) const;
  /// The middle of a pixel at this height [m, of the grid], world.
  Eigen::Vector3d worldOf(double column, double row, double height_m) const;
};

/// The frame of orthophoto.tif in `outdir`, else of dsm.tif, else around the photos' places.
MapFrame mapFrameOf(const RunRecord& run, const std::filesystem::path& outdir);

/// The picture (empty: none), and over it SVG in its pixels, a scale bar and north.
std::string mapHtml(const MapFrame& frame, const cv::Mat& picture, const std::string& svg);

/// The UAVs' paths, a triangle at the end of each, relative poses in red if wanted.
std::string trajectoriesSvg(const RunRecord& run, const MapFrame& frame, bool links);

/// Blue over green and yellow to red for 0 to 1, B G R.
cv::Vec3b heightColour(double share);

}  // namespace cf
