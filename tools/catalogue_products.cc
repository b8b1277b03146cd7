#include "catalogue_products.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "deepslam/furniture/design.h"
#include "deepslam/furniture/joined.h"
#include "deepslam/furniture/seat_width.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/library/zip_archive.h"
#include "deepslam/shape/front.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"
#include "furniture_files.h"
#include "known_shapes.h"
#include "seat_classes.h"

namespace deepslam::tools {
namespace {

namespace fs = std::filesystem;

// Counter-clockwise about z by quarters; box back to the origin.
void Turn(int quarters, TriangleMesh& mesh) {
  for (Eigen::Vector3f& p : mesh.vertices) {
    for (int n = 0; n < quarters; ++n) p = Eigen::Vector3f(-p.y(), p.x(), p.z());
  }
}

bool IsBetweenArms(const VoxelGrid& canonical) {
  const std::optional<float> seat = furniture::SeatHeight(canonical);
  return seat && furniture::HasArms(canonical, *seat) &&
         furniture::StandsBelowBothSides(canonical, *seat);
}

std::optional<std::string> ClassOfFolder(const std::string& folder) {
  for (const furniture::Kind kind : furniture::kKinds) {
    if (folder == furniture::KindName(kind) || folder == furniture::ClassName(kind))
      return std::string(furniture::ClassName(kind));
  }
  return std::nullopt;
}

Result<std::vector<fs::path>> MeshFiles(const fs::path& folder) {
  std::error_code code;
  std::vector<fs::path> files;
  fs::recursive_directory_iterator entry(folder, code);
  for (; !code && entry != fs::recursive_directory_iterator(); entry.increment(code)) {
    if (IsFurnitureFile(entry->path().string())) files.push_back(entry->path());
  }
  if (code || files.empty()) {
    return InvalidInput(folder.string() +
                        ": holds no furniture; expected CLASS/NAME.obj (or .glb, .gltf) in it");
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Real size of what comes in any unit: as it is where that is a size such furniture has, else the
// middle of what it has.
double ScaleToReal(const Eigen::Vector3d& size, const std::string& class_name) {
  const furniture::SizeRange range =
      furniture::SizeRangeOf(furniture::KindsOfClass(class_name).front().kind);
  const double low = range.min_m.maxCoeff();
  const double high = range.max_m.maxCoeff();
  const double longest = size.maxCoeff();
  return longest >= 0.9 * low && longest <= 1.1 * high ? 1.0 : 0.5 * (low + high) / longest;
}

// A catalogue that several products are read from.
struct OpenCatalogue {
  library::ZipArchive archive;
  std::mutex mutex;
};

using OpenCatalogues = std::map<std::string, std::shared_ptr<OpenCatalogue>>;

Result<std::shared_ptr<OpenCatalogue>> OpenOnce(const fs::path& file, OpenCatalogues& opened) {
  std::shared_ptr<OpenCatalogue>& catalogue = opened[file.string()];
  if (!catalogue) {
    Result<library::ZipArchive> archive = library::ZipArchive::Open(file);
    if (!archive) return archive.error();
    catalogue = std::make_shared<OpenCatalogue>(std::move(*archive));
  }
  return catalogue;
}

Result<TriangleMesh> ReadFromCatalogue(OpenCatalogue& catalogue,
                                       const library::CatalogueItem& item,
                                       int quarter_turns) {
  const std::lock_guard lock(catalogue.mutex);
  Result<synth::FurnitureModel> model = ReadCatalogueModel(catalogue.archive, item);
  if (!model) return model.error();
  Turn(quarter_turns, model->mesh);
  return std::move(model->mesh);
}

Result<TriangleMesh> ReadFromFile(const fs::path& file, int quarter_turns, double scale) {
  Result<synth::FurnitureModel> model = ReadFurnitureFile(file, std::nullopt);
  if (!model) return model.error();
  Turn(quarter_turns, model->mesh);
  for (Eigen::Vector3f& p : model->mesh.vertices) p *= static_cast<float>(scale);
  return std::move(model->mesh);
}

Status AddCatalogue(const fs::path& folder,
                    const std::vector<library::CatalogueDesign>& designs,
                    ShapeGroups& groups,
                    TrainingProducts& listed) {
  OpenCatalogues opened;
  for (const library::CatalogueDesign& design : designs) {
    const Result<std::shared_ptr<OpenCatalogue>> catalogue =
        OpenOnce(folder / design.catalogue, opened);
    if (!catalogue) return catalogue.error();
    TrainingProduct product;
    product.id = design.model.id;
    product.class_name = design.model.class_name;
    product.source = "catalogue";
    product.split =
        design.withheld ? "withheld" : groups.SplitFor(design.model.id, design.model.shape);
    product.credit =
        fmt::format("{} by {}, {}", design.model.name, design.model.creator, design.model.licence);
    product.between_arms = IsSeat(product.class_name) && IsBetweenArms(design.model.shape);
    product.read = [catalogue = *catalogue, item = design.item, turns = design.quarter_turns] {
      return ReadFromCatalogue(*catalogue, item, turns);
    };
    listed.products.push_back(std::move(product));
  }
  return Ok();
}

// What is wrong with a mesh, or the product.
Result<TrainingProduct> ProductOfFile(const fs::path& file,
                                      const std::string& id,
                                      const std::string& class_name,
                                      const KnownShapes& withheld,
                                      ShapeGroups& groups) {
  const Result<synth::FurnitureModel> model = ReadFurnitureFile(file, std::nullopt);
  const Result<VoxelGrid> shape = model ? shape::Voxelize(model->mesh) : model.error();
  if (!shape) return shape.error();
  const int quarter_turns = HasBack(class_name) ? shape::QuarterTurnsToFront(*shape) : 0;
  if (withheld.FindAlike(*shape)) return InvalidInput("shape like a withheld product");
  TrainingProduct product;
  product.id = id;
  product.class_name = class_name;
  product.source = "folder";
  product.split = groups.SplitFor(id, *shape);
  product.between_arms =
      IsSeat(class_name) && IsBetweenArms(shape::TurnGrid(*shape, quarter_turns));
  const double scale = ScaleToReal(model->size_m, class_name);
  product.read = [file, quarter_turns, scale] { return ReadFromFile(file, quarter_turns, scale); };
  return product;
}

Status AddFolder(const ProductRequest& request,
                 const fs::path& folder,
                 const KnownShapes& withheld,
                 ShapeGroups& groups,
                 TrainingProducts& listed,
                 Progress& progress) {
  const Result<std::vector<fs::path>> files = MeshFiles(folder);
  if (!files) return files.error();
  std::size_t number = 0;
  for (const fs::path& file : *files) {
    if (progress.StopRequested()) return Interrupted();
    progress.Report(++number, files->size());
    const std::optional<std::string> class_name =
        ClassOfFolder(file.parent_path().filename().string());
    if (!class_name || std::find(request.classes.begin(), request.classes.end(), *class_name) ==
                           request.classes.end())
      continue;
    const fs::path name = file.lexically_relative(folder);
    const std::string id = "meshes/" + fs::path(name).replace_extension().generic_string();
    Result<TrainingProduct> product = ProductOfFile(file, id, *class_name, withheld, groups);
    if (!product) {
      listed.dropped.push_back(id + ": " + product.error().message);
      continue;
    }
    product->credit = name.generic_string();
    listed.products.push_back(std::move(*product));
  }
  return Ok();
}

}  // namespace

Result<TrainingProducts> ListProducts(const ProductRequest& request, Progress& progress) {
  const Result<std::vector<std::string>> withheld =
      library::ReadWithheldModels(request.withheld_list);
  if (!withheld) return withheld.error();
  Result<std::vector<library::CatalogueDesign>> designs =
      library::ReadDesigns(request.catalogues, *withheld, request.classes, progress);
  if (!designs) return designs.error();
  TrainingProducts listed;
  ShapeGroups groups;
  KnownShapes shapes;
  for (const library::CatalogueDesign& design : *designs) {
    if (!design.withheld) continue;
    shapes.Add(design.model.shape);
    listed.withheld.push_back(design.model.shape);
  }
  if (request.catalogue) {
    if (const Status status = AddCatalogue(request.catalogues, *designs, groups, listed); !status)
      return status.error();
  }
  for (const fs::path& folder : request.mesh_folders) {
    if (const Status status = AddFolder(request, folder, shapes, groups, listed, progress); !status)
      return status.error();
  }
  return listed;
}

}  // namespace deepslam::tools
