#include "deepslam/artifact/map_json.h"

#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/scene_json.h"
#include "deepslam/core/base64.h"

namespace deepslam::artifact {

constexpr JsonFormat kFormat{"deepslam/map", 4};
constexpr double kMinStretch = 0.01;
constexpr double kMaxStretch = 100;
constexpr Range kLatent{-1e6, 1e6};
constexpr std::size_t kMaxOutlinePoints = 100'000;
constexpr Range kPlaceM{-1e5, 1e5};

namespace {

void DescribeVoxels(JsonVisitor& visitor, std::string& code) {
  std::string base64 = EncodeBase64(code);
  if (!visitor.Maybe("voxels_base64", base64, !code.empty()) || !visitor.reading()) return;
  Result<std::string> bytes = DecodeBase64(base64);
  if (bytes.ok()) {
    code = std::move(bytes).value();
  } else {
    visitor.Fail("voxels_base64", ": " + bytes.error().message);
  }
}

}  // namespace

void Describe(JsonVisitor& visitor, CompactShape& shape) {
  visitor.Maybe("latents", shape.latents, !shape.latents.empty(), kLatent);
  if (visitor.Maybe("library_id", shape.library_id, !shape.library_id.empty())) {
    visitor.Field("library_checksum", shape.library_checksum);
    visitor.Maybe("stretch", shape.stretch, shape.stretch != Eigen::Vector3d::Ones());
    if (!(shape.stretch.array() >= kMinStretch && shape.stretch.array() <= kMaxStretch).all())
      visitor.Fail("stretch", fmt::format("must lie in [{}, {}]", kMinStretch, kMaxStretch));
    visitor.Maybe("voxels_checksum", shape.voxels_checksum, !shape.voxels_checksum.empty());
  }
  DescribeVoxels(visitor, shape.voxel_code);
}

void Describe(JsonVisitor& visitor, CompactObject& object) {
  visitor.Field("id", object.id);
  visitor.Field("name", object.name);
  visitor.Field("class", object.class_name);
  visitor.Field("confidence", object.confidence, kShare);
  visitor.Field("source", object.source);
  visitor.Field("world_from_object", object.world_from_object);
  visitor.Field("scale_m", object.scale_m, kSizeM);
  visitor.Field("size_m", object.size_m);
  visitor.Field("credit", object.credit);
  visitor.Field("note", object.note);
  visitor.Field("shape", object.shape);
}

namespace {

// x and y in turn: an array of its own for every point would cost as much as its numbers.
void DescribeOutline(JsonVisitor& visitor, std::vector<Eigen::Vector2d>& outline_m) {
  std::vector<double> numbers;
  for (const Eigen::Vector2d& p : outline_m) numbers.insert(numbers.end(), {p.x(), p.y()});
  visitor.Field("ground_outline_m", numbers, kPlaceM);
  if (!visitor.reading()) return;
  if (numbers.size() > 2 * kMaxOutlinePoints) {
    return visitor.Fail("ground_outline_m",
                        fmt::format("has more than {} points", kMaxOutlinePoints));
  }
  if (numbers.size() % 2 != 0) return visitor.Fail("ground_outline_m", "must hold x and y in turn");
  for (std::size_t n = 0; n < numbers.size(); n += 2)
    outline_m.emplace_back(numbers[n], numbers[n + 1]);
}

}  // namespace

void Describe(JsonVisitor& visitor, Verdict& verdict) { visitor.Choice(verdict, kVerdictNames); }

void Describe(JsonVisitor& visitor, CompactMap& map) {
  visitor.Field("tool_version", map.tool_version);
  visitor.Field("capture_name", map.capture_name);
  visitor.Field("capture_hash", map.capture_hash);
  visitor.Maybe("ground_world", map.ground_world);
  DescribeOutline(visitor, map.ground_outline_m);
  visitor.Field("class_colours", map.class_colours);
  visitor.Field("mesh_options", map.mesh_options);
  visitor.Field("verdict", map.verdict);
  visitor.Field("reasons", map.reasons);
  visitor.Field("objects", map.objects);
}

Result<std::string> EncodeMap(const CompactMap& map, std::string_view name) {
  return EncodeDocument(kFormat, map, name);
}

Result<CompactMap> DecodeMap(TextSource text, std::string_view name) {
  return DecodeDocument<CompactMap>(kFormat, std::move(text), name);
}

}  // namespace deepslam::artifact
