#include "training_models.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/furniture/design.h"
#include "deepslam/furniture/joined.h"
#include "deepslam/furniture/proportions.h"
#include "deepslam/furniture/seat_width.h"
#include "deepslam/library/furniture_library.h"
#include "deepslam/library/zip_archive.h"
#include "deepslam/priors/exchanged_back.h"
#include "deepslam/scene/mesh_box.h"
#include "deepslam/shape/front.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/symmetry.h"
#include "deepslam/shape/voxelize.h"
#include "furniture_files.h"
#include "known_shapes.h"

namespace deepslam::tools {

namespace fs = std::filesystem;

// Armchairs become sofas, sofas armchairs.
enum class SeatWidth { kOwn, kWidened, kNarrowed };

struct TrainingModelSource {
  std::string id;
  std::string class_name;
  std::string source;
  std::string split;
  std::string credit;
  int variant = 0;
  SeatWidth seat_width = SeatWidth::kOwn;
  // generated
  furniture::Kind kind = furniture::Kind::kChair;
  int design = 0;
  // catalogue
  std::shared_ptr<const library::ZipArchive> archive;
  std::shared_ptr<std::mutex> archive_mutex;
  library::CatalogueItem item;
  // folder
  fs::path file;
  int quarter_turns = 0;
  double scale = 1;
  // variants: whose back it has, if not its own
  std::shared_ptr<const TrainingModelSource> upper;
};

namespace {

bool Contains(const std::vector<std::string>& classes, const std::string& class_name) {
  return std::find(classes.begin(), classes.end(), class_name) != classes.end();
}

bool Wanted(const TrainingModelRequest& request, const std::string& class_name) {
  return Contains(request.classes, class_name);
}

// Counter-clockwise about z by quarters; box back to the origin.
void Turn(int quarters, TriangleMesh& mesh) {
  for (Eigen::Vector3f& p : mesh.vertices) {
    for (int n = 0; n < quarters; ++n) p = Eigen::Vector3f(-p.y(), p.x(), p.z());
  }
}

Eigen::Vector3d Centre(TriangleMesh& mesh) {
  const Eigen::AlignedBox3f box = BoxOfFaces(mesh);
  for (Eigen::Vector3f& p : mesh.vertices) p -= box.center();
  return box.sizes().cast<double>();
}

void AddGenerated(const TrainingModelRequest& request, std::vector<TrainingModelSource>& sources) {
  for (const std::string& class_name : request.classes) {
    const auto kinds = furniture::KindsOfClass(class_name);
    if (kinds.empty()) continue;
    for (int n = request.first_design; n < request.first_design + request.num_designs; ++n) {
      TrainingModelSource source;
      source.id = fmt::format("generated/{}/{:06d}", class_name, n);
      source.class_name = class_name;
      source.source = "generated";
      source.split = SplitOf(source.id);
      source.design = n;
      source.credit = "made up by rules";
      double at = Random(request.seed, source.id, 0).Uniform();
      source.kind = kinds.back().kind;
      for (const furniture::KindShare& share : kinds) {
        at -= share.share;
        if (at >= 0) continue;
        source.kind = share.kind;
        break;
      }
      sources.push_back(std::move(source));
    }
  }
}

void AddVariants(const TrainingModelRequest& request,
                 const TrainingModelSource& source,
                 std::vector<TrainingModelSource>& sources) {
  sources.push_back(source);
  if (request.withheld) return;
  for (int variant = 1; variant <= request.num_variants; ++variant) {
    sources.push_back(source);
    sources.back().variant = variant;
    sources.back().id += fmt::format("~{}", variant);
  }
}

// What is made of seats between two arms by giving them another width.
struct SeatExchange {
  SeatWidth seat_width;
  std::string from;  // class
  std::string to;
  std::string mark;  // in the ids of what is made
  int count = 0;     // of each
};

// Those that are asked for.
std::vector<SeatExchange> WantedExchanges(const TrainingModelRequest& request) {
  std::vector<SeatExchange> exchanges;
  if (request.withheld) return exchanges;
  if (request.num_widened > 0 && Wanted(request, "sofa"))
    exchanges.push_back({SeatWidth::kWidened, "chair", "sofa", "wide", request.num_widened});
  if (request.num_narrowed > 0 && Wanted(request, "chair"))
    exchanges.push_back({SeatWidth::kNarrowed, "sofa", "chair", "narrow", request.num_narrowed});
  return exchanges;
}

bool IsBetweenArms(const VoxelGrid& canonical) {
  const std::optional<float> seat = furniture::SeatHeight(canonical);
  return seat && furniture::HasArms(canonical, *seat) &&
         furniture::StandsBelowBothSides(canonical, *seat);
}

void AddExchanged(const SeatExchange& exchange,
                  const TrainingModelSource& source,
                  std::vector<TrainingModelSource>& sources) {
  for (int variant = 1; variant <= exchange.count; ++variant) {
    sources.push_back(source);
    TrainingModelSource& made = sources.back();
    made.id += fmt::format("~{}{}", exchange.mark, variant);
    made.class_name = exchange.to;
    made.variant = variant;
    made.seat_width = exchange.seat_width;
  }
}

// What is asked for of a product or mesh.
void AddProduct(const TrainingModelRequest& request,
                const TrainingModelSource& source,
                const VoxelGrid& canonical,
                std::vector<TrainingModelSource>& sources) {
  if (Wanted(request, source.class_name)) AddVariants(request, source, sources);
  for (const SeatExchange& exchange : WantedExchanges(request)) {
    if (source.class_name == exchange.from && IsBetweenArms(canonical))
      AddExchanged(exchange, source, sources);
  }
}

// Classes whose products are looked at.
std::vector<std::string> ClassesToRead(const TrainingModelRequest& request) {
  std::vector<std::string> classes = request.classes;
  for (const SeatExchange& exchange : WantedExchanges(request)) {
    if (!Contains(classes, exchange.from)) classes.push_back(exchange.from);
  }
  return classes;
}

Status AddCatalogue(const TrainingModelRequest& request,
                    const std::vector<library::CatalogueDesign>& designs,
                    ShapeGroups& groups,
                    std::vector<TrainingModelSource>& sources) {
  std::map<std::string,
           std::pair<std::shared_ptr<library::ZipArchive>, std::shared_ptr<std::mutex>>>
      archives;
  for (const library::CatalogueDesign& design : designs) {
    if (design.withheld != request.withheld) continue;
    auto& [archive, mutex] = archives[design.catalogue];
    if (!archive) {
      Result<library::ZipArchive> opened =
          library::ZipArchive::Open(request.catalogues / design.catalogue);
      if (!opened) return opened.error();
      archive = std::make_shared<library::ZipArchive>(std::move(*opened));
      mutex = std::make_shared<std::mutex>();
    }
    TrainingModelSource source;
    source.id = design.model.id;
    source.class_name = design.model.class_name;
    source.source = "catalogue";
    source.split =
        design.withheld ? "withheld" : groups.SplitFor(design.model.id, design.model.shape);
    source.credit =
        fmt::format("{} by {}, {}", design.model.name, design.model.creator, design.model.licence);
    source.archive = archive;
    source.archive_mutex = mutex;
    source.item = design.item;
    source.quarter_turns = design.quarter_turns;
    AddProduct(request, source, design.model.shape, sources);
  }
  return Ok();
}

bool IsSeat(const std::string& class_name) { return class_name == "chair" || class_name == "sofa"; }

bool HasBack(const std::string& class_name) { return IsSeat(class_name) || class_name == "bed"; }

// Every other variant of what one sits on gets the back of another product of the training.
void ExchangeBacks(std::uint64_t seed, std::vector<TrainingModelSource>& sources) {
  std::map<std::string, std::vector<std::shared_ptr<const TrainingModelSource>>> seats;
  for (const TrainingModelSource& source : sources) {
    if (IsSeat(source.class_name) && source.source != "generated" && source.split == "train" &&
        source.variant == 0)
      seats[source.class_name].push_back(std::make_shared<TrainingModelSource>(source));
  }
  for (TrainingModelSource& source : sources) {
    const auto others = seats.find(source.class_name);
    if (source.seat_width != SeatWidth::kOwn || source.variant % 2 == 0 ||
        source.split != "train" || others == seats.end())
      continue;
    Random random(seed, source.id, 0);
    source.upper = others->second[random.Index(others->second.size())];
  }
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

Status AddFolder(const TrainingModelRequest& request,
                 const fs::path& folder,
                 const KnownShapes& withheld,
                 ShapeGroups& groups,
                 std::vector<TrainingModelSource>& sources,
                 std::vector<std::string>& dropped,
                 Progress& progress) {
  const Result<std::vector<fs::path>> files = MeshFiles(folder);
  if (!files) return files.error();
  const std::vector<std::string> classes = ClassesToRead(request);
  std::size_t number = 0;
  for (const fs::path& file : *files) {
    if (progress.StopRequested()) return Interrupted();
    progress.Report(++number, files->size());
    const std::optional<std::string> class_name =
        ClassOfFolder(file.parent_path().filename().string());
    if (!class_name || !Contains(classes, *class_name)) continue;
    const std::string id =
        "meshes/" + file.lexically_relative(folder).replace_extension().generic_string();
    const Result<synth::FurnitureModel> model = ReadFurnitureFile(file, std::nullopt);
    const Result<VoxelGrid> shape = model ? shape::Voxelize(model->mesh) : model.error();
    if (!shape) {
      dropped.push_back(id + ": " + shape.error().message);
      continue;
    }
    const int quarter_turns = HasBack(*class_name) ? shape::QuarterTurnsToFront(*shape) : 0;
    if (withheld.FindAlike(*shape)) {
      dropped.push_back(id + ": shape like a withheld product");
      continue;
    }
    TrainingModelSource source;
    source.id = id;
    source.class_name = *class_name;
    source.source = "folder";
    source.split = groups.SplitFor(id, *shape);
    source.credit = file.lexically_relative(folder).generic_string();
    source.file = file;
    source.quarter_turns = quarter_turns;
    source.scale = ScaleToReal(model->size_m, *class_name);
    AddProduct(request, source, shape::TurnGrid(*shape, quarter_turns), sources);
  }
  return Ok();
}

Result<synth::FurnitureModel> ReadMesh(const TrainingModelSource& source) {
  if (!source.archive) return ReadFurnitureFile(source.file, std::nullopt);
  const std::lock_guard lock(*source.archive_mutex);
  return ReadCatalogueModel(*source.archive, source.item);
}

// In the canonical frame, at real size.
Result<TriangleMesh> ReadCanonical(const TrainingModelSource& source) {
  Result<synth::FurnitureModel> read = ReadMesh(source);
  if (!read) return read.error();
  Turn(source.quarter_turns, read->mesh);
  for (Eigen::Vector3f& p : read->mesh.vertices) p *= static_cast<float>(source.scale);
  return std::move(read->mesh);
}

furniture::Proportions DrawProportions(const TrainingModelSource& source, Random& random) {
  switch (source.seat_width) {
    case SeatWidth::kWidened:
      return furniture::DrawWidened(random);
    case SeatWidth::kNarrowed:
      return furniture::DrawNarrowed(random);
    case SeatWidth::kOwn:
      break;
  }
  return furniture::DrawProportions(HasBack(source.class_name), random);
}

// Variants are drawn anew where they turn out like a withheld product.
constexpr int kMaxAttempts = 10;

Result<TrainingModel> MakeFromMesh(const TrainingModelSource& source,
                                   std::uint64_t seed,
                                   int attempt) {
  Result<TriangleMesh> mesh = ReadCanonical(source);
  if (!mesh) return mesh.error();
  TrainingModel model;
  model.kind = source.class_name;
  model.furniture.mesh = std::move(*mesh);
  if (source.variant == 0) return model;
  if (source.upper) {
    const Result<TriangleMesh> upper = ReadCanonical(*source.upper);
    if (upper) model.furniture.mesh = priors::WithBackOf(model.furniture.mesh, *upper);
  }
  constexpr int kMaxVariants = 1000;
  Random random(
      seed, source.id, static_cast<std::uint64_t>(source.variant + attempt * kMaxVariants));
  model.furniture.mesh =
      furniture::Reproportion(model.furniture.mesh, DrawProportions(source, random));
  return model;
}

TrainingModel MakeGenerated(const TrainingModelSource& source, std::uint64_t seed) {
  furniture::Design design = furniture::MakeDesign(source.kind, Random(seed, source.id, 1));
  TrainingModel model;
  model.kind = std::string(furniture::KindName(source.kind));
  model.furniture = {std::move(design.mesh), std::move(design.material_of_face)};
  return model;
}

Result<TrainingModel> MakeOnce(const TrainingModelSource& source, std::uint64_t seed, int attempt) {
  Result<TrainingModel> model = source.source == "generated" ? MakeGenerated(source, seed)
                                                             : MakeFromMesh(source, seed, attempt);
  if (!model) return model;
  model->size_m = Centre(model->furniture.mesh);
  Result<VoxelGrid> shape = shape::Voxelize(model->furniture.mesh);
  if (!shape) return shape.error();
  model->shape = std::move(*shape);
  return model;
}

int TurnsThatLeave(const VoxelGrid& shape) {
  switch (shape::SymmetryOf(shape)) {
    case shape::Symmetry::kNone:
      return 1;
    case shape::Symmetry::kHalf:
      return 2;
    case shape::Symmetry::kQuarter:
      return 4;
    case shape::Symmetry::kAny:
      return 0;
  }
  return 1;
}

}  // namespace

TrainingModels::TrainingModels() : withheld_(std::make_unique<KnownShapes>()) {}
TrainingModels::~TrainingModels() = default;
TrainingModels::TrainingModels(TrainingModels&&) noexcept = default;
TrainingModels& TrainingModels::operator=(TrainingModels&&) noexcept = default;

Result<TrainingModels> TrainingModels::List(const TrainingModelRequest& request,
                                            Progress& progress) {
  TrainingModels models;
  models.request_ = request;
  if (!request.withheld) AddGenerated(request, models.sources_);
  // Without the withheld products nothing tells whether a folder's mesh is one of them.
  const bool need_catalogue =
      request.withheld || request.catalogue || !request.mesh_folders.empty();
  if (!need_catalogue) return models;
  const Result<std::vector<std::string>> withheld =
      library::ReadWithheldModels(request.withheld_list);
  if (!withheld) return withheld.error();
  const Result<std::vector<library::CatalogueDesign>> designs =
      library::ReadDesigns(request.catalogues, *withheld, ClassesToRead(request), progress);
  if (!designs) return designs.error();
  ShapeGroups groups;
  if (request.withheld || request.catalogue) {
    if (const Status status = AddCatalogue(request, *designs, groups, models.sources_); !status)
      return status.error();
  }
  if (request.withheld) return models;
  for (const library::CatalogueDesign& design : *designs) {
    if (design.withheld) models.withheld_->Add(design.model.shape);
  }
  for (const fs::path& folder : request.mesh_folders) {
    if (const Status status = AddFolder(
            request, folder, *models.withheld_, groups, models.sources_, models.dropped_, progress);
        !status)
      return status.error();
  }
  ExchangeBacks(request.seed, models.sources_);
  return models;
}

std::size_t TrainingModels::size() const { return sources_.size(); }
const std::vector<std::string>& TrainingModels::dropped() const { return dropped_; }
bool TrainingModels::IsProduct(std::size_t n) const { return sources_[n].source != "generated"; }

Result<TrainingModel> TrainingModels::Make(std::size_t n) const {
  const TrainingModelSource& source = sources_[n];
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    Result<TrainingModel> model = MakeOnce(source, request_.seed, attempt);
    if (!model) return InvalidInput(source.id + ": " + model.error().message);
    // Products as they are were compared when they were listed.
    if (source.variant > 0 && withheld_->FindAlike(model->shape)) continue;
    model->id = source.id;
    model->class_name = source.class_name;
    model->source = source.source;
    model->split = source.split;
    model->credit = source.credit;
    model->symmetry = TurnsThatLeave(model->shape);
    return model;
  }
  return InvalidInput(
      fmt::format("{}: is like a withheld product however it is drawn ({} times); leave it out",
                  source.id,
                  kMaxAttempts));
}

}  // namespace deepslam::tools
