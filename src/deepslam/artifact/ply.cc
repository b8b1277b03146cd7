#include "deepslam/artifact/ply.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "deepslam/core/text_numbers.h"

namespace deepslam::artifact {
namespace {

static_assert(std::endian::native == std::endian::little,
              "PLY is written in the machine's byte order");

constexpr std::string_view kPosition = "property float x\nproperty float y\nproperty float z\n";
constexpr std::string_view kNormal = "property float nx\nproperty float ny\nproperty float nz\n";
constexpr std::string_view kColour =
    "property uchar red\nproperty uchar green\nproperty uchar blue\n";
constexpr std::string_view kLabel = "property int label\n";
constexpr std::string_view kFaces = "property list uchar int vertex_indices\nend_header\n";
// Number of corners, three indices.
constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::uint32_t);
// A header that claims more is refused before memory is taken.
constexpr std::int64_t kMaxElements = std::int64_t{1} << 28;

template <typename T>
void Append(const T& value, std::string& bytes) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

// Takes values off the front; the caller has checked that they are there.
template <typename T>
T Take(std::string_view& bytes) {
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  bytes.remove_prefix(sizeof(T));
  return value;
}

Eigen::Vector3f TakeVector(std::string_view& bytes) {
  const float x = Take<float>(bytes);
  const float y = Take<float>(bytes);
  const float z = Take<float>(bytes);
  return {x, y, z};
}

bool TakePrefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

std::optional<std::size_t> TakeCount(std::string_view& text, std::string_view what) {
  const std::string_view line = TakeLine(text);
  const std::vector<std::string_view> words = Words(line);
  if (words.size() != 3 || words[0] != "element" || words[1] != what) return std::nullopt;
  const std::optional<int> count = ParseInt(words[2]);
  if (!count || *count < 0 || *count > kMaxElements) return std::nullopt;
  return static_cast<std::size_t>(*count);
}

std::string CheckMesh(const PlyMesh& ply) {
  const std::size_t n = ply.mesh.vertices.size();
  if (!ply.mesh.colours.empty() && ply.mesh.colours.size() != n)
    return "number of colours differs from vertices";
  if (!ply.normals.empty() && ply.normals.size() != n)
    return "number of normals differs from vertices";
  if (!ply.labels.empty() && ply.labels.size() != n)
    return "number of labels differs from vertices";
  for (std::size_t i = 0; i < n; ++i) {
    if (!ply.mesh.vertices[i].allFinite()) return fmt::format("vertex {} is not finite", i);
    if (!ply.normals.empty() && !ply.normals[i].allFinite())
      return fmt::format("normal {} is not finite", i);
  }
  for (std::size_t f = 0; f < ply.mesh.faces.size(); ++f) {
    for (const std::uint32_t index : ply.mesh.faces[f]) {
      if (index >= n) return fmt::format("face {} names vertex {} of {}", f, index, n);
    }
  }
  return {};
}

}  // namespace

Result<std::string> EncodePly(const PlyMesh& ply, std::string_view name) {
  if (const std::string fault = CheckMesh(ply); !fault.empty())
    return Failed(fmt::format("{}: {}", name, fault));
  const TriangleMesh& mesh = ply.mesh;
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment deepslam mesh 1, metres\n";
  bytes += fmt::format("element vertex {}\n{}", mesh.vertices.size(), kPosition);
  if (!ply.normals.empty()) bytes += kNormal;
  if (!mesh.colours.empty()) bytes += kColour;
  if (!ply.labels.empty()) bytes += kLabel;
  bytes += fmt::format("element face {}\n{}", mesh.faces.size(), kFaces);
  bytes.reserve(bytes.size() + mesh.vertices.size() * 31 + mesh.faces.size() * kFaceBytes);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) Append(mesh.vertices[i][axis], bytes);
    if (!ply.normals.empty()) {
      for (int axis = 0; axis < 3; ++axis) Append(ply.normals[i][axis], bytes);
    }
    if (!mesh.colours.empty()) Append(mesh.colours[i], bytes);
    if (!ply.labels.empty()) Append(ply.labels[i], bytes);
  }
  for (const auto& face : mesh.faces) {
    Append(std::uint8_t{3}, bytes);
    for (const std::uint32_t index : face) Append(index, bytes);
  }
  return bytes;
}

Result<PlyMesh> DecodePly(std::string_view bytes, std::string_view name) {
  const auto refuse = [&](std::string_view what) {
    return InvalidInput(fmt::format("{}: {}", name, what));
  };
  if (!TakePrefix(bytes, "ply\nformat binary_little_endian 1.0\n")) {
    return refuse("is no binary little-endian PLY");
  }
  while (bytes.starts_with("comment")) static_cast<void>(TakeLine(bytes));
  const std::optional<std::size_t> num_vertices = TakeCount(bytes, "vertex");
  if (!num_vertices || !TakePrefix(bytes, kPosition))
    return refuse("has no vertices with x, y, z as float");
  const bool normals = TakePrefix(bytes, kNormal);
  const bool colours = TakePrefix(bytes, kColour);
  const bool labels = TakePrefix(bytes, kLabel);
  const std::optional<std::size_t> num_faces = TakeCount(bytes, "face");
  if (!num_faces || !TakePrefix(bytes, kFaces))
    return refuse("has other properties than deepslam writes");
  const std::size_t stride = 12U + (normals ? 12U : 0U) + (colours ? 3U : 0U) + (labels ? 4U : 0U);
  if (bytes.size() != *num_vertices * stride + *num_faces * kFaceBytes) {
    return refuse(fmt::format("is damaged: {} bytes of content for {} vertices and {} faces",
                              bytes.size(),
                              *num_vertices,
                              *num_faces));
  }
  PlyMesh ply;
  for (std::size_t i = 0; i < *num_vertices; ++i) {
    ply.mesh.vertices.push_back(TakeVector(bytes));
    if (normals) ply.normals.push_back(TakeVector(bytes));
    if (colours) ply.mesh.colours.push_back(Take<Rgb8>(bytes));
    if (labels) ply.labels.push_back(Take<std::int32_t>(bytes));
  }
  for (std::size_t f = 0; f < *num_faces; ++f) {
    if (Take<std::uint8_t>(bytes) != 3) return refuse(fmt::format("face {} is no triangle", f));
    std::array<std::uint32_t, 3> face{};
    for (std::uint32_t& index : face) index = Take<std::uint32_t>(bytes);
    ply.mesh.faces.push_back(face);
  }
  if (const std::string fault = CheckMesh(ply); !fault.empty()) return refuse(fault);
  return ply;
}

}  // namespace deepslam::artifact
