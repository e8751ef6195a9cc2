// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/simulate/true_camera.h"

#include <gtest/gtest.h>

#include "cf/types/camera_model.h"

namespace cf {
namespace {

TrueCamera bentCamera() {
  TrueCamera c;
  c.width = 4000, c.height = 3000;
  c.focal = 2900, c.cx = 2012.3, c.cy = 1490.8;
  c.k1 = -0.25, c.k2 = 0.09, c.k3 = -0.01, c.p1 = 1e-3, c.p2 = -7e-4;
  return c;
}

TEST(TrueCamera, RaysLeadBackToTheirPixels) {
  const TrueCamera c = bentCamera();
  for (int y = 0; y < c.height; y += 100) {
    for (int x = 0; x < c.width; x += 100) {
      const Eigen::Vector2d pixel(x + 0.25, y - 0.4);
      const Eigen::Vector3d ray = c.rayThrough(pixel);
      EXPECT_EQ(ray.z(), 1);
      EXPECT_LT((c.pixelOf(37 * ray) - pixel).norm(), 1e-9 * c.focal);
    }
  }
}

TEST(TrueCamera, AgreesWithTheEstimatorsModel) {
  const TrueCamera c = bentCamera();
  CameraModel model;
  model.width = c.width, model.height = c.height;
  model.fx = model.fy = c.focal, model.cx = c.cx, model.cy = c.cy;
  model.k1 = c.k1, model.k2 = c.k2, model.k3 = c.k3, model.p1 = c.p1, model.p2 = c.p2;
  for (int y = 0; y < c.height; y += 97) {
    for (int x = 0; x < c.width; x += 97) {
      const Eigen::Vector3d ray = c.rayThrough({x, y});
      EXPECT_LT((model.project(ray) - Eigen::Vector2d(x, y)).norm(), 1e-6);
      EXPECT_LT((model.undistort({x, y}) - ray.head<2>()).norm(), 1e-9);
    }
  }
}

}  // namespace
}  // namespace cf
