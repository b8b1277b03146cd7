#include "deepslam/gltf/draco_encode.h"

#include <draco/compression/expert_encode.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "deepslam/gltf/draco_decode.h"

namespace deepslam::gltf {
namespace {

// Slower encoding for fewer bytes: a scene is written once. Draco's scale is 0 (smallest) to 10.
constexpr int kEncodingSpeed = 3;
constexpr int kDecodingSpeed = 5;  // the middle: scenes are decoded whenever a page is opened

Error Unusable(const std::string& what) { return InvalidInput("Draco: " + what); }

int AddAttribute(draco::Mesh& mesh,
                 draco::GeometryAttribute::Type type,
                 draco::DataType data_type,
                 std::int8_t num_components,
                 bool normalised,
                 const std::vector<const void*>& values) {
  draco::GeometryAttribute attribute;
  const std::int64_t stride = draco::DataTypeLength(data_type) * num_components;
  attribute.Init(
      type, nullptr, static_cast<std::uint8_t>(num_components), data_type, normalised, stride, 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  for (std::size_t n = 0; n < values.size(); ++n) {
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(n)),
                                          values[n]);
  }
  return id;
}

template <typename T>
std::vector<const void*> Pointers(const std::vector<T>& values) {
  std::vector<const void*> pointers;
  pointers.reserve(values.size());
  for (const T& value : values) pointers.push_back(&value);
  return pointers;
}

void SetFaces(draco::Mesh& mesh,
              std::size_t num_points,
              const std::vector<std::array<std::uint32_t, 3>>& faces) {
  mesh.set_num_points(static_cast<std::uint32_t>(num_points));
  mesh.SetNumFaces(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    mesh.SetFace(draco::FaceIndex(static_cast<std::uint32_t>(f)),
                 {draco::PointIndex(faces[f][0]),
                  draco::PointIndex(faces[f][1]),
                  draco::PointIndex(faces[f][2])});
  }
}

struct Grid {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  float range = 0;
};

Grid GridOf(const std::vector<Eigen::Vector3f>& positions) {
  Eigen::Vector3f low = positions.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const float range = (high - low).maxCoeff();
  return {low, range > 0 ? range : 1.0F};
}

Result<std::string> EncodeMesh(const draco::Mesh& mesh,
                               const Grid& grid,
                               int position_bits,
                               int normal_bits) {
  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(kEncodingSpeed, kDecodingSpeed);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeExplicitQuantization(0, position_bits, 3, grid.origin.data(), grid.range);
  const int normal = mesh.GetNamedAttributeId(draco::GeometryAttribute::NORMAL);
  if (normal >= 0) encoder.SetAttributeQuantization(normal, normal_bits);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) return Failed("Draco: " + status.error_msg_string());
  return std::string(buffer.data(), buffer.size());
}

// Different places of the vertices that faces use; Draco drops the others.
std::size_t NumPlaces(const std::vector<Eigen::Vector3f>& positions,
                      const std::vector<std::array<std::uint32_t, 3>>& faces) {
  std::vector<std::uint8_t> used(positions.size(), 0);
  for (const auto& face : faces) {
    for (const std::uint32_t v : face) used[v] = 1;
  }
  std::vector<std::array<float, 3>> places;
  places.reserve(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Eigen::Vector3f& p = positions[v];
    if (used[v] != 0) places.push_back({p.x(), p.y(), p.z()});
  }
  std::sort(places.begin(), places.end());
  return static_cast<std::size_t>(std::unique(places.begin(), places.end()) - places.begin());
}

Status CheckBits(int position_bits) {
  if (position_bits < kMinPositionBits || position_bits > kMaxPositionBits) {
    return InvalidConfig("position_bits " + std::to_string(position_bits) + " is not in [" +
                         std::to_string(kMinPositionBits) + ", " +
                         std::to_string(kMaxPositionBits) + "]");
  }
  return Ok();
}

// With their ids.
DracoPayload AddAttributes(const RenderMesh& mesh, draco::Mesh& source) {
  using Attribute = draco::GeometryAttribute;
  const auto unique_id = [&](int id) {
    return static_cast<int>(source.attribute(id)->unique_id());
  };
  DracoPayload payload;
  payload.position_id = unique_id(AddAttribute(
      source, Attribute::POSITION, draco::DT_FLOAT32, 3, false, Pointers(mesh.positions)));
  if (!mesh.normals.empty()) {
    payload.normal_id = unique_id(AddAttribute(
        source, Attribute::NORMAL, draco::DT_FLOAT32, 3, false, Pointers(mesh.normals)));
  }
  if (!mesh.colours.empty()) {
    payload.colour_id = unique_id(
        AddAttribute(source, Attribute::COLOR, draco::DT_UINT16, 4, true, Pointers(mesh.colours)));
  }
  return payload;
}

// Empty: it can be encoded.
std::string FaultOf(const RenderMesh& mesh) {
  if (mesh.faces.empty()) return "an empty mesh cannot be encoded";
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t v : face) {
      if (v >= mesh.positions.size()) return "face index out of range";
    }
  }
  const auto is_finite = [](const Eigen::Vector3f& p) { return p.allFinite(); };
  return std::ranges::all_of(mesh.positions, is_finite) ? "" : "a vertex is not finite";
}

// What a decoder gets; alpha is not looked at.
Result<RenderMesh> Decoded(std::string_view bytes, const DracoPayload& payload) {
  Result<DracoMesh> mesh = DracoDecode(bytes,
                                       {.position = payload.position_id,
                                        .normal = payload.normal_id,
                                        .colour = payload.colour_id,
                                        .strict = true});
  if (!mesh) return mesh.error();
  constexpr float kFull = 65535;  // colours of 16 bits, as 0 to 1
  RenderMesh decoded;
  decoded.positions = std::move(mesh->positions);
  decoded.normals = std::move(mesh->normals);
  for (const Eigen::Vector3f& c : mesh->colours) {
    const auto channel = [&](int n) {
      return static_cast<std::uint16_t>(std::lround(c[n] * kFull));
    };
    decoded.colours.push_back({channel(0), channel(1), channel(2), 65535});
  }
  decoded.faces = std::move(mesh->faces);
  return decoded;
}

}  // namespace

double QuantisationError(const std::vector<Eigen::Vector3f>& positions, int position_bits) {
  if (positions.empty()) return 0;
  const Grid grid = GridOf(positions);
  const double range = static_cast<double>(grid.range);
  const double largest = static_cast<double>(grid.origin.cwiseAbs().maxCoeff()) + range;
  // Half a step of the grid, and the rounding of floats in Draco's own arithmetic.
  constexpr double kFloatRounding = 4.0 / (1 << 23);
  return 0.5 * range / (std::pow(2.0, position_bits) - 1.0) + kFloatRounding * largest;
}

Result<DracoPayload> DracoEncode(const RenderMesh& mesh,
                                 int position_bits,
                                 int normal_bits,
                                 bool keep_apart) {
  const Status bits_ok = CheckBits(position_bits);
  if (!bits_ok) return bits_ok.error();
  if (const std::string fault = FaultOf(mesh); !fault.empty()) return Unusable(fault);
  draco::Mesh source;
  SetFaces(source, mesh.positions.size(), mesh.faces);
  DracoPayload payload = AddAttributes(mesh, source);
  // Vertices doubled at creases share one position value: connectivity, and so closedness, is kept
  // by Draco itself.
  if (!source.DeduplicateAttributeValues()) return Failed("Draco: values not deduplicated");
  const Grid grid = GridOf(mesh.positions);
  const std::size_t num_places = keep_apart ? NumPlaces(mesh.positions, mesh.faces) : 0;
  for (int bits = position_bits; bits <= kMaxPositionBits; ++bits) {
    Result<std::string> bytes = EncodeMesh(source, grid, bits, normal_bits);
    if (!bytes) return bytes.error();
    Result<RenderMesh> decoded = Decoded(*bytes, payload);
    if (!decoded) return decoded.error();
    if (decoded->faces.size() != mesh.faces.size()) {
      return Unusable("faces with two corners at one place cannot be encoded");
    }
    payload.position_bits = bits;
    payload.bytes = std::move(*bytes);
    payload.decoded = std::move(*decoded);
    if (!keep_apart || NumPlaces(payload.decoded.positions, payload.decoded.faces) == num_places)
      return payload;
  }
  return Unusable("vertices lie closer together than the finest grid");
}

}  // namespace deepslam::gltf
