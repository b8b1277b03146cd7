// JSON forms of the vocabulary's small values, shared by the codecs of this room.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::artifact {

inline constexpr int kMaxId = 100'000'000;

[[nodiscard]] JsonValue ToJson(const Eigen::Vector3d& value);
[[nodiscard]] JsonValue ToJson(const Pose3& b_from_a);  // {rotation_xyzw, translation_m}
[[nodiscard]] JsonValue ToJson(const Plane& plane);     // {normal, d_m}
[[nodiscard]] JsonValue ToJson(const Box3& box);        // {min, max} or null when empty
[[nodiscard]] JsonValue ToJson(
    const PixelMask& mask);  // COCO's {size: [h, w], counts} or null when empty
[[nodiscard]] JsonValue ToJson(const PinholeCamera& camera);
// Row-major.
[[nodiscard]] JsonValue ToJson(const Eigen::Matrix3d& matrix);
[[nodiscard]] JsonValue ToJson(const Matrix6d& matrix);
template <typename Tag>
[[nodiscard]] JsonValue ToJson(StrongId<Tag> id) {
  return id.valid() ? JsonValue(static_cast<std::int64_t>(id.value)) : JsonValue();
}
// COCO's [x, y, width, height].
[[nodiscard]] JsonValue ToCocoBox(const Box2& box_px);

[[nodiscard]] Eigen::Vector3d ReadVector3(const JsonNode& node);
[[nodiscard]] Pose3 ReadPose(
    const JsonNode& node);  // refuses rotations that are no unit quaternions
[[nodiscard]] Plane ReadPlane(const JsonNode& node);
[[nodiscard]] Box3 ReadBox3(const JsonNode& node);
[[nodiscard]] PixelMask ReadMask(const JsonNode& node);  // a null or missing one is empty
[[nodiscard]] PinholeCamera ReadCamera(const JsonNode& node);
[[nodiscard]] Eigen::Matrix3d ReadMatrix3(const JsonNode& node);
[[nodiscard]] Matrix6d ReadMatrix6(const JsonNode& node);
[[nodiscard]] Box2 ReadCocoBox(const JsonNode& node);
// A null or missing id is none.
template <typename Id>
[[nodiscard]] Id ReadId(const JsonNode& node) {
  return node.exists() ? Id{node.Int(0, kMaxId)} : Id{};
}

[[nodiscard]] std::string_view NameOf(TrackingStatus status);
[[nodiscard]] std::string_view NameOf(DetectionSource source);
[[nodiscard]] TrackingStatus ReadTrackingStatus(const JsonNode& node);
[[nodiscard]] DetectionSource ReadDetectionSource(const JsonNode& node);
[[nodiscard]] CandidateSource ReadCandidateSource(const JsonNode& node);

}  // namespace deepslam::artifact
