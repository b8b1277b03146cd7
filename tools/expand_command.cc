#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "commands.h"
#include "console.h"
#include "deepslam/artifact/map_json.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/presentation/expand_map.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/mesh_options.h"
#include "deepslam/stages/plan.h"
#include "deepslam/storage/store.h"

namespace deepslam::tools {
namespace {

struct ExpandArguments {
  std::string map;
  std::string out;
  std::string library;
  std::string data;
  bool uncompressed = false;
};

Result<std::string> Expand(const ExpandArguments& arguments, std::size_t& map_bytes) {
  const Result<std::string> text = storage::ReadFile(arguments.map);
  if (!text.ok()) return text.error();
  map_bytes = text->size();
  if (text->starts_with("glTF")) {
    return InvalidInput(
        fmt::format("{}: is a glTF scene already; expand makes one from the map.json beside it",
                    arguments.map));
  }
  const Result<CompactMap> map = artifact::DecodeMap(*text, arguments.map);
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
  const Result<gltf::GltfScene> scene =
      presentation::ExpandMap(*map, &library, *options, stages::kToolVersion);
  if (!scene.ok()) return in_map(scene.error());
  return gltf::WriteGlb(*scene, {.draco = !arguments.uncompressed});
}

int Run(const ExpandArguments& arguments) {
  std::size_t map_bytes = 0;
  const Result<std::string> glb = Expand(arguments, map_bytes);
  if (!glb.ok()) return ReportError(glb.error());
  if (Status status = storage::WriteFileAtomically(arguments.out, *glb); !status.ok()) {
    return ReportError(status.error());
  }
  LogInfo(
      fmt::format("{} ({} bytes) from a map of {} bytes", arguments.out, glb->size(), map_bytes));
  return kExitOk;
}

}  // namespace

void AddExpand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<ExpandArguments>();
  CLI::App* expand = app.add_subcommand(
      "expand", "The scene again from the compact map alone: objects, labels, poses, ground");
  expand->add_option("MAP", arguments->map, "map.json of a run")->required();
  expand->add_option("-o,--output", arguments->out, "Scene file to write (.glb)")->required();
  expand->add_option(
      "--library", arguments->library, "Furniture library (default: `library` in the data folder)");
  expand->add_option("--data", arguments->data, "Data folder (default: see `deepslam doctor`)");
  expand->add_flag("--uncompressed", arguments->uncompressed, "Write without Draco");
  expand->callback([&chosen, arguments] { chosen = [arguments] { return Run(*arguments); }; });
}

}  // namespace deepslam::tools
