#include "synth_capture.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/artifact/layout_json.h"
#include "deepslam/artifact/ply.h"
#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/convert/tum_writer.h"
#include "deepslam/core/nearest_word.h"
#include "deepslam/core/parallel.h"
#include "deepslam/dataset/image_files.h"
#include "deepslam/dataset/read_bytes.h"
#include "deepslam/gltf/textured_model.h"
#include "deepslam/library/catalogue.h"
#include "deepslam/library/zip_archive.h"
#include "deepslam/synth/furnished_home.h"
#include "deepslam/synth/obj_model.h"
#include "deepslam/synth/render_capture.h"
#include "deepslam/synth/scene_description.h"
#include "deepslam/synth/true_layout.h"
#include "deepslam/synth/truth.h"
#include "deepslam/synth/world.h"
#include "furniture_files.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;
using Models = std::map<std::string, synth::FurnitureModel>;

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

// Models of the scene's objects that the catalogue `file` holds; all its ids join `known`.
Status AddModels(const fs::path& file,
                 const synth::SceneDescription& scene,
                 Models& models,
                 std::vector<std::string>& known) {
  const Result<library::ZipArchive> archive = library::ZipArchive::Open(file);
  if (!archive) return archive.error();
  const Result<std::string> properties =
      archive->Read("PluginFurnitureCatalog.properties", kMaxEntryBytes);
  if (!properties) return properties.error();
  const Result<library::Catalogue> catalogue = library::ParseCatalogue(*properties);
  if (!catalogue) return catalogue.error();
  for (const library::CatalogueItem& item : catalogue->items) {
    known.push_back(item.id);
    const auto wanted = std::find_if(
        scene.objects.begin(), scene.objects.end(), [&](const synth::SceneObject& object) {
          return object.model == item.id;
        });
    if (wanted == scene.objects.end() || models.contains(item.id)) continue;
    if (!item.fault.empty())
      return InvalidInput(file.string() + ": item '" + item.id + "': " + item.fault);
    Result<synth::FurnitureModel> model = ReadCatalogueModel(*archive, item);
    if (!model)
      return InvalidInput(file.string() + ": item '" + item.id + "': " + model.error().message);
    models.emplace(item.id, *std::move(model));
  }
  return Ok();
}

// What the scene asks for of a model wherever it stands; nothing where it stands in its own size.
std::optional<synth::CatalogueSize> AskedSize(const synth::SceneDescription& scene,
                                              const std::string& model) {
  std::optional<synth::CatalogueSize> asked;
  for (const synth::SceneObject& object : scene.objects) {
    if (object.model != model) continue;
    if (!object.size_m) return std::nullopt;
    if (!asked) asked = {object.size_m->y(), object.size_m->x(), object.size_m->z()};
  }
  return asked;
}

// Furniture files below the folders, by path: what a misspelt one may have meant.
std::vector<std::string> FurnitureFiles(const std::vector<fs::path>& folders) {
  // Files: bounds the time where a folder is a whole disk.
  constexpr std::size_t kMaxListed = 10'000;
  std::vector<std::string> files;
  for (const fs::path& folder : folders) {
    std::error_code code;
    fs::recursive_directory_iterator entry(
        folder, fs::directory_options::skip_permission_denied, code);
    for (; !code && entry != fs::recursive_directory_iterator(); entry.increment(code)) {
      if (files.size() >= kMaxListed) return files;
      if (IsFurnitureFile(entry->path().string()))
        files.push_back(entry->path().lexically_relative(folder).generic_string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string DidYouMean(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = NearestWord(word, known);
  return nearest.empty() ? nearest : "; did you mean '" + nearest + "'?";
}

std::string Line(const SynthRequest& request, const synth::SceneObject& object) {
  return request.scene_file.string() + ":" + std::to_string(object.line) + ": model '" +
         object.model + "' ";
}

Status AddModelFiles(const SynthRequest& request,
                     const synth::SceneDescription& scene,
                     Models& models) {
  std::vector<fs::path> folders = {request.scene_file.parent_path()};
  folders.insert(folders.end(), request.furniture.begin(), request.furniture.end());
  folders.push_back(request.catalogues);
  for (const synth::SceneObject& object : scene.objects) {
    if (!IsFurnitureFile(object.model) || models.contains(object.model)) continue;
    const auto folder = std::find_if(folders.begin(), folders.end(), [&](const fs::path& f) {
      std::error_code code;
      return fs::is_regular_file(f / object.model, code);
    });
    if (folder == folders.end()) {
      return InvalidInput(Line(request, object) +
                          "is neither beside the scene nor in a folder of --furniture; give its "
                          "path from one of them" +
                          DidYouMean(object.model, FurnitureFiles(request.furniture)));
    }
    Result<synth::FurnitureModel> model =
        ReadFurnitureFile(*folder / object.model, AskedSize(scene, object.model));
    if (!model) return model.error();
    models.emplace(object.model, *std::move(model));
  }
  return Ok();
}

Result<Models> ReadModels(const SynthRequest& request, const synth::SceneDescription& scene) {
  for (const fs::path& folder : request.furniture) {
    std::error_code code;
    if (!fs::is_directory(folder, code))
      return InvalidConfig("--furniture " + folder.string() + ": is no folder");
  }
  Models models;
  const Status own = AddModelFiles(request, scene, models);
  if (!own) return own.error();
  const auto missing = [&](const synth::SceneObject& object) {
    return !models.contains(object.model);
  };
  if (std::none_of(scene.objects.begin(), scene.objects.end(), missing)) return models;
  std::error_code code;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(request.catalogues, code)) {
    if (entry.path().extension() == ".sh3f") files.push_back(entry.path());
  }
  if (files.empty()) {
    return InvalidInput(request.catalogues.string() +
                        ": no *.sh3f catalogues there; run scripts/setup.sh (Debian package "
                        "sweethome3d-furniture)");
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> known;
  for (const fs::path& file : files) {
    const Status added = AddModels(file, scene, models, known);
    if (!added) return added.error();
  }
  const auto unknown = std::find_if(scene.objects.begin(), scene.objects.end(), missing);
  if (unknown != scene.objects.end()) {
    return InvalidInput(Line(request, *unknown) + "is no item of the catalogues in " +
                        request.catalogues.string() + ", nor a .obj, .gltf or .glb file" +
                        DidYouMean(unknown->model, known));
  }
  return models;
}

// Depth, width and height of the pieces that homes are furnished with.
Result<synth::PieceSizes> HomePieceSizes(const fs::path& catalogues) {
  const std::vector<std::string> pieces = synth::HomePieces();
  synth::PieceSizes sizes;
  std::error_code code;
  for (const fs::directory_entry& entry : fs::directory_iterator(catalogues, code)) {
    if (entry.path().extension() != ".sh3f") continue;
    const Result<library::ZipArchive> archive = library::ZipArchive::Open(entry.path());
    if (!archive) return archive.error();
    const Result<std::string> properties =
        archive->Read("PluginFurnitureCatalog.properties", kMaxEntryBytes);
    if (!properties) return properties.error();
    const Result<library::Catalogue> catalogue = library::ParseCatalogue(*properties);
    if (!catalogue) return catalogue.error();
    for (const library::CatalogueItem& item : catalogue->items) {
      if (item.fault.empty() && std::ranges::find(pieces, item.id) != pieces.end())
        sizes[item.id] = {item.depth_m, item.width_m, item.height_m};
    }
  }
  if (sizes.empty()) {
    return InvalidInput(
        catalogues.string() +
        ": no furniture of the *.sh3f catalogues there; run scripts/setup.sh (Debian "
        "package sweethome3d-furniture), or name their folder with --catalogues");
  }
  return sizes;
}

Result<synth::SceneDescription> DescribeAsWritten(const SynthRequest& request) {
  if (request.home) {
    const Result<synth::PieceSizes> sizes = HomePieceSizes(request.catalogues);
    if (!sizes) return sizes.error();
    return synth::FurnishHome(*request.home, *sizes);
  }
  const Result<std::string> text = dataset::ReadFileBytes(request.scene_file);
  if (!text) return text.error();
  return synth::ParseScene(*text, request.scene_file, request.rung);
}

Result<synth::SceneDescription> DescribeScene(const SynthRequest& request) {
  Result<synth::SceneDescription> scene = DescribeAsWritten(request);
  for (const std::string& setting : request.settings) {
    if (!scene) return scene;
    scene = synth::FilmedWith(*std::move(scene), setting);
  }
  if (!scene || !request.frames_per_s) return scene;
  return synth::AtFrameRate(*std::move(scene), *request.frames_per_s);
}

Status WriteMesh(const fs::path& file, const TriangleMesh& mesh) {
  const Result<std::string> ply = artifact::EncodePly({mesh, {}, {}}, file.string());
  if (!ply) return ply.error();
  return WriteBytes(file, *ply);
}

Status WriteTruth(const fs::path& folder, const synth::World& world) {
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const Status written =
        WriteMesh(folder / "meshes" / (std::to_string(i) + ".ply"), world.objects[i].mesh);
    if (!written) return written;
  }
  const Status room = WriteMesh(folder / "room.ply", synth::RoomMesh(world));
  if (!room) return room;
  const Result<std::string> layout =
      artifact::EncodeLayout(synth::TrueLayout(world.description), "layout.json");
  if (!layout) return layout.error();
  if (Status written = WriteBytes(folder / "layout.json", *layout); !written) return written;
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

// Frames are rendered some at a time, while those before are encoded and written in their order.
Status WriteFrames(const fs::path& folder,
                   const synth::CaptureRenderer& renderer,
                   convert::TumWriter& writer,
                   Progress& progress) {
  constexpr int kAtATime = 4;  // frames in memory, and as many as wait to be written
  std::vector<synth::RenderedFrame> ready;
  int num_written = 0;
  Status status = Ok();
  const auto write_ready = [&] {
    for (const synth::RenderedFrame& rendered : ready) {
      if (status) status = writer.AddFrame(rendered.frame, rendered.world_from_camera);
      if (status)
        status = WriteInstances(folder / "truth" / "instances", num_written, rendered.instances);
      ++num_written;
    }
  };
  for (int first = 0; first < renderer.num_frames() || !ready.empty(); first += kAtATime) {
    if (progress.StopRequested()) return Interrupted();
    const int count = std::clamp(renderer.num_frames() - first, 0, kAtATime);
    std::vector<synth::RenderedFrame> next(static_cast<std::size_t>(count));
    ParallelFor(next.size() + 1, [&](std::size_t task) {
      if (task == 0) {
        write_ready();
      } else {
        next[task - 1] = renderer.Render(first + static_cast<int>(task) - 1);
      }
    });
    if (!status) return status;
    ready = std::move(next);
    progress.Report(static_cast<std::size_t>(num_written),
                    static_cast<std::size_t>(renderer.num_frames()));
  }
  return status;
}

Status RenderInto(const fs::path& folder,
                  const synth::CaptureRenderer& renderer,
                  Progress& progress) {
  const synth::SceneDescription& scene = renderer.world().description;
  dataset::CaptureSettings settings;
  settings.camera = scene.camera;
  settings.depth_units_per_m = scene.depth_units_per_m;
  Result<convert::TumWriter> writer = convert::TumWriter::Create(folder, settings);
  if (!writer) return writer.error();
  std::error_code code;
  fs::create_directories(folder / "truth" / "instances", code);
  const Status frames = WriteFrames(folder, renderer, *writer, progress);
  if (!frames) return frames;
  const Status truth = WriteTruth(folder / "truth", renderer.world());
  if (!truth) return truth;
  return writer->Finish();
}

}  // namespace

Result<SynthSummary> SynthesiseCapture(const SynthRequest& request, Progress& progress) {
  const fs::path scene_file =
      request.home ? fs::path("home " + std::to_string(*request.home)) : request.scene_file;
  const fs::path& out = request.out;
  std::error_code code;
  if (fs::exists(out, code) && !(fs::is_directory(out, code) && fs::is_empty(out, code))) {
    return InvalidConfig(out.string() +
                         ": exists and is not an empty folder; name a new one or remove it");
  }
  const Result<synth::SceneDescription> scene = DescribeScene(request);
  if (!scene) return scene.error();
  const Result<Models> models = ReadModels(request, *scene);
  if (!models) return models.error();
  Result<synth::World> world = synth::BuildWorld(*scene, *models, class_table::DefaultClassTable());
  if (!world) return Error{world.error().code, scene_file.string() + ": " + world.error().message};

  SynthSummary summary;
  for (const auto& [name, model] : *models) {
    for (const std::string& warning : model.warnings)
      summary.warnings.push_back(scene_file.string() + ": model '" + name + "': " + warning);
  }
  for (const std::string& warning : world->warnings)
    summary.warnings.push_back(scene_file.string() + ": " + warning);
  const synth::CaptureRenderer renderer(*std::move(world));
  summary.num_frames = renderer.num_frames();
  const fs::path whole = out.has_filename() ? out : out.parent_path();
  const fs::path aside = whole.string() + ".partial";
  fs::remove_all(aside, code);
  const Status rendered = RenderInto(aside, renderer, progress);
  if (!rendered) {
    fs::remove_all(aside, code);
    return rendered.error();
  }
  fs::remove(whole, code);  // empty, or not there
  fs::rename(aside, whole, code);
  if (code)
    return Failed(whole.string() + ": cannot be put in place (" + code.message() +
                  "); the capture lies in " + aside.string());
  return summary;
}

}  // namespace deepslam::tools
