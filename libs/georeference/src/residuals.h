// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Geometry>

namespace cf {

/// A pose as linearised: its block of six parameters is (translation [m], rotation vector [rad]) of
/// a left perturbation in world, zero at this pose.
struct LinearPose {
  Eigen::Vector3d position;
  Eigen::Quaterniond rotation;  ///< world from camera

  explicit LinearPose(const Eigen::Isometry3d& T)
      : position(T.translation()), rotation(T.linear()) {}

  template <class T>
  Eigen::Quaternion<T> rotationAt(const T* block) const {
    T wxyz[4];
    ceres::AngleAxisToQuaternion(block + 3, wxyz);
    return Eigen::Quaternion<T>(wxyz[0], wxyz[1], wxyz[2], wxyz[3]) * rotation.cast<T>();
  }
  template <class T>
  Eigen::Matrix<T, 3, 1> positionAt(const T* block) const {
    return position.cast<T>() + Eigen::Map<const Eigen::Matrix<T, 3, 1>>(block);
  }
};

/// Equation (5), e_q and e_t, of two consecutive keyframes. Erratum: the print compares q_j q_i^-1,
/// which is conjugated by the unknown local-to-world rotation; the increment in the body frame,
/// q_i^-1 q_j, is the same in both frames. The translation is scaled by s.
struct OdometryResidual {
  LinearPose i, j;
  Eigen::Quaterniond q_i_j;  ///< as odometry has it
  Eigen::Vector3d t_i_j;     ///< [VO units]
  double scale;              ///< as linearised; the parameter is the logarithm of a factor to it
  double rotation_sigma;     ///< [rad]
  double translation_sigma;  ///< [m]

  template <class T>
  bool operator()(const T* block_i, const T* block_j, const T* log_scale, T* residual) const {
    const Eigen::Quaternion<T> q_i = i.rotationAt(block_i), q_j = j.rotationAt(block_j);
    const Eigen::Quaternion<T> error = q_i_j.conjugate().cast<T>() * q_i.conjugate() * q_j;
    const T wxyz[4] = {error.w(), error.x(), error.y(), error.z()};
    ceres::QuaternionToAngleAxis(wxyz, residual);
    const Eigen::Matrix<T, 3, 1> step =
        q_i.conjugate() * (j.positionAt(block_j) - i.positionAt(block_i));
    const T s = scale * ceres::exp(log_scale[0]);
    for (int k = 0; k < 3; ++k) {
      residual[k] /= rotation_sigma;
      residual[3 + k] = (step[k] - s * t_i_j[k]) / translation_sigma;
    }
    return true;
  }
};

/// Equation (6), e_g, east and north. Its e_s is not used: it takes the same fixes again, and the
/// print divides by the metric displacement; initialise() starts the scale from the right ratio.
struct HorizontalFixResidual {
  LinearPose pose;
  Eigen::Vector2d position, sigma;

  template <class T>
  bool operator()(const T* block, T* residual) const {
    for (int k = 0; k < 2; ++k)
      residual[k] = (pose.position[k] + block[k] - position[k]) / sigma[k];
    return true;
  }
};

/// Equation (6), e_g, up: apart, so that a bad altitude does not cost the horizontal position.
struct VerticalFixResidual {
  LinearPose pose;
  double height, sigma;

  template <class T>
  bool operator()(const T* block, T* residual) const {
    residual[0] = (pose.position.z() + block[2] - height) / sigma;
    return true;
  }
};

/// Tilt as the gimbal tags it, from accelerometers: where up is in the camera frame.
struct TiltResidual {
  LinearPose pose;
  Eigen::Vector3d up_cam;
  double sigma;  ///< [rad]

  template <class T>
  bool operator()(const T* block, T* residual) const {
    const Eigen::Matrix<T, 3, 1> up =
        pose.rotationAt(block).conjugate() * Eigen::Vector3d::UnitZ().cast<T>().eval();
    for (int k = 0; k < 3; ++k) residual[k] = (up[k] - up_cam[k]) / sigma;
    return true;
  }
};

/// Heading as the gimbal tags it, from a compass: the turn about up to the tagged attitude.
struct YawResidual {
  LinearPose pose;
  Eigen::Quaterniond tagged;
  double sigma;  ///< [rad]

  template <class T>
  bool operator()(const T* block, T* residual) const {
    const Eigen::Quaternion<T> error = pose.rotationAt(block) * tagged.conjugate().cast<T>();
    T turn[3];
    const T wxyz[4] = {error.w(), error.x(), error.y(), error.z()};
    ceres::QuaternionToAngleAxis(wxyz, turn);
    residual[0] = turn[2] / sigma;
    return true;
  }
};

/// A direction of the camera frame whose direction in the world is known: its z axis is down
/// (nadir), or its ground's normal is up.
struct DirectionResidual {
  LinearPose pose;
  Eigen::Vector3d direction_cam, direction_world;
  double sigma;  ///< [rad]

  template <class T>
  bool operator()(const T* block, T* residual) const {
    const Eigen::Matrix<T, 3, 1> d = pose.rotationAt(block) * direction_cam.cast<T>();
    for (int k = 0; k < 3; ++k) residual[k] = (d[k] - direction_world[k]) / sigma;
    return true;
  }
};

/// Keeps one parameter where it is linearised, very loosely: the information of knowing nothing.
struct LooseResidual {
  int index;
  double sigma;

  template <class T>
  bool operator()(const T* block, T* residual) const {
    residual[0] = block[index] / sigma;
    return true;
  }
};

/// The logarithm of the scale against a hint: tagged height over the median depth.
struct LogScaleResidual {
  double log_hint_over_scale, sigma;

  template <class T>
  bool operator()(const T* log_scale, T* residual) const {
    residual[0] = (log_scale[0] - log_hint_over_scale) / sigma;
    return true;
  }
};

}  // namespace cf
