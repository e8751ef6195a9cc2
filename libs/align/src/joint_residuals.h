// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "reprojection_error.h"

namespace cf {

/// Fix minus (camera centre + bias of its UAV), in sigmas.
struct GnssError {
  Eigen::Vector3d fix, inverse_sigma;
  template <class T>
  bool operator()(const T* pose, const T* bias, T* residual) const {
    for (int i = 0; i < 3; ++i)
      residual[i] = T(inverse_sigma[i]) * (T(fix[i]) - pose[4 + i] - bias[i]);
    return true;
  }
};

struct VectorPrior {
  std::vector<double> mean, inverse_sigma;
  template <class T>
  bool operator()(T const* const* x, T* residual) const {
    for (std::size_t i = 0; i < mean.size(); ++i)
      residual[i] = T(inverse_sigma[i]) * (x[0][i] - T(mean[i]));
    return true;
  }
};

struct DifferencePrior {
  Lens inverse_sigma;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    for (int i = 0; i < kLens; ++i)
      residual[i] = T(inverse_sigma[static_cast<std::size_t>(i)]) * (a[i] - b[i]);
    return true;
  }
};

/// Rotation [rad] and translation [m] against the pose given.
struct PosePrior {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
  double inverse_rotation_sigma, inverse_translation_sigma;
  template <class T>
  bool operator()(const T* pose, T* residual) const {
    const T m[4] = {T(rotation.w()), T(-rotation.x()), T(-rotation.y()), T(-rotation.z())};
    T d[4];
    ceres::QuaternionProduct(m, pose, d);
    const T sign = d[0] < T(0) ? T(-2) : T(2);
    for (int i = 0; i < 3; ++i) {
      residual[i] = T(inverse_rotation_sigma) * sign * d[i + 1];
      residual[3 + i] = T(inverse_translation_sigma) * (pose[4 + i] - T(translation[i]));
    }
    return true;
  }
};

}  // namespace cf
