#include "synth_capture.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/artifact/ply.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/dataset/tum_writer.h"
#include "deepslam/library/catalogue.h"
#include "deepslam/library/zip_archive.h"
#include "deepslam/synth/obj_model.h"
#include "deepslam/synth/render_capture.h"
#include "deepslam/synth/scene_description.h"
#include "deepslam/synth/truth.h"
#include "deepslam/synth/world.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using Models = std::map<std::string, synth::FurnitureModel>;

constexpr std::size_t kMaxEntryBytes = std::size_t{256} << 20;

Status WriteBytes(const fs::path& file, const std::string& bytes) {
  std::error_code ignored;
  fs::create_directories(file.parent_path(), ignored);
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << bytes;
  out.close();
  if (!out)
    return Failed(file.string() + ": cannot be written; is the disk full or the folder read-only?");
  return Ok();
}

Result<synth::FurnitureModel> ReadModel(const library::ZipArchive& archive,
                                        const library::CatalogueItem& item) {
  const Result<std::string> obj = archive.Read(item.model, kMaxEntryBytes);
  if (!obj) return obj.error();
  const fs::path folder = fs::path(item.model).parent_path();
  const auto beside = [&](const std::string& name) -> std::optional<std::string> {
    Result<std::string> bytes = archive.Read((folder / name).generic_string(), kMaxEntryBytes);
    return bytes ? std::optional<std::string>(*std::move(bytes)) : std::nullopt;
  };
  return synth::ParseObjModel(
      *obj, beside, item.rotation, {item.width_m, item.depth_m, item.height_m});
}

// Models of the scene's objects that the catalogue `file` holds.
Status AddModels(const fs::path& file, const synth::SceneDescription& scene, Models& models) {
  const Result<library::ZipArchive> archive = library::ZipArchive::Open(file);
  if (!archive) return archive.error();
  const Result<std::string> properties =
      archive->Read("PluginFurnitureCatalog.properties", kMaxEntryBytes);
  if (!properties) return properties.error();
  const Result<library::Catalogue> catalogue = library::ParseCatalogue(*properties);
  if (!catalogue) return catalogue.error();
  for (const library::CatalogueItem& item : catalogue->items) {
    const auto wanted = std::find_if(
        scene.objects.begin(), scene.objects.end(), [&](const synth::SceneObject& object) {
          return object.model == item.id;
        });
    if (wanted == scene.objects.end() || models.contains(item.id)) continue;
    if (!item.fault.empty())
      return InvalidInput(file.string() + ": item '" + item.id + "': " + item.fault);
    Result<synth::FurnitureModel> model = ReadModel(*archive, item);
    if (!model)
      return InvalidInput(file.string() + ": item '" + item.id + "': " + model.error().message);
    models.emplace(item.id, *std::move(model));
  }
  return Ok();
}

Result<Models> ReadModels(const fs::path& catalogues, const synth::SceneDescription& scene) {
  std::error_code code;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(catalogues, code)) {
    if (entry.path().extension() == ".sh3f") files.push_back(entry.path());
  }
  if (files.empty() && !scene.objects.empty()) {
    return InvalidInput(catalogues.string() +
                        ": no *.sh3f catalogues there; run scripts/setup.sh (Debian package "
                        "sweethome3d-furniture)");
  }
  std::sort(files.begin(), files.end());
  Models models;
  for (const fs::path& file : files) {
    const Status added = AddModels(file, scene, models);
    if (!added) return added.error();
  }
  return models;
}

Status WriteTruth(const fs::path& folder, const synth::World& world) {
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const fs::path file = folder / "meshes" / (std::to_string(i) + ".ply");
    const Result<std::string> ply =
        artifact::EncodePly({world.objects[i].mesh, {}, {}}, file.string());
    if (!ply) return ply.error();
    const Status written = WriteBytes(file, *ply);
    if (!written) return written;
  }
  return WriteBytes(folder / "objects.json", synth::TruthJson(world));
}

// Instance numbers as a 16-bit PNG beside the frame of the same number.
Status WriteInstances(const fs::path& folder, int frame, const Image<std::uint8_t>& instances) {
  dataset::RawDepthImage image(instances.width(), instances.height());
  std::copy(instances.begin(), instances.end(), image.begin());
  std::string number = std::to_string(frame);
  number.insert(0, 6 - std::min<std::size_t>(6, number.size()), '0');
  return dataset::WriteDepthFile(folder / (number + ".png"), image);
}

Status RenderInto(const fs::path& folder,
                  const synth::CaptureRenderer& renderer,
                  Progress& progress) {
  const synth::SceneDescription& scene = renderer.world().description;
  dataset::CaptureSettings settings;
  settings.camera = scene.camera;
  settings.depth_units_per_m = scene.depth_units_per_m;
  Result<dataset::TumWriter> writer = dataset::TumWriter::Create(folder, settings);
  if (!writer) return writer.error();
  std::error_code code;
  fs::create_directories(folder / "truth" / "instances", code);
  const auto total = static_cast<std::size_t>(renderer.num_frames());
  for (int i = 0; i < renderer.num_frames(); ++i) {
    if (progress.StopRequested()) return Interrupted();
    const synth::RenderedFrame rendered = renderer.Render(i);
    Status written = writer->AddFrame(rendered.frame, rendered.world_from_camera);
    if (!written) return written;
    written = WriteInstances(folder / "truth" / "instances", i, rendered.instances);
    if (!written) return written;
    progress.Report(static_cast<std::size_t>(i) + 1, total);
  }
  const Status truth = WriteTruth(folder / "truth", renderer.world());
  if (!truth) return truth;
  return writer->Finish();
}

}  // namespace

Status SynthesiseCapture(const fs::path& scene_file,
                         const fs::path& catalogues,
                         const fs::path& out,
                         Progress& progress) {
  std::error_code code;
  if (fs::exists(out, code) && !(fs::is_directory(out, code) && fs::is_empty(out, code))) {
    return InvalidConfig(out.string() +
                         ": exists and is not an empty folder; name a new one or remove it");
  }
  const Result<std::string> text = dataset::ReadFileBytes(scene_file);
  if (!text) return text.error();
  const Result<synth::SceneDescription> scene = synth::ParseScene(*text, scene_file);
  if (!scene) return scene.error();
  const Result<Models> models = ReadModels(catalogues, *scene);
  if (!models) return models.error();
  Result<synth::World> world = synth::BuildWorld(*scene, *models);
  if (!world) return Error{world.error().code, scene_file.string() + ": " + world.error().message};

  const fs::path whole = out.has_filename() ? out : out.parent_path();
  const fs::path aside = whole.string() + ".partial";
  fs::remove_all(aside, code);
  const Status rendered = RenderInto(aside, synth::CaptureRenderer(*std::move(world)), progress);
  if (!rendered) {
    fs::remove_all(aside, code);
    return rendered;
  }
  fs::remove(whole, code);  // empty, or not there
  fs::rename(aside, whole, code);
  if (code)
    return Failed(whole.string() + ": cannot be put in place (" + code.message() +
                  "); the capture lies in " + aside.string());
  return Ok();
}

}  // namespace deepslam::tools
