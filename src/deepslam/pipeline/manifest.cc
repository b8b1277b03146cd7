#include "deepslam/pipeline/manifest.h"

#include <fmt/format.h>

#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/core/sha256.h"

namespace deepslam::pipeline {
namespace {

using artifact::JsonNode;
using artifact::JsonObject;
using artifact::JsonReader;
using artifact::JsonValue;

constexpr std::string_view kManifestFormat = "deepslam/manifest";
constexpr std::string_view kTimingFormat = "deepslam/timing";
constexpr int kVersion = 1;  // of both formats; raised when their fields change

JsonValue ToJson(const std::map<std::string, std::string>& values) {
  JsonObject object;
  for (const auto& [name, value] : values) object.emplace(name, value);
  return JsonValue(std::move(object));
}

std::map<std::string, std::string> ReadStrings(const JsonNode& node) {
  std::map<std::string, std::string> values;
  for (const auto& [name, value] : node.Members()) values.emplace(name, value.String());
  return values;
}

// Length before text: no two different lists give the same bytes.
void AppendField(std::string_view text, std::string& bytes) {
  bytes += fmt::format("{}:{};", text.size(), text);
}

void AppendMap(const std::map<std::string, std::string>& values, std::string& bytes) {
  bytes += fmt::format("{}(", values.size());
  for (const auto& [name, value] : values) {
    AppendField(name, bytes);
    AppendField(value, bytes);
  }
  bytes += ')';
}

}  // namespace

Result<std::string> EncodeManifest(const Manifest& manifest, std::string_view name) {
  JsonObject document = artifact::NewDocument(kManifestFormat, kVersion);
  document.emplace("stage", manifest.stage);
  document.emplace("stage_version", manifest.stage_version);
  document.emplace("key", Key(manifest));
  document.emplace("options", ToJson(manifest.options));
  document.emplace("inputs", ToJson(manifest.inputs));
  document.emplace("external_inputs", ToJson(manifest.external_inputs));
  JsonObject outputs;
  for (const auto& [file, output] : manifest.outputs) {
    JsonObject row;
    row.emplace("sha256", output.sha256);
    row.emplace("bytes", static_cast<std::int64_t>(output.num_bytes));
    outputs.emplace(file, std::move(row));
  }
  document.emplace("outputs", std::move(outputs));
  JsonObject figures;
  for (const auto& [figure, value] : manifest.summary.figures) figures.emplace(figure, value);
  document.emplace("summary", manifest.summary.line);
  document.emplace("figures", std::move(figures));
  return DumpJson(std::move(document), name);
}

Result<Manifest> DecodeManifest(std::string_view text, std::string_view name) {
  JsonReader reader(text, name, kManifestFormat, kVersion);
  const JsonNode root = reader.root();
  Manifest manifest;
  manifest.stage = root["stage"].String();
  manifest.stage_version = root["stage_version"].Int(0, 1'000'000);
  manifest.options = ReadStrings(root["options"]);
  manifest.inputs = ReadStrings(root["inputs"]);
  manifest.external_inputs = ReadStrings(root["external_inputs"]);
  for (const auto& [file, row] : root["outputs"].Members()) {
    manifest.outputs[file] = {row["sha256"].String(),
                              static_cast<std::uintmax_t>(row["bytes"].Number(0, 1e12))};
  }
  manifest.summary.line = root["summary"].String();
  for (const auto& [figure, value] : root["figures"].Members())
    manifest.summary.figures[figure] = value.Number();
  if (reader.ok() && root["key"].String() != Key(manifest))
    reader.Fail("key", "does not fit the document");
  return reader.Finish(std::move(manifest));
}

Result<std::string> EncodeTiming(const Timing& timing, std::string_view name) {
  JsonObject document = artifact::NewDocument(kTimingFormat, kVersion);
  document.emplace("wall_s", timing.wall_s);
  document.emplace("cpu_s", timing.cpu_s);
  document.emplace("peak_memory_mib", timing.peak_memory_mib);
  return DumpJson(std::move(document), name);
}

Result<Timing> DecodeTiming(std::string_view text, std::string_view name) {
  JsonReader reader(text, name, kTimingFormat, kVersion);
  const JsonNode root = reader.root();
  Timing timing{root["wall_s"].Number(), root["cpu_s"].Number(), root["peak_memory_mib"].Number()};
  return reader.Finish(timing);
}

std::string Key(const Manifest& manifest) {
  std::string bytes;
  AppendField(manifest.stage, bytes);
  AppendField(std::to_string(manifest.stage_version), bytes);
  AppendMap(manifest.options, bytes);
  AppendMap(manifest.inputs, bytes);
  AppendMap(manifest.external_inputs, bytes);
  return Sha256Hex(bytes);
}

std::string ContentHash(const std::map<std::string, OutputFile>& outputs) {
  std::map<std::string, std::string> hashes;
  for (const auto& [file, output] : outputs) hashes.emplace(file, output.sha256);
  std::string bytes;
  AppendMap(hashes, bytes);
  return Sha256Hex(bytes);
}

}  // namespace deepslam::pipeline
