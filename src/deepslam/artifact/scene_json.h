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
// Masks as COCO {size: [h, w], counts}, null where one is empty; a few are encoded side by side
// when the first of them is asked for. Each is to be taken once, in their order.
class MaskEncoder {
 public:
  MaskEncoder(std::size_t count, std::function<const PixelMask&(std::size_t index)> mask)
      : count_(count), mask_(std::move(mask)) {}

  [[nodiscard]] JsonValue Take(std::size_t index);

 private:
  std::size_t count_;
  std::function<const PixelMask&(std::size_t index)> mask_;
  std::size_t first_ = 0;
  std::vector<JsonValue> encoded_;  // from `first_` on
};
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
// Of each row the member of that name, which may be missing.
[[nodiscard]] std::vector<JsonNode> MembersOf(std::span<const JsonNode> rows, std::string_view key);
// Those of some rows, side by side.
[[nodiscard]] std::vector<PixelMask> ReadMasks(std::span<const JsonNode> nodes);
// Appends what the rows hold, each with its mask.
template <typename Masked>
void AppendMasked(std::span<const JsonNode> rows,
                  Masked (*read_without_mask)(const JsonNode& row),
                  std::vector<Masked>& all) {
  const std::size_t first = all.size();
  for (const JsonNode& row : rows) all.push_back(read_without_mask(row));
  std::vector<PixelMask> masks = ReadMasks(MembersOf(rows, "segmentation"));
  for (std::size_t i = 0; i < masks.size(); ++i) all[first + i].mask = std::move(masks[i]);
}
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
[[nodiscard]] std::string_view NameOf(CandidateSource source);
[[nodiscard]] TrackingStatus ReadTrackingStatus(const JsonNode& node);
[[nodiscard]] DetectionSource ReadDetectionSource(const JsonNode& node);
[[nodiscard]] CandidateSource ReadCandidateSource(const JsonNode& node);

}  // namespace deepslam::artifact
