#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/map_json.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/presentation/expand_map.h"
#include "deepslam/stages/config.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/export_elsewhere.h"
#include "deepslam/stages/mesh_options.h"
#include "deepslam/stages/plan.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

struct ExpandArguments {
  std::string map;
  std::string out;
  std::string simulator;
  std::string library;
  std::string data;
  bool uncompressed = false;
  bool physics = false;
};

struct Expanded {
  CompactMap map;
  gltf::GltfScene scene;
};

Result<CompactMap> ReadMap(const std::string& file) {
  const Result<std::string> text = storage::ReadFile(file);
  if (!text.ok()) return text.error();
  if (text->starts_with("glTF")) {
    return InvalidInput(fmt::format(
        "{}: is a glTF scene already; expand makes one from the map.json beside it", file));
  }
  return artifact::DecodeMap(*text, file);
}

Result<Expanded> Expand(const ExpandArguments& arguments) {
  Result<CompactMap> map = ReadMap(arguments.map);
  if (!map.ok()) return map.error();
  ModelLibrary library;
  if (presentation::NeedsLibrary(*map)) {
    const Result<std::filesystem::path> folder =
        stages::FindLibrary(stages::FindDataFolder(arguments.data), arguments.library);
    if (!folder.ok()) return folder.error();
    Result<ModelLibrary> loaded = library::LoadLibrary(*folder);
    if (!loaded.ok()) return loaded.error();
    library = std::move(loaded).value();
  }
  const auto in_map = [&](const Error& error) {
    return Error{error.code, fmt::format("{}: {}", arguments.map, error.message)};
  };
  const Result<mesh::ObjectMeshOptions> options = stages::MeshOptionsOf(*map);
  if (!options.ok()) return in_map(options.error());
  Result<gltf::GltfScene> scene =
      presentation::ExpandMap(*map, &library, *options, stages::kToolVersion);
  if (!scene.ok()) return in_map(scene.error());
  return Expanded{std::move(map).value(), std::move(scene).value()};
}

Status WriteIn(const std::filesystem::path& file, std::string_view bytes) {
  const Status made = storage::MakeFolders(file.parent_path());
  return made.ok() ? storage::WriteFileAtomically(file, bytes) : made;
}

// What stage export writes of the kind, under the names that were asked for.
Status WriteForOthers(const Expanded& expanded,
                      const ExpandArguments& arguments,
                      const std::string& usd_kind) {
  stages::Config config;
  config.export_stage.usd = usd_kind;
  config.export_stage.usd_physics = arguments.physics;
  config.export_stage.simulator = !arguments.simulator.empty();
  const Result<ClassTable> classes = stages::LoadClasses(config);
  if (!classes.ok()) return classes.error();
  std::vector<TriangleMesh> meshes;
  for (const gltf::GltfObject& object : expanded.scene.objects) meshes.push_back(object.mesh);
  constexpr std::string_view kFolder = "simulator/";
  return stages::WriteElsewhere(
      {expanded.scene, expanded.map, meshes, *classes},
      config,
      [&](std::string_view file, std::string_view bytes) {
        if (!file.starts_with(kFolder)) return storage::WriteFileAtomically(arguments.out, bytes);
        return WriteIn(std::filesystem::path(arguments.simulator) / file.substr(kFolder.size()),
                       bytes);
      });
}

Status WriteGlb(const Expanded& expanded, const ExpandArguments& arguments) {
  const Result<std::string> glb =
      gltf::WriteGlb(expanded.scene, {.draco = !arguments.uncompressed});
  return glb.ok() ? storage::WriteFileAtomically(arguments.out, *glb) : Status(glb.error());
}

int Run(const ExpandArguments& arguments) {
  const std::string ending = std::filesystem::path(arguments.out).extension().string();
  const bool is_usd = ending == ".usda" || ending == ".usdz";
  if (!is_usd && ending != ".glb") {
    return ReportError(InvalidConfig(fmt::format(
        "--output {}: is no scene that is written; end its name in .glb, .usda or .usdz",
        arguments.out)));
  }
  if (arguments.physics && !is_usd) {
    return ReportError(InvalidInput(fmt::format(
        "--physics is for .usda and .usdz, not for {}; --simulator DIR has it beside any scene",
        arguments.out)));
  }
  const Result<Expanded> expanded = Expand(arguments);
  if (!expanded.ok()) return ReportError(expanded.error());
  Status status = is_usd ? Ok() : WriteGlb(*expanded, arguments);
  if (status.ok() && (is_usd || !arguments.simulator.empty()))
    status = WriteForOthers(*expanded, arguments, is_usd ? ending.substr(1) : "none");
  if (!status.ok()) return ReportError(status.error());
  std::error_code error;
  LogInfo(fmt::format("{} ({} bytes) from a map of {} bytes",
                      arguments.out,
                      std::filesystem::file_size(arguments.out, error),
                      std::filesystem::file_size(arguments.map, error)));
  return kExitOk;
}

}  // namespace

void AddExpand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<ExpandArguments>();
  CLI::App* expand = app.add_subcommand(
      "expand", "The scene again from the compact map alone: objects, labels, poses, ground");
  expand->add_option("MAP", arguments->map, "map.json of a run")->required();
  expand->add_option("-o,--output", arguments->out, "Scene file to write: .glb, .usda or .usdz")
      ->required();
  expand->add_option(
      "--simulator",
      arguments->simulator,
      "Folder to write the scene to as MJCF and URDF, with convex pieces and masses");
  expand->add_flag(
      "--physics", arguments->physics, "Write masses and convex pieces into the .usda or .usdz");
  expand->add_option(
      "--library", arguments->library, "Furniture library (default: `library` in the data folder)");
  expand->add_option("--data", arguments->data, "Data folder (default: see `deepslam doctor`)");
  expand->add_flag("--uncompressed", arguments->uncompressed, "Write without Draco");
  expand->callback([&chosen, arguments] { chosen = [arguments] { return Run(*arguments); }; });
}

}  // namespace deepslam::tools
