#include "deepslam/gltf/draco_mesh.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/encoder_buffer.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <set>
#include <vector>

namespace deepslam::gltf {
namespace {

// A byte of Draco holds far fewer faces than this even on a regular grid; more is a lie that would
// cost memory.
constexpr std::uint64_t kMaxFacesPerByte = 64;
constexpr std::uint64_t kMaxFaces = 50'000'000;
// Slower encoding for fewer bytes: a scene is written once. Draco's scale is 0 (smallest) to 10.
constexpr int kEncodingSpeed = 3;
constexpr int kDecodingSpeed = 5;

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

Result<std::vector<Eigen::Vector3f>> ReadVectors(const draco::Mesh& mesh,
                                                 const draco::PointAttribute* attribute,
                                                 const std::string& name) {
  if (attribute == nullptr || attribute->num_components() != 3 ||
      attribute->data_type() != draco::DT_FLOAT32) {
    return Unusable("no " + name + " of three floats");
  }
  std::vector<std::array<float, 3>> values;
  if (!ReadAttribute(mesh, *attribute, values)) return Unusable(name + " out of range");
  std::vector<Eigen::Vector3f> result;
  result.reserve(values.size());
  for (const auto& v : values) {
    result.emplace_back(v[0], v[1], v[2]);
    if (!result.back().allFinite()) return Unusable(name + " not finite");
  }
  return result;
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

Result<std::string> EncodeMesh(
    const draco::Mesh& mesh, const Grid& grid, int position_bits, int normal_id, int normal_bits) {
  draco::ExpertEncoder encoder(mesh);
  encoder.SetSpeedOptions(kEncodingSpeed, kDecodingSpeed);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeExplicitQuantization(0, position_bits, 3, grid.origin.data(), grid.range);
  if (normal_id >= 0) encoder.SetAttributeQuantization(normal_id, normal_bits);
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

}  // namespace

double QuantisationError(const TriangleMesh& mesh, int position_bits) {
  if (mesh.vertices.empty()) return 0;
  const Grid grid = GridOf(mesh.vertices);
  const double range = static_cast<double>(grid.range);
  const double largest = static_cast<double>(grid.origin.cwiseAbs().maxCoeff()) + range;
  // Half a step of the grid, and the rounding of floats in Draco's own arithmetic.
  constexpr double kFloatRounding = 4.0 / (1 << 23);
  return 0.5 * range / (std::pow(2.0, position_bits) - 1.0) + kFloatRounding * largest;
}

Result<DracoPayload> DracoEncodeForGltf(const RenderMesh& mesh,
                                        int position_bits,
                                        int normal_bits,
                                        bool keep_apart) {
  const Status bits_ok = CheckBits(position_bits);
  if (!bits_ok) return bits_ok.error();
  if (mesh.faces.empty()) return Unusable("an empty mesh cannot be encoded");
  draco::Mesh source;
  SetFaces(source, mesh.positions.size(), mesh.faces);
  using Attribute = draco::GeometryAttribute;
  const int position_id = AddAttribute(
      source, Attribute::POSITION, draco::DT_FLOAT32, 3, false, Pointers(mesh.positions));
  DracoPayload payload;
  int normal_id = -1;
  int colour_id = -1;
  if (!mesh.normals.empty()) {
    normal_id = AddAttribute(
        source, Attribute::NORMAL, draco::DT_FLOAT32, 3, false, Pointers(mesh.normals));
  }
  if (!mesh.colours.empty()) {
    colour_id =
        AddAttribute(source, Attribute::COLOR, draco::DT_UINT16, 4, true, Pointers(mesh.colours));
  }
  // Vertices doubled at creases share one position value: connectivity, and so closedness, is kept
  // by Draco itself.
  if (!source.DeduplicateAttributeValues()) return Failed("Draco: values not deduplicated");
  const auto unique_id = [&](int id) {
    return id < 0 ? -1 : static_cast<int>(source.attribute(id)->unique_id());
  };
  payload.position_id = unique_id(position_id);
  payload.normal_id = unique_id(normal_id);
  payload.colour_id = unique_id(colour_id);
  const Grid grid = GridOf(mesh.positions);
  const std::size_t num_places = keep_apart ? NumPlaces(mesh.positions, mesh.faces) : 0;
  for (int bits = position_bits; bits <= kMaxPositionBits; ++bits) {
    Result<std::string> bytes = EncodeMesh(source, grid, bits, normal_id, normal_bits);
    if (!bytes) return bytes.error();
    Result<RenderMesh> decoded =
        DracoDecodeForGltf(*bytes, payload.position_id, payload.normal_id, payload.colour_id);
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

Result<RenderMesh> DracoDecodeForGltf(std::string_view bytes,
                                      int position_id,
                                      int normal_id,
                                      int colour_id) {
  const Result<std::unique_ptr<draco::Mesh>> mesh = DecodeMesh(bytes);
  if (!mesh) return mesh.error();
  const draco::Mesh& source = **mesh;
  const auto attribute = [&](int id) {
    return source.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
  };
  RenderMesh result;
  Result<std::vector<Eigen::Vector3f>> positions =
      ReadVectors(source, attribute(position_id), "POSITION");
  if (!positions) return positions.error();
  result.positions = std::move(*positions);
  if (normal_id >= 0) {
    Result<std::vector<Eigen::Vector3f>> normals =
        ReadVectors(source, attribute(normal_id), "NORMAL");
    if (!normals) return normals.error();
    result.normals = std::move(*normals);
  }
  if (colour_id >= 0) {
    const draco::PointAttribute* colours = attribute(colour_id);
    if (colours == nullptr || colours->num_components() != 4 ||
        colours->data_type() != draco::DT_UINT16 ||
        !ReadAttribute(source, *colours, result.colours)) {
      return Unusable("no COLOR_0 of four 16-bit numbers");
    }
  }
  result.faces = ReadFaces(source);
  return result;
}

Result<DracoModel> DracoDecodeModel(std::string_view bytes, const DracoAttributeIds& ids) {
  const Result<std::unique_ptr<draco::Mesh>> mesh = DecodeMesh(bytes);
  if (!mesh) return mesh.error();
  const draco::Mesh& source = **mesh;
  const auto attribute = [&](int id) -> const draco::PointAttribute* {
    return id < 0 ? nullptr : source.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
  };
  DracoModel model;
  const draco::PointAttribute* position = attribute(ids.position);
  std::vector<std::array<float, 3>> positions;
  if (position == nullptr || position->num_components() != 3 ||
      !ReadAttribute(source, *position, positions)) {
    return Unusable("no POSITION of three numbers");
  }
  for (const auto& p : positions) model.positions.emplace_back(p[0], p[1], p[2]);
  std::vector<std::array<float, 2>> places;
  if (const draco::PointAttribute* place = attribute(ids.place);
      place != nullptr && place->num_components() == 2 && ReadAttribute(source, *place, places)) {
    for (const auto& p : places) model.places.emplace_back(p[0], p[1]);
  }
  std::vector<std::array<float, 3>> colours;
  if (const draco::PointAttribute* colour = attribute(ids.colour);
      colour != nullptr && colour->num_components() >= 3 &&
      ReadAttribute(source, *colour, colours)) {
    for (const auto& c : colours) model.colours.emplace_back(c[0], c[1], c[2]);
  }
  model.faces = ReadFaces(source);
  return model;
}

Result<std::string> DracoEncode(const TriangleMesh& mesh, int position_bits) {
  const Status bits_ok = CheckBits(position_bits);
  if (!bits_ok) return bits_ok.error();
  if (mesh.faces.empty()) return Unusable("an empty mesh cannot be encoded");
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t v : face) {
      if (v >= mesh.vertices.size()) return Unusable("face index out of range");
    }
  }
  if (!std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [](const Eigen::Vector3f& p) {
        return p.allFinite();
      })) {
    return Unusable("a vertex is not finite");
  }
  draco::Mesh source;
  SetFaces(source, mesh.vertices.size(), mesh.faces);
  using Attribute = draco::GeometryAttribute;
  AddAttribute(source, Attribute::POSITION, draco::DT_FLOAT32, 3, false, Pointers(mesh.vertices));
  if (mesh.colours.size() == mesh.vertices.size()) {
    AddAttribute(source, Attribute::COLOR, draco::DT_UINT8, 3, true, Pointers(mesh.colours));
  }
  if (!source.DeduplicateAttributeValues()) return Failed("Draco: values not deduplicated");
  const Grid grid = GridOf(mesh.vertices);
  const std::size_t num_places = NumPlaces(mesh.vertices, mesh.faces);
  for (int bits = position_bits; bits <= kMaxPositionBits; ++bits) {
    Result<std::string> bytes = EncodeMesh(source, grid, bits, -1, 0);
    if (!bytes) return bytes.error();
    const Result<TriangleMesh> decoded = DracoDecode(*bytes);
    if (!decoded) return decoded.error();
    if (decoded->faces.size() != mesh.faces.size()) {
      return Unusable("faces with two corners at one place cannot be encoded");
    }
    if (NumPlaces(decoded->vertices, decoded->faces) == num_places) return bytes;
  }
  return Unusable("vertices lie closer together than the finest grid");
}

Result<TriangleMesh> DracoDecode(std::string_view bytes) {
  const Result<std::unique_ptr<draco::Mesh>> mesh = DecodeMesh(bytes);
  if (!mesh) return mesh.error();
  const draco::Mesh& source = **mesh;
  using Attribute = draco::GeometryAttribute;
  TriangleMesh result;
  Result<std::vector<Eigen::Vector3f>> positions =
      ReadVectors(source, source.GetNamedAttribute(Attribute::POSITION), "POSITION");
  if (!positions) return positions.error();
  result.vertices = std::move(*positions);
  const draco::PointAttribute* colours = source.GetNamedAttribute(Attribute::COLOR);
  if (colours != nullptr) {
    std::vector<std::array<std::uint8_t, 3>> values;
    if (colours->num_components() != 3 || colours->data_type() != draco::DT_UINT8 ||
        !ReadAttribute(source, *colours, values)) {
      return Unusable("colours are not three bytes each");
    }
    for (const auto& v : values) result.colours.push_back({v[0], v[1], v[2]});
  }
  result.faces = ReadFaces(source);
  return result;
}

}  // namespace deepslam::gltf
