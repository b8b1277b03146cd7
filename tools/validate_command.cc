#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/json_reader.h"
#include "deepslam/artifact/json_value.h"
#include "deepslam/artifact/map_json.h"
#include "deepslam/artifact/scene_json.h"
#include "deepslam/gltf/validate.h"
#include "deepslam/presentation/scene_check.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using artifact::JsonArray;
using artifact::JsonObject;
using artifact::JsonValue;

JsonValue Strings(const std::vector<std::string>& strings) {
  JsonArray array;
  for (const std::string& string : strings) array.emplace_back(string);
  return JsonValue(std::move(array));
}

JsonValue ToJson(const gltf::ValidationReport& report) {
  JsonObject document = artifact::NewDocument("deepslam/validation", 1);
  document.emplace("ok", report.ok());
  document.emplace("errors", Strings(report.errors));
  document.emplace("warnings", Strings(report.warnings));
  document.emplace("num_objects", report.num_objects);
  document.emplace("num_nodes", report.num_nodes);
  document.emplace("num_meshes", report.num_meshes);
  document.emplace("num_vertices", report.num_vertices);
  document.emplace("num_faces", report.num_faces);
  document.emplace("num_bytes", static_cast<std::int64_t>(report.num_bytes));
  document.emplace("draco", report.draco);
  document.emplace("has_ground", report.has_ground);
  document.emplace("has_room", report.has_room);
  document.emplace("has_trajectory", report.has_trajectory);
  JsonArray objects;
  for (const gltf::ValidatedObject& object : report.objects) {
    JsonObject row;
    row.emplace("name", object.name);
    row.emplace("class", object.class_name);
    row.emplace("instance", object.instance);
    row.emplace("size_m", artifact::ToJson(object.size_m));
    row.emplace("num_faces", object.num_faces);
    row.emplace("num_components", object.num_components);
    row.emplace("volume_m3", object.volume_m3);
    row.emplace("closed", object.closed);
    row.emplace("two_manifold", object.two_manifold);
    objects.emplace_back(std::move(row));
  }
  document.emplace("objects", std::move(objects));
  return JsonValue(std::move(document));
}

struct ValidateArguments {
  std::string file;
  std::string map;
  std::string json;
};

// The map that was named, else `map.json` beside the scene, else none.
Result<std::optional<CompactMap>> ReadMapOf(const ValidateArguments& arguments) {
  fs::path file = arguments.map;
  if (file.empty()) {
    file = fs::path(arguments.file).parent_path() / "map.json";
    std::error_code error;
    if (!fs::exists(file, error)) return std::optional<CompactMap>();
  }
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  Result<CompactMap> map = artifact::DecodeMap(*text, file.string());
  if (!map.ok()) return map.error();
  LogInfo(fmt::format("labels, places and sizes are held against {}", file.string()));
  return std::optional(std::move(map).value());
}

int Validate(const ValidateArguments& arguments) {
  const Result<std::string> bytes = storage::ReadFile(arguments.file);
  if (!bytes.ok()) return ReportError(bytes.error());
  const Result<std::optional<CompactMap>> map = ReadMapOf(arguments);
  if (!map.ok()) return ReportError(map.error());
  gltf::ValidationReport report = gltf::ValidateGlb(*bytes);
  if (report.ok() && *map) report.errors = presentation::CompareWithMap(report, **map);
  for (const std::string& warning : report.warnings)
    LogWarning(fmt::format("{}: {}", arguments.file, warning));
  for (const std::string& error : report.errors)
    LogError(fmt::format("{}: {}", arguments.file, error));
  const Result<std::string> text = DumpJson(ToJson(report), "validation");
  if (Status status = text.ok() ? WriteResult(arguments.json, *text) : Status(text.error());
      !status.ok()) {
    return ReportError(status.error());
  }
  return report.ok() ? kExitOk : kExitFailed;
}

}  // namespace

void AddValidate(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<ValidateArguments>();
  CLI::App* validate = app.add_subcommand(
      "validate", "Check a scene file: reread, decode, bounds, closedness, labels");
  validate->add_option("SCENE", arguments->file, "A .glb file")->required();
  validate->add_option("--map",
                       arguments->map,
                       "map.json to hold it against (default: the one beside the scene, if any)");
  validate->add_option(
      "--json", arguments->json, "Write the result here instead of to standard output");
  validate->callback(
      [&chosen, arguments] { chosen = [arguments] { return Validate(*arguments); }; });
}

}  // namespace deepslam::tools
