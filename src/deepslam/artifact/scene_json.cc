#include "deepslam/artifact/scene_json.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/check.h"
#include "deepslam/core/parallel.h"

namespace deepslam::artifact {
namespace {

constexpr int kMaxImageSide = 1 << 15;

constexpr std::array<std::string_view, 4> kTrackingNames = {
    "tracked", "degenerate", "lost", "unreadable"};
constexpr std::array<std::string_view, 3> kDetectionNames = {"network", "file", "cluster"};

template <typename Enum, std::size_t kCount>
Enum ReadEnum(const JsonNode& node, const std::array<std::string_view, kCount>& names) {
  const std::string text = node.String();
  std::string known;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (names[i] == text) return static_cast<Enum>(i);
    known += (i > 0 ? ", " : "") + std::string(names[i]);
  }
  node.Fail(fmt::format("is \"{}\", must be one of: {}", text, known));
  return static_cast<Enum>(0);
}

template <int kSize>
JsonValue MatrixToJson(const Eigen::Matrix<double, kSize, kSize>& matrix) {
  JsonArray numbers;
  for (int row = 0; row < kSize; ++row) {
    for (int col = 0; col < kSize; ++col) numbers.emplace_back(matrix(row, col));
  }
  return JsonValue(std::move(numbers));
}

template <int kSize>
Eigen::Matrix<double, kSize, kSize> ReadMatrix(const JsonNode& node) {
  const std::vector<double> numbers = node.Numbers(kSize * kSize);
  Eigen::Matrix<double, kSize, kSize> matrix;
  for (int row = 0; row < kSize; ++row) {
    for (int col = 0; col < kSize; ++col) {
      matrix(row, col) = numbers[static_cast<std::size_t>(row * kSize + col)];
    }
  }
  return matrix;
}

}  // namespace

JsonValue ToJson(const Eigen::Vector3d& value) {
  return JsonArray{value.x(), value.y(), value.z()};
}

JsonValue ToJson(const Pose3& b_from_a) {
  const Eigen::Vector4d q = b_from_a.rotation.coeffs();
  JsonObject object;
  object.emplace("rotation_xyzw", JsonArray{q[0], q[1], q[2], q[3]});
  object.emplace("translation_m", ToJson(b_from_a.translation_m));
  return JsonValue(std::move(object));
}

JsonValue ToJson(const Plane& plane) {
  JsonObject object;
  object.emplace("normal", ToJson(plane.normal));
  object.emplace("d_m", plane.d_m);
  return JsonValue(std::move(object));
}

JsonValue ToJson(const Box3& box) {
  if (box.empty()) return {};
  JsonObject object;
  object.emplace("min", ToJson(box.min));
  object.emplace("max", ToJson(box.max));
  return JsonValue(std::move(object));
}

JsonValue ToJson(const PixelMask& mask) {
  if (mask.empty()) return {};
  JsonObject object;
  object.emplace("size", JsonArray{mask.height(), mask.width()});
  object.emplace("counts", mask.rle());
  return JsonValue(std::move(object));
}

JsonValue ToJson(const PinholeCamera& camera) {
  JsonObject object;
  object.emplace("width", camera.width);
  object.emplace("height", camera.height);
  object.emplace("fx", camera.fx);
  object.emplace("fy", camera.fy);
  object.emplace("cx", camera.cx);
  object.emplace("cy", camera.cy);
  return JsonValue(std::move(object));
}

JsonValue ToJson(const Eigen::Matrix3d& matrix) { return MatrixToJson<3>(matrix); }
JsonValue ToJson(const Matrix6d& matrix) { return MatrixToJson<6>(matrix); }

JsonValue ToCocoBox(const Box2& box_px) {
  return JsonArray{
      box_px.u_min, box_px.v_min, box_px.u_max - box_px.u_min, box_px.v_max - box_px.v_min};
}

Eigen::Vector3d ReadVector3(const JsonNode& node) {
  const std::vector<double> n = node.Numbers(3);
  return {n[0], n[1], n[2]};
}

Pose3 ReadPose(const JsonNode& node) {
  const JsonNode rotation = node["rotation_xyzw"];
  const std::vector<double> q = rotation.Numbers(4);
  Pose3 pose;
  pose.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  if (std::abs(pose.rotation.norm() - 1.0) > 1e-6) {
    rotation.Fail(fmt::format("has norm {}, must be a unit quaternion", pose.rotation.norm()));
    pose.rotation = Eigen::Quaterniond::Identity();
  }
  pose.translation_m = ReadVector3(node["translation_m"]);
  return pose;
}

Plane ReadPlane(const JsonNode& node) {
  Plane plane{ReadVector3(node["normal"]), node["d_m"].Number()};
  if (std::abs(plane.normal.norm() - 1.0) > 1e-6) {
    node.Fail(fmt::format("has a normal of length {}, must be 1", plane.normal.norm()));
  }
  return plane;
}

Box3 ReadBox3(const JsonNode& node) {
  if (!node.exists()) return {};
  return {ReadVector3(node["min"]), ReadVector3(node["max"])};
}

PixelMask ReadMask(const JsonNode& node) {
  if (!node.exists()) return {};
  const std::vector<JsonNode> size = node["size"].Items(2);
  const int height = size[0].Int(1, kMaxImageSide);
  const int width = size[1].Int(1, kMaxImageSide);
  const JsonNode counts = node["counts"];
  Result<PixelMask> mask = PixelMask::FromRle(counts.String(), width, height);
  if (mask.ok()) return std::move(mask).value();
  counts.Fail(": " + mask.error().message);
  return {};
}

PinholeCamera ReadCamera(const JsonNode& node) {
  PinholeCamera camera;
  camera.width = node["width"].Int(1, kMaxImageSide);
  camera.height = node["height"].Int(1, kMaxImageSide);
  camera.fx = node["fx"].Number(1e-3, 1e6);
  camera.fy = node["fy"].Number(1e-3, 1e6);
  camera.cx = node["cx"].Number(-1e6, 1e6);
  camera.cy = node["cy"].Number(-1e6, 1e6);
  return camera;
}

Eigen::Matrix3d ReadMatrix3(const JsonNode& node) { return ReadMatrix<3>(node); }
Matrix6d ReadMatrix6(const JsonNode& node) { return ReadMatrix<6>(node); }

Box2 ReadCocoBox(const JsonNode& node) {
  const std::vector<double> n = node.Numbers(4);
  return {n[0], n[1], n[0] + n[2], n[1] + n[3]};
}

std::string_view NameOf(TrackingStatus status) {
  return kTrackingNames[static_cast<std::size_t>(status)];
}
std::string_view NameOf(DetectionSource source) {
  return kDetectionNames[static_cast<std::size_t>(source)];
}

TrackingStatus ReadTrackingStatus(const JsonNode& node) {
  return ReadEnum<TrackingStatus>(node, kTrackingNames);
}
DetectionSource ReadDetectionSource(const JsonNode& node) {
  return ReadEnum<DetectionSource>(node, kDetectionNames);
}
CandidateSource ReadCandidateSource(const JsonNode& node) {
  return ReadEnum<CandidateSource>(node, kCandidateSourceNames);
}

}  // namespace deepslam::artifact
