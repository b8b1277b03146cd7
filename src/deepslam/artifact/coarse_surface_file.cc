#include "deepslam/artifact/coarse_surface_file.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/artifact/ply.h"

namespace deepslam::artifact {
namespace {

static_assert(std::endian::native == std::endian::little,
              "space.bin is written in the machine's byte order");

constexpr std::string_view kFormat = "deepslam space ";
constexpr std::string_view kVersion = "1\n";
constexpr double kMaxVoxel_m = 1000;  // a file that claims larger ones is damaged
// A run each for what passed and what was blind: no block is shorter.
constexpr std::size_t kMinBlockBytes = 3 * sizeof(std::int32_t) + 2 * 3;

using Counts = std::array<std::uint8_t, SpaceBlock::kVoxels>;

template <typename T>
void Append(const T& value, std::string& bytes) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

void AppendRuns(const Counts& counts, std::string& bytes) {
  std::size_t begin = 0;
  while (begin < counts.size()) {
    std::size_t end = begin + 1;
    while (end < counts.size() && counts[end] == counts[begin]) ++end;
    Append(counts[begin], bytes);
    Append(static_cast<std::uint16_t>(end - begin), bytes);
    begin = end;
  }
}

// Takes values off the front of bytes; what is not there is 0, and the reader no longer good.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  template <typename T>
  T Take() {
    T value{};
    if (rest_.size() < sizeof(T)) {
      good_ = false;
      rest_ = {};
      return value;
    }
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_.remove_prefix(sizeof(T));
    return value;
  }
  // A number of things, each of so many bytes at least.
  std::size_t TakeCount(std::size_t min_bytes) {
    const auto count = std::size_t{Take<std::uint32_t>()};
    if (count <= rest_.size() / min_bytes) return count;
    good_ = false;
    return 0;
  }
  void Fail() { good_ = false; }
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
  bool good_ = true;
};

void TakeRuns(ByteReader& reader, Counts& counts) {
  std::size_t begin = 0;
  while (begin < counts.size() && reader.good()) {
    const auto value = reader.Take<std::uint8_t>();
    const auto length = std::size_t{reader.Take<std::uint16_t>()};
    if (length == 0 || length > counts.size() - begin) return reader.Fail();
    std::memset(counts.data() + begin, value, length);
    begin += length;
  }
}

Pose3 TakePose(ByteReader& reader) {
  Pose3 pose;
  for (int axis = 0; axis < 3; ++axis) pose.translation_m[axis] = reader.Take<double>();
  for (int n = 0; n < 4; ++n) pose.rotation.coeffs()[n] = reader.Take<double>();
  constexpr double kUnit = 1e-6;  // of rounding when it was written
  const bool usable =
      pose.translation_m.allFinite() && std::abs(pose.rotation.coeffs().squaredNorm() - 1) < kUnit;
  if (!usable) reader.Fail();
  return pose;
}

std::vector<SpaceBlock> TakeBlocks(ByteReader& reader) {
  const std::size_t count = reader.TakeCount(kMinBlockBytes);
  std::vector<SpaceBlock> blocks;
  for (std::size_t n = 0; n < count && reader.good(); ++n) {
    SpaceBlock block;
    for (int axis = 0; axis < 3; ++axis) block.index[axis] = reader.Take<std::int32_t>();
    if (!blocks.empty() && !ObservedSpace::IsBefore(blocks.back().index, block.index))
      reader.Fail();
    TakeRuns(reader, block.passed);
    TakeRuns(reader, block.blind);
    blocks.push_back(block);
  }
  return blocks;
}

Status DecodeSpace(std::string_view bytes, std::string_view name, CoarseSurface& surface) {
  if (!bytes.starts_with(kFormat))
    return InvalidInput(fmt::format("{}: is no deepslam space", name));
  bytes.remove_prefix(kFormat.size());
  if (!bytes.starts_with(kVersion)) {
    return InvalidInput(
        fmt::format("{}: is of another version than 1; run the stage that wrote it again", name));
  }
  bytes.remove_prefix(kVersion.size());
  ByteReader reader(bytes);
  surface.voxel_m = reader.Take<double>();
  if (!(surface.voxel_m > 0 && surface.voxel_m < kMaxVoxel_m)) reader.Fail();
  surface.level_from_tracking = TakePose(reader);
  surface.has_ground = reader.Take<std::uint8_t>() != 0;
  surface.viewpoints.resize(reader.TakeCount(3 * sizeof(float)));
  for (Eigen::Vector3f& viewpoint : surface.viewpoints) {
    for (int axis = 0; axis < 3; ++axis) viewpoint[axis] = reader.Take<float>();
    if (!viewpoint.allFinite()) reader.Fail();
  }
  std::vector<SpaceBlock> blocks = TakeBlocks(reader);
  if (!reader.good() || !reader.at_end()) {
    return InvalidInput(
        fmt::format("{}: is damaged; run the stage that wrote it again with --force", name));
  }
  surface.space = ObservedSpace(surface.voxel_m, std::move(blocks));
  return Ok();
}

}  // namespace

Result<std::string> EncodeSurfaceMesh(const CoarseSurface& surface, std::string_view name) {
  return EncodePly({surface.mesh, surface.normals, surface.num_frames}, name);
}

std::string EncodeSpace(const CoarseSurface& surface) {
  std::string bytes(kFormat);
  bytes += kVersion;
  Append(surface.voxel_m, bytes);
  for (int axis = 0; axis < 3; ++axis)
    Append(surface.level_from_tracking.translation_m[axis], bytes);
  for (int n = 0; n < 4; ++n) Append(surface.level_from_tracking.rotation.coeffs()[n], bytes);
  Append(std::uint8_t{surface.has_ground}, bytes);
  Append(static_cast<std::uint32_t>(surface.viewpoints.size()), bytes);
  for (const Eigen::Vector3f& viewpoint : surface.viewpoints) {
    for (int axis = 0; axis < 3; ++axis) Append(viewpoint[axis], bytes);
  }
  Append(static_cast<std::uint32_t>(surface.space.blocks().size()), bytes);
  for (const SpaceBlock& block : surface.space.blocks()) {
    for (int axis = 0; axis < 3; ++axis) Append(std::int32_t{block.index[axis]}, bytes);
    AppendRuns(block.passed, bytes);
    AppendRuns(block.blind, bytes);
  }
  return bytes;
}

Result<CoarseSurface> DecodeCoarseSurface(std::string_view mesh_bytes,
                                          std::string_view mesh_name,
                                          std::string_view space_bytes,
                                          std::string_view space_name) {
  Result<PlyMesh> ply = DecodePly(mesh_bytes, mesh_name);
  if (!ply.ok()) return ply.error();
  CoarseSurface surface;
  if (Status status = DecodeSpace(space_bytes, space_name, surface); !status) return status.error();
  surface.mesh = std::move(ply->mesh);
  surface.normals = std::move(ply->normals);
  surface.num_frames = std::move(ply->labels);
  const std::size_t num_vertices = surface.mesh.vertices.size();
  if (surface.normals.size() != num_vertices || surface.num_frames.size() != num_vertices) {
    return InvalidInput(
        fmt::format("{}: has no normals or labels; run the stage that wrote it again", mesh_name));
  }
  return surface;
}

}  // namespace deepslam::artifact
