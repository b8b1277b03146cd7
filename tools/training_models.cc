#include "training_models.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/furniture/design.h"
#include "deepslam/furniture/joined.h"
#include "deepslam/furniture/proportions.h"
#include "deepslam/furniture/seat_width.h"
#include "deepslam/priors/exchanged_back.h"
#include "deepslam/scene/mesh_box.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/symmetry.h"
#include "deepslam/shape/voxelize.h"
#include "known_shapes.h"
#include "seat_classes.h"

namespace deepslam::tools {

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
  // real furniture: what it is made of, and, of variants, whose back it has, if not its own
  std::shared_ptr<const TrainingProduct> product;
  std::shared_ptr<const TrainingProduct> upper;
};

namespace {

bool Contains(const std::vector<std::string>& classes, const std::string& class_name) {
  return std::find(classes.begin(), classes.end(), class_name) != classes.end();
}

bool Wanted(const TrainingModelRequest& request, const std::string& class_name) {
  return Contains(request.classes, class_name);
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

// What is asked for of a product.
void AddProduct(const TrainingModelRequest& request,
                const std::shared_ptr<const TrainingProduct>& product,
                std::vector<TrainingModelSource>& sources) {
  if ((product->split == "withheld") != request.withheld) return;
  TrainingModelSource source;
  source.id = product->id;
  source.class_name = product->class_name;
  source.source = product->source;
  source.split = product->split;
  source.credit = product->credit;
  source.product = product;
  if (Wanted(request, source.class_name)) AddVariants(request, source, sources);
  for (const SeatExchange& exchange : WantedExchanges(request)) {
    if (source.class_name == exchange.from && product->between_arms)
      AddExchanged(exchange, source, sources);
  }
}

// Every other variant of what one sits on gets the back of another product of the training.
void ExchangeBacks(std::uint64_t seed, std::vector<TrainingModelSource>& sources) {
  std::map<std::string, std::vector<std::shared_ptr<const TrainingProduct>>> seats;
  for (const TrainingModelSource& source : sources) {
    if (IsSeat(source.class_name) && source.source != "generated" && source.split == "train" &&
        source.variant == 0)
      seats[source.class_name].push_back(source.product);
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
  Result<TriangleMesh> mesh = source.product->read();
  if (!mesh) return mesh.error();
  TrainingModel model;
  model.kind = source.class_name;
  model.furniture.mesh = std::move(*mesh);
  if (source.variant == 0) return model;
  if (source.upper) {
    const Result<TriangleMesh> upper = source.upper->read();
    if (upper) model.furniture.mesh = priors::WithBackOf(model.furniture.mesh, *upper);
  }
  // Above any variant's number, so that attempts have streams of their own.
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

std::vector<std::string> ClassesToRead(const TrainingModelRequest& request) {
  std::vector<std::string> classes = request.classes;
  for (const SeatExchange& exchange : WantedExchanges(request)) {
    if (!Contains(classes, exchange.from)) classes.push_back(exchange.from);
  }
  return classes;
}

TrainingModels TrainingModels::Of(const TrainingModelRequest& request, TrainingProducts products) {
  TrainingModels models;
  models.request_ = request;
  if (!request.withheld) AddGenerated(request, models.sources_);
  for (TrainingProduct& product : products.products) {
    AddProduct(
        request, std::make_shared<const TrainingProduct>(std::move(product)), models.sources_);
  }
  if (request.withheld) return models;
  for (const VoxelGrid& shape : products.withheld) models.withheld_->Add(shape);
  ExchangeBacks(request.seed, models.sources_);
  return models;
}

std::size_t TrainingModels::size() const { return sources_.size(); }
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
