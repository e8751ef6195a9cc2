// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrpt/opengl/CCamera.h>
#include <mrpt/opengl/CRenderizable.h>

#include <memory>

#include "cf/view/view_camera.h"
#include "compose.h"

namespace mrpt::opengl {
class CFBORender;
}

namespace cf {

inline constexpr float kBackgroundGrey = 30 / 255.0F;  // dark, neutral

mrpt::opengl::CCamera mrptCamera(const ViewCamera& camera);

/// MRPT's offscreen renderer for one camera. To be made, used and destroyed in one thread, and one
/// at a time.
class Offscreen {
 public:
  /// Throws RunError if the renderer cannot start.
  explicit Offscreen(const ViewCamera& camera);
  ~Offscreen();
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

  Layer render(const mrpt::opengl::CRenderizable::Ptr& object);

 private:
  ViewCamera camera_;
  std::unique_ptr<mrpt::opengl::CFBORender> renderer_;
};

}  // namespace cf
