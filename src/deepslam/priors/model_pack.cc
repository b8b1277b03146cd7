#include "deepslam/priors/model_pack.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "deepslam/core/sha256.h"

namespace deepslam::priors {
namespace {

constexpr std::string_view kMagic = "DSMODELS";
constexpr std::uint32_t kVersion = 1;    // raised when the layout changes; older ones are read
constexpr std::size_t kHashLength = 64;  // hexadecimal
constexpr float kCornerSteps = 65535;    // along each side of a mesh's box
constexpr unsigned kBetweenArms = 1;     // bit of the flags: the model has a seat between arms
constexpr unsigned kColours = 2;         // bit of the flags: colours of vertices follow
// A bit a voxel.
constexpr std::size_t kGridBytes = std::size_t{kGridSize} * kGridSize * kGridSize / 8;

using Corner = std::array<std::uint16_t, 3>;  // a position in steps

struct RoundedMesh {
  Eigen::Vector3f low = Eigen::Vector3f::Zero();
  Eigen::Vector3f size = Eigen::Vector3f::Zero();
  std::vector<Corner> corners;
  std::vector<Rgb8> colours;
  std::vector<std::uint32_t> indices;  // three of each face; new corners in ascending order
};

Status CheckMesh(const PackedModel& model) {
  const TriangleMesh& mesh = model.mesh;
  for (const Eigen::Vector3f& p : mesh.vertices) {
    if (!p.allFinite()) return InvalidInput(model.id + ": a vertex is not finite");
  }
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t corner : face) {
      if (corner >= mesh.vertices.size())
        return InvalidInput(model.id + ": a face has a corner that is not there");
    }
  }
  if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size())
    return InvalidInput(model.id + ": colours are not one for each vertex");
  return Ok();
}

// Colours in 64 steps, which is finer than cameras' noise; 0 and 255 stay what they are.
unsigned StepOf(std::uint8_t value) { return value >> 2U; }
std::uint8_t ValueOf(unsigned step) { return static_cast<std::uint8_t>(step << 2U | step >> 4U); }

RoundedMesh RoundMesh(const TriangleMesh& mesh) {
  RoundedMesh rounded;
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : mesh.vertices) box.extend(p);
  if (!box.isEmpty()) {
    rounded.low = box.min();
    rounded.size = box.sizes();
  }
  std::map<std::tuple<Corner, std::uint8_t, std::uint8_t, std::uint8_t>, std::uint32_t> number;
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t vertex : face) {
      Corner corner{};
      for (int axis = 0; axis < 3; ++axis) {
        if (rounded.size[axis] > 0) {
          const float share =
              (mesh.vertices[vertex][axis] - rounded.low[axis]) / rounded.size[axis];
          corner[static_cast<std::size_t>(axis)] =
              static_cast<std::uint16_t>(std::lround(share * kCornerSteps));
        }
      }
      Rgb8 colour = mesh.colours.empty() ? Rgb8{} : mesh.colours[vertex];
      for (const auto channel : {&Rgb8::r, &Rgb8::g, &Rgb8::b})
        colour.*channel = ValueOf(StepOf(colour.*channel));
      const auto [place, is_new] =
          number.try_emplace({corner, colour.r, colour.g, colour.b},
                             static_cast<std::uint32_t>(rounded.corners.size()));
      if (is_new) {
        rounded.corners.push_back(corner);
        rounded.colours.push_back(colour);
      }
      rounded.indices.push_back(place->second);
    }
  }
  return rounded;
}

class Writer {
 public:
  template <typename T>
  void Value(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  void Byte(unsigned value) { bytes_ += static_cast<char>(static_cast<unsigned char>(value)); }
  void Bytes(std::string_view bytes) { bytes_ += bytes; }
  [[nodiscard]] bool Text(const std::string& text) {
    if (text.size() > std::numeric_limits<std::uint16_t>::max()) return false;
    Value(static_cast<std::uint16_t>(text.size()));
    bytes_ += text;
    return true;
  }
  void Number(std::uint32_t value) {
    for (; value >= 128; value >>= 7) Byte((value & 127U) | 128U);
    Byte(value);
  }
  [[nodiscard]] std::string Take() { return std::move(bytes_); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

void WriteCorners(const std::vector<Corner>& corners, Writer& writer) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const unsigned shift : {8U, 0U}) {
      unsigned before = 0;
      for (const Corner& corner : corners) {
        const unsigned difference = (corner[axis] - before) & 0xFFFFU;
        writer.Byte((difference >> shift) & 0xFFU);
        before = corner[axis];
      }
    }
  }
}

void WriteColours(const std::vector<Rgb8>& colours, Writer& writer) {
  for (const auto channel : {&Rgb8::r, &Rgb8::g, &Rgb8::b}) {
    unsigned before = 0;
    for (const Rgb8& colour : colours) {
      writer.Byte((StepOf(colour.*channel) - before) & 0x3FU);
      before = StepOf(colour.*channel);
    }
  }
}

void WriteFaces(const std::vector<std::uint32_t>& indices, Writer& writer) {
  std::uint32_t next = 0;
  for (const std::uint32_t index : indices) {
    writer.Number(next - index);
    if (index == next) ++next;
  }
}

Status WriteModel(const PackedModel& model, Writer& writer) {
  if (Status status = CheckMesh(model); !status) return status;
  for (const std::string* text :
       {&model.id, &model.class_name, &model.source, &model.split, &model.credit}) {
    if (!writer.Text(*text)) return InvalidInput(model.id.substr(0, 80) + ": a text is too long");
  }
  const RoundedMesh rounded = RoundMesh(model.mesh);
  const bool coloured = !model.mesh.colours.empty();
  writer.Byte((model.between_arms ? kBetweenArms : 0U) | (coloured ? kColours : 0U));
  for (int axis = 0; axis < 3; ++axis) writer.Value(rounded.low[axis]);
  for (int axis = 0; axis < 3; ++axis) writer.Value(rounded.size[axis]);
  writer.Value(static_cast<std::uint32_t>(rounded.corners.size()));
  writer.Value(static_cast<std::uint32_t>(model.mesh.faces.size()));
  WriteCorners(rounded.corners, writer);
  if (coloured) WriteColours(rounded.colours, writer);
  WriteFaces(rounded.indices, writer);
  return Ok();
}

void WriteShape(const VoxelGrid& shape, Writer& writer) {
  for (std::size_t n = 0; n < kGridBytes; ++n) {
    unsigned byte = 0;
    for (std::size_t bit = 0; bit < 8; ++bit) {
      if (shape.occupied[8 * n + bit] != 0) byte |= 0x80U >> bit;
    }
    writer.Byte(byte);
  }
}

// After a read past the end everything is zero and `short_` stands.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  std::string_view Bytes(std::size_t count) {
    if (count > bytes_.size()) {
      short_ = true;
      bytes_ = {};
      return {};
    }
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  template <typename T>
  T Value() {
    T value{};
    const std::string_view taken = Bytes(sizeof(T));
    if (taken.size() == sizeof(T)) std::memcpy(&value, taken.data(), sizeof(T));
    return value;
  }
  std::string Text() { return std::string(Bytes(Value<std::uint16_t>())); }
  std::optional<std::uint32_t> Number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const auto byte = Value<std::uint8_t>();
      value |= static_cast<std::uint64_t>(byte & 127U) << shift;
      if (byte < 128) break;
      if (shift == 28) return std::nullopt;
    }
    if (value > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
    return static_cast<std::uint32_t>(value);
  }
  [[nodiscard]] bool ended_early() const { return short_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
  bool short_ = false;
};

unsigned At(std::string_view bytes, std::size_t n) { return static_cast<unsigned char>(bytes[n]); }

void ReadVertices(const Eigen::Vector3f& low,
                  const Eigen::Vector3f& size,
                  Reader& reader,
                  std::vector<Eigen::Vector3f>& vertices) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view high_bytes = reader.Bytes(vertices.size());
    const std::string_view low_bytes = reader.Bytes(vertices.size());
    if (reader.ended_early()) return;
    unsigned step = 0;
    for (std::size_t n = 0; n < vertices.size(); ++n) {
      step = (step + (At(high_bytes, n) << 8U) + At(low_bytes, n)) & 0xFFFFU;
      vertices[n][axis] = low[axis] + size[axis] * (static_cast<float>(step) / kCornerSteps);
    }
  }
}

void ReadColours(std::size_t count, Reader& reader, std::vector<Rgb8>& colours) {
  colours.resize(count);
  for (const auto channel : {&Rgb8::r, &Rgb8::g, &Rgb8::b}) {
    const std::string_view bytes = reader.Bytes(count);
    if (reader.ended_early()) return;
    unsigned value = 0;
    for (std::size_t n = 0; n < count; ++n) {
      value = (value + At(bytes, n)) & 0x3FU;
      colours[n].*channel = ValueOf(value);
    }
  }
}

bool ReadFaces(std::size_t num_vertices, Reader& reader, TriangleMesh& mesh) {
  std::uint32_t next = 0;
  for (auto& face : mesh.faces) {
    for (std::uint32_t& corner : face) {
      const std::optional<std::uint32_t> below = reader.Number();
      if (!below || *below > next || next - *below >= num_vertices) return false;
      corner = next - *below;
      if (*below == 0) ++next;
    }
  }
  return true;
}

Error Damaged(const std::string& what) {
  return InvalidInput("model pack: " + what + "; make it anew with `deepslam priors pack`");
}

Result<PackedModel> ReadModel(Reader& reader) {
  PackedModel model;
  for (std::string* text :
       {&model.id, &model.class_name, &model.source, &model.split, &model.credit}) {
    *text = reader.Text();
  }
  const auto flags = reader.Value<std::uint8_t>();
  model.between_arms = (flags & kBetweenArms) != 0;
  Eigen::Vector3f low;
  Eigen::Vector3f size;
  for (int axis = 0; axis < 3; ++axis) low[axis] = reader.Value<float>();
  for (int axis = 0; axis < 3; ++axis) size[axis] = reader.Value<float>();
  const std::size_t num_vertices = reader.Value<std::uint32_t>();
  const std::size_t num_faces = reader.Value<std::uint32_t>();
  // What is there bounds what is asked for: six bytes a vertex, three a face.
  if (reader.ended_early() || num_vertices > reader.left() / 6 || num_faces > reader.left() / 3)
    return Damaged("ends early");
  if (!low.allFinite() || !size.allFinite()) return Damaged(model.id + " has no box");
  model.mesh.vertices.resize(num_vertices);
  model.mesh.faces.resize(num_faces);
  ReadVertices(low, size, reader, model.mesh.vertices);
  if ((flags & kColours) != 0) ReadColours(num_vertices, reader, model.mesh.colours);
  if (!ReadFaces(num_vertices, reader, model.mesh))
    return Damaged(model.id + " has a corner that is not there");
  if (reader.ended_early()) return Damaged("ends early");
  return model;
}

VoxelGrid ReadShape(std::string_view bits) {
  VoxelGrid shape;
  for (std::size_t n = 0; n < bits.size() * 8; ++n)
    shape.occupied[n] = (At(bits, n / 8) & (0x80U >> n % 8)) != 0 ? 1 : 0;
  return shape;
}

}  // namespace

Result<std::string> EncodeModelPack(const ModelPack& pack) {
  Writer writer;
  writer.Bytes(kMagic);
  writer.Value(kVersion);
  writer.Value(static_cast<std::uint32_t>(pack.models.size()));
  writer.Value(static_cast<std::uint32_t>(pack.withheld.size()));
  for (const PackedModel& model : pack.models) {
    if (Status status = WriteModel(model, writer); !status) return status.error();
  }
  for (const VoxelGrid& shape : pack.withheld) WriteShape(shape, writer);
  writer.Bytes(Sha256Hex(writer.bytes()));
  return writer.Take();
}

Result<ModelPack> DecodeModelPack(std::string_view bytes) {
  if (bytes.substr(0, kMagic.size()) != kMagic) return Damaged("not one");
  Reader reader(bytes.substr(kMagic.size()));
  if (const auto version = reader.Value<std::uint32_t>();
      !reader.ended_early() && version > kVersion) {
    return Damaged("of version " + std::to_string(version) + ", this program reads up to " +
                   std::to_string(kVersion));
  }
  if (bytes.size() < kMagic.size() + kHashLength) return Damaged("ends early");
  const std::string_view content = bytes.substr(0, bytes.size() - kHashLength);
  if (Sha256Hex(content) != bytes.substr(content.size()))
    return Damaged("cut short or changed (its checksum differs)");
  reader = Reader(content.substr(kMagic.size() + sizeof(kVersion)));
  const auto num_models = reader.Value<std::uint32_t>();
  const auto num_shapes = reader.Value<std::uint32_t>();
  ModelPack pack;
  for (std::uint32_t n = 0; n < num_models; ++n) {
    Result<PackedModel> model = ReadModel(reader);
    if (!model) return model.error();
    pack.models.push_back(std::move(*model));
  }
  for (std::uint32_t n = 0; n < num_shapes; ++n) {
    const std::string_view bits = reader.Bytes(kGridBytes);
    if (reader.ended_early()) return Damaged("ends early");
    pack.withheld.push_back(ReadShape(bits));
  }
  if (reader.left() != 0) return Damaged("longer than it says");
  return pack;
}

}  // namespace deepslam::priors
