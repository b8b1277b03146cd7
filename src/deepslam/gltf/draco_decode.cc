#include "deepslam/gltf/draco_decode.h"

#include <draco/compression/decode.h>
#include <draco/core/decoder_buffer.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>

namespace deepslam::gltf {
namespace {

// A byte of Draco holds far fewer faces than this even on a regular grid; more is a lie that would
// cost memory.
constexpr std::uint64_t kMaxFacesPerByte = 64;
// Bounds memory whatever the file's size: more than any scene is drawn with.
constexpr std::uint64_t kMaxFaces = 50'000'000;

Error Unusable(const std::string& what) { return InvalidInput("Draco data: " + what); }

// Reads the header of Draco's bitstream 2.x so far as its counts go.
class HeaderReader {
 public:
  explicit HeaderReader(std::string_view bytes) : bytes_(bytes) {}

  [[nodiscard]] Status Check() {
    if (bytes_.size() < 12 || bytes_.substr(0, 5) != "DRACO") return Unusable("no Draco header");
    at_ = 5;
    const int major = Byte();
    const int minor = Byte();
    const int geometry = Byte();
    const int method = Byte();
    const int flags = Byte() | (Byte() << 8);
    if (major != 2 || minor != 2) {
      return Unusable("bitstream version " + std::to_string(major) + "." + std::to_string(minor) +
                      " is not supported (2.2 is)");
    }
    if (geometry != 1) return Unusable("it holds no triangle mesh");
    if (method > 1) return Unusable("unknown encoding method " + std::to_string(method));
    if (flags != 0) return Unusable("metadata is not supported");
    // Edgebreaker: traversal type, vertices, faces. Sequential: faces, points.
    if (method == 1) Byte();
    const std::uint64_t first = Varint();
    const std::uint64_t second = Varint();
    const std::uint64_t bound = std::min(kMaxFaces, kMaxFacesPerByte * bytes_.size());
    if (at_ > bytes_.size()) return Unusable("truncated header");
    if (std::max(first, second) > bound) {
      return Unusable("claims " + std::to_string(std::max(first, second)) + " elements in " +
                      std::to_string(bytes_.size()) + " bytes");
    }
    return Ok();
  }

 private:
  int Byte() {
    const int value = at_ < bytes_.size() ? static_cast<unsigned char>(bytes_[at_]) : 0;
    ++at_;
    return value;
  }
  std::uint64_t Varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const int byte = Byte();
      value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if ((byte & 0x80) == 0) break;
    }
    return value;
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
};

Result<std::unique_ptr<draco::Mesh>> DecodeMesh(std::string_view bytes) {
  const Status header = HeaderReader(bytes).Check();
  if (!header) return header.error();
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return Unusable(decoded.status().error_msg_string());
  std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& p : mesh->face(f)) {
      if (p.value() >= mesh->num_points()) return Unusable("face index out of range");
    }
  }
  return mesh;
}

// Converted values of an attribute for every point, with bounds checked. Draco reads truth values
// as they lie in the file, where any byte may stand for one; glTF knows none.
template <typename T, std::size_t N>
bool ReadAttribute(const draco::Mesh& mesh,
                   const draco::PointAttribute& attribute,
                   std::vector<std::array<T, N>>& values) {
  if (attribute.data_type() == draco::DT_BOOL) return false;
  values.reserve(mesh.num_points());
  for (draco::PointIndex p(0); p < mesh.num_points(); ++p) {
    const draco::AttributeValueIndex index = attribute.mapped_index(p);
    if (index.value() >= attribute.size()) return false;
    std::array<T, N> value{};
    if (!attribute.ConvertValue<T>(index, static_cast<std::int8_t>(N), value.data())) return false;
    values.push_back(value);
  }
  return true;
}

template <int N>
using Vectors = std::vector<Eigen::Matrix<float, N, 1>>;

// The first N numbers of every point.
template <int N>
bool ReadVectors(const draco::Mesh& mesh,
                 const draco::PointAttribute& attribute,
                 Vectors<N>& vectors) {
  std::vector<std::array<float, N>> values;
  if (!ReadAttribute(mesh, attribute, values)) return false;
  vectors.reserve(values.size());
  for (const auto& value : values) vectors.emplace_back(value.data());
  return true;
}

Result<Vectors<3>> ReadDirections(const draco::Mesh& mesh,
                                  const draco::PointAttribute* attribute,
                                  const std::string& name,
                                  bool strict) {
  Vectors<3> vectors;
  const bool known = attribute != nullptr && attribute->num_components() == 3 &&
                     (!strict || attribute->data_type() == draco::DT_FLOAT32);
  if (!known || !ReadVectors<3>(mesh, *attribute, vectors)) {
    return Unusable("no " + name + " of three " + (strict ? "floats" : "numbers"));
  }
  const auto is_finite = [](const Eigen::Vector3f& v) { return v.allFinite(); };
  if (strict && !std::ranges::all_of(vectors, is_finite)) return Unusable(name + " not finite");
  return vectors;
}

std::vector<std::array<std::uint32_t, 3>> ReadFaces(const draco::Mesh& mesh) {
  std::vector<std::array<std::uint32_t, 3>> faces;
  faces.reserve(mesh.num_faces());
  for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(f);
    faces.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return faces;
}

}  // namespace

Result<DracoMesh> DracoDecode(std::string_view bytes, const DracoAttributeIds& ids) {
  const Result<std::unique_ptr<draco::Mesh>> decoded = DecodeMesh(bytes);
  if (!decoded) return decoded.error();
  const draco::Mesh& source = **decoded;
  const auto attribute = [&](int id) -> const draco::PointAttribute* {
    return id < 0 ? nullptr : source.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
  };
  DracoMesh mesh;
  Result<Vectors<3>> positions =
      ReadDirections(source, attribute(ids.position), "POSITION", ids.strict);
  if (!positions) return positions.error();
  mesh.positions = std::move(*positions);
  if (ids.normal >= 0) {
    Result<Vectors<3>> normals =
        ReadDirections(source, attribute(ids.normal), "NORMAL", ids.strict);
    if (!normals) return normals.error();
    mesh.normals = std::move(*normals);
  }
  for (const int other : ids.others) {
    std::vector<std::array<float, 4>> values;
    const draco::PointAttribute* const found = attribute(other);
    if (found == nullptr || found->num_components() > 4 || !ReadAttribute(source, *found, values))
      return Unusable("no attribute " + std::to_string(other) + " of one to four numbers");
  }
  const draco::PointAttribute* const place = attribute(ids.place);
  if (place == nullptr || place->num_components() != 2 ||
      !ReadVectors<2>(source, *place, mesh.places))
    mesh.places.clear();
  const draco::PointAttribute* const colour = attribute(ids.colour);
  if (colour == nullptr || colour->num_components() < 3 ||
      !ReadVectors<3>(source, *colour, mesh.colours))
    mesh.colours.clear();
  mesh.faces = ReadFaces(source);
  return mesh;
}

}  // namespace deepslam::gltf
