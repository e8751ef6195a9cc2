// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cf/base/result.h"
#include "cf/base/time.h"
#include "cf/types/camera_model.h"
#include "cf/types/chain_step.h"
#include "cf/types/gnss_fix.h"
#include "cf/types/ids.h"
#include "cf/types/photo_record.h"

namespace cf {

/// The first that a UAV says: who it is and where it begins.
struct SeamHello {
  std::uint16_t uav = 0;
  std::string name;
  std::optional<std::size_t> photos;  ///< in its recording; none: that still grows, and has one
  std::optional<GnssFix> first_fix;   ///< with its datum
  /// Of the world that it georeferences in: latitude, longitude [deg], height [m]. None: no fix.
  std::optional<Eigen::Vector3d> origin;
  std::vector<std::string> warnings;  ///< about the recording, as far as they are known
  TimeNs next_from = 0;               ///< no photo of an earlier time will come
};

/// A photo that a UAV has processed, or what was left after its last.
struct SeamStep {
  struct Photo {
    std::string name;  ///< original base name with extension
    TimeNs time = 0;
    CameraModel camera;  ///< as given
  };
  ChainStep step;
  std::optional<Photo> photo;  ///< none: what was left after the last
  TimeNs next_from = 0;        ///< as in SeamHello
};

/// The last that a UAV says: what the report tells of it.
struct SeamDone {
  std::uint16_t uav = 0;
  std::vector<PhotoRecord> photos;          ///< in time order
  std::vector<PhotoPose> local_trajectory;  ///< T_local_cam of its segment, VO units
  std::vector<ScaleRow> scale_history;      ///< in time order
  GnssQuality gnss;
  int segments = 0;
  std::string pose_graph;             ///< MRPT's text form
  std::vector<std::string> warnings;  ///< about the recording, that the Hello did not tell
};

/// What crosses the seam between one UAV's agent and the central node
/// (libs/formats/proto/seam.proto, docs/seam.md).
using SeamMessage = std::variant<SeamHello, SeamStep, SeamDone>;

/// Messages of one UAV to bytes, in order: of the segments, a step holds only what has changed
/// since the step before.
class SeamEncoder {
 public:
  /// Throws RunError on a message of 2 GiB, and on a keyframe whose features' parts are not equally
  /// many.
  std::string encode(const SeamMessage& message);

 private:
  std::shared_ptr<const std::vector<GeoSegment>> segments_;  ///< as last sent
};

/// The same messages again, every number bit by bit.
class SeamDecoder {
 public:
  /// Fails with "damaged" on bytes that SeamEncoder did not write, or not at this place, and with
  /// "version" on a Hello of another version. Takes no more memory than a small multiple of the
  /// bytes given and of the segments known.
  Result<SeamMessage> decode(std::string_view bytes);

 private:
  std::shared_ptr<const std::vector<GeoSegment>> segments_;
};

/// One message by itself, as the first of a stream.
Result<SeamMessage> decodeSeamMessage(std::string_view bytes);

}  // namespace cf
