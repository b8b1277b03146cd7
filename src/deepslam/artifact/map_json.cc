#include "deepslam/artifact/map_json.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/scene_json.h"
#include "deepslam/core/base64.h"

namespace deepslam::artifact {
namespace {

constexpr std::string_view kFormat = "deepslam/map";
constexpr int kVersion = 4;
constexpr double kMinStretch = 0.01;
constexpr double kMaxStretch = 100;
constexpr std::size_t kMaxOutlinePoints = 100'000;
constexpr double kMaxPlaceM = 1e5;

JsonValue ShapeToJson(const CompactShape& shape) {
  JsonObject row;
  if (!shape.latents.empty()) {
    JsonArray latents;
    for (const float latent : shape.latents) latents.emplace_back(latent);
    row.emplace("latents", std::move(latents));
  }
  if (!shape.library_id.empty()) {
    row.emplace("library_id", shape.library_id);
    row.emplace("library_checksum", shape.library_checksum);
    if (shape.stretch != Eigen::Vector3d::Ones()) row.emplace("stretch", ToJson(shape.stretch));
    if (!shape.voxels_checksum.empty()) row.emplace("voxels_checksum", shape.voxels_checksum);
  }
  if (!shape.voxel_code.empty()) row.emplace("voxels_base64", EncodeBase64(shape.voxel_code));
  return JsonValue(std::move(row));
}

CompactShape ReadShape(const JsonNode& node) {
  CompactShape shape;
  if (const JsonNode latents = node.Maybe("latents"); latents.exists()) {
    for (const JsonNode& latent : latents.Items()) {
      shape.latents.push_back(static_cast<float>(latent.Number(-1e6, 1e6)));
    }
  }
  if (const JsonNode id = node.Maybe("library_id"); id.exists()) {
    shape.library_id = id.String();
    shape.library_checksum = node["library_checksum"].String();
    if (const JsonNode stretch = node.Maybe("stretch"); stretch.exists()) {
      shape.stretch = ReadVector3(stretch);
      if (!(shape.stretch.array() >= kMinStretch && shape.stretch.array() <= kMaxStretch).all()) {
        stretch.Fail(fmt::format("must lie in [{}, {}]", kMinStretch, kMaxStretch));
      }
    }
    if (const JsonNode sum = node.Maybe("voxels_checksum"); sum.exists()) {
      shape.voxels_checksum = sum.String();
    }
  }
  if (const JsonNode voxels = node.Maybe("voxels_base64"); voxels.exists()) {
    Result<std::string> bytes = DecodeBase64(voxels.String());
    if (bytes.ok()) {
      shape.voxel_code = std::move(bytes).value();
    } else {
      voxels.Fail(": " + bytes.error().message);
    }
  }
  return shape;
}

JsonValue EntryToJson(const CompactObject& entry) {
  JsonObject row;
  row.emplace("id", ToJson(entry.id));
  row.emplace("name", entry.name);
  row.emplace("class", entry.class_name);
  row.emplace("confidence", entry.confidence);
  row.emplace("source", NameOf(entry.source));
  row.emplace("world_from_object", ToJson(entry.world_from_object));
  row.emplace("scale_m", entry.scale_m);
  row.emplace("size_m", ToJson(entry.size_m));
  row.emplace("credit", entry.credit);
  row.emplace("note", entry.note);
  row.emplace("shape", ShapeToJson(entry.shape));
  return JsonValue(std::move(row));
}

CompactObject ReadEntry(const JsonNode& row) {
  CompactObject entry;
  entry.id = ReadId<ObjectId>(row["id"]);
  entry.name = row["name"].String();
  entry.class_name = row["class"].String();
  entry.confidence = row["confidence"].Number(0, 1);
  entry.source = ReadCandidateSource(row["source"]);
  entry.world_from_object = ReadPose(row["world_from_object"]);
  entry.scale_m = row["scale_m"].Number(0, 1e3);
  entry.size_m = ReadVector3(row["size_m"]);
  entry.credit = row["credit"].String();
  entry.note = row["note"].String();
  entry.shape = ReadShape(row["shape"]);
  return entry;
}

// x and y in turn: an array of its own for every point would cost as much as its numbers.
JsonValue OutlineToJson(const CompactMap& map) {
  JsonArray outline;
  for (const Eigen::Vector2d& p : map.ground_outline_m) {
    outline.emplace_back(p.x());
    outline.emplace_back(p.y());
  }
  return JsonValue(std::move(outline));
}

void ReadGroundOutline(const JsonNode& node, CompactMap& map) {
  const std::vector<JsonNode> numbers = node.Items();
  if (numbers.size() > 2 * kMaxOutlinePoints) {
    return node.Fail(fmt::format("has more than {} points", kMaxOutlinePoints));
  }
  if (numbers.size() % 2 != 0) return node.Fail("must hold x and y in turn");
  for (std::size_t n = 0; n < numbers.size(); n += 2) {
    map.ground_outline_m.emplace_back(numbers[n].Number(-kMaxPlaceM, kMaxPlaceM),
                                      numbers[n + 1].Number(-kMaxPlaceM, kMaxPlaceM));
  }
}

JsonValue ColoursToJson(const std::map<std::string, Rgb8>& colours) {
  JsonObject rows;
  for (const auto& [name, colour] : colours) {
    JsonArray channels;
    for (const int channel : {colour.r, colour.g, colour.b}) channels.emplace_back(channel);
    rows.emplace(name, std::move(channels));
  }
  return JsonValue(std::move(rows));
}

void ReadColours(const JsonNode& node, CompactMap& map) {
  for (const auto& [name, row] : node.Members()) {
    const std::vector<JsonNode> channels = row.Items(3);
    const auto channel = [&](std::size_t n) {
      return static_cast<std::uint8_t>(channels[n].Int(0, 255));
    };
    map.class_colours[name] = {channel(0), channel(1), channel(2)};
  }
}

Verdict ReadVerdict(const JsonNode& node) {
  const std::string text = node.String();
  for (std::size_t i = 0; i < kVerdictNames.size(); ++i) {
    if (kVerdictNames[i] == text) return static_cast<Verdict>(i);
  }
  node.Fail("must be good, doubtful or bad");
  return Verdict::kBad;
}

}  // namespace

Result<std::string> EncodeMap(const CompactMap& map, std::string_view name) {
  JsonObject document = NewDocument(kFormat, kVersion);
  document.emplace("tool_version", map.tool_version);
  document.emplace("capture_name", map.capture_name);
  document.emplace("capture_hash", map.capture_hash);
  document.emplace("ground_world", map.ground_world ? ToJson(*map.ground_world) : JsonValue());
  document.emplace("ground_outline_m", OutlineToJson(map));
  document.emplace("class_colours", ColoursToJson(map.class_colours));
  JsonObject mesh_options;
  for (const auto& [option, value] : map.mesh_options) mesh_options.emplace(option, value);
  document.emplace("mesh_options", std::move(mesh_options));
  document.emplace("verdict", NameOf(map.verdict));
  JsonArray reasons;
  for (const std::string& reason : map.reasons) reasons.emplace_back(reason);
  JsonArray objects;
  for (const CompactObject& entry : map.objects) objects.push_back(EntryToJson(entry));
  document.emplace("reasons", std::move(reasons));
  document.emplace("objects", std::move(objects));
  return DumpJson(std::move(document), name);
}

Result<CompactMap> DecodeMap(TextSource text, std::string_view name) {
  JsonReader reader(std::move(text), name, kFormat, kVersion);
  const JsonNode root = reader.root();
  CompactMap map;
  map.tool_version = root["tool_version"].String();
  map.capture_name = root["capture_name"].String();
  map.capture_hash = root["capture_hash"].String();
  if (const JsonNode ground = root.Maybe("ground_world"); ground.exists())
    map.ground_world = ReadPlane(ground);
  ReadGroundOutline(root["ground_outline_m"], map);
  ReadColours(root["class_colours"], map);
  for (const auto& [option, value] : root["mesh_options"].Members()) {
    map.mesh_options[option] = value.String();
  }
  map.verdict = ReadVerdict(root["verdict"]);
  for (const JsonNode& reason : root["reasons"].Items()) map.reasons.push_back(reason.String());
  for (const JsonNode& row : root["objects"].Items()) map.objects.push_back(ReadEntry(row));
  return reader.Finish(std::move(map));
}

}  // namespace deepslam::artifact
