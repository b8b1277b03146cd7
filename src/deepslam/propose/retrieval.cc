#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "deepslam/core/check.h"
#include "deepslam/core/parallel.h"
#include "deepslam/propose/best_first.h"
#include "deepslam/propose/candidate_size.h"
#include "deepslam/propose/coarse_shape.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/place_shape.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/propose/silhouette_fit.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::propose {
namespace {

// Factors of size are rounded to it, so that objects share stretched models.
constexpr int kStretchStep_percent = 5;

// What one object's views hold, prepared for all models: its depth, or its silhouettes alone.
struct Measured {
  MeasuredDepth depth;
  bool has_ground = false;
  std::vector<SilhouetteView> silhouettes;

  [[nodiscard]] bool empty() const { return silhouettes.empty() && depth.empty(); }
};

// The middle between the points nearest to the views' axes: good enough to tell directions apart.
Eigen::Vector3d AxesMeet(std::span<const ObjectView> views) {
  Eigen::Matrix3d h = 1e-3 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const ObjectView& view : views) {
    const Eigen::Vector3d axis =
        (view.world_from_camera.rotation *
         view.camera.Ray(0.5 * (view.camera.width - 1), 0.5 * (view.camera.height - 1)))
            .normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    h += across;
    g += across * view.world_from_camera.translation_m;
  }
  return h.ldlt().solve(g);
}

Measured MeasureSilhouettes(std::span<const ObjectView> views, int max_views) {
  Measured measured;
  const LevelFrame level = FindLevel(views);
  measured.has_ground = level.has_ground;
  for (const std::size_t n : ChooseViews(views, AxesMeet(views), max_views)) {
    SilhouetteView silhouette(views[n], level.level_from_world);
    if (!silhouette.empty()) measured.silhouettes.push_back(std::move(silhouette));
  }
  return measured;
}

struct Match {
  std::size_t model = 0;
  double score = 0;
  Placement placement;
};

// "a/b" with stretch (1.1, 0.95, 1) -> "a__b_s110_095_100"; an even stretch is none.
std::string ModelKey(const LibraryModel& model, const std::array<int, 3>& percent) {
  std::string key = model.id;
  if (const std::size_t slash = key.find('/'); slash != std::string::npos)
    key.replace(slash, 1, "__");
  if (percent[0] == percent[1] && percent[1] == percent[2]) return key;
  key += "_s";
  for (std::size_t n = 0; n < 3; ++n) {
    const std::string digits = std::to_string(percent[n]);
    if (n > 0) key.push_back('_');
    if (digits.size() < 3) key.append(3 - digits.size(), '0');
    key.append(digits);
  }
  return key;
}

class RetrievalProposer final : public Proposer {
 public:
  RetrievalProposer(std::shared_ptr<const ModelLibrary> library,
                    ClassTable classes,
                    const RetrievalOptions& options,
                    InputChannels channels)
      : library_(std::move(library)),
        classes_(std::move(classes)),
        options_(options),
        channels_(channels),
        made_(library_->models.size()) {}

  [[nodiscard]] std::string name() const override { return "retrieval"; }
  [[nodiscard]] Result<Proposals> Propose(const ObjectObservations& object) const override;

 private:
  [[nodiscard]] std::vector<std::size_t> ModelsFor(const ObjectObservations& object,
                                                   const Measured& measured) const;
  [[nodiscard]] double SizeMisfit(const LibraryModel& model, const Measured& measured) const;
  [[nodiscard]] const CoarseShape& Coarse(std::size_t model) const;
  void MakeCoarse(std::span<const std::size_t> models) const;
  [[nodiscard]] Match BestPlacement(std::size_t model, const Measured& measured) const;
  [[nodiscard]] PlaceLimits Limits() const {
    return {RetrievalOptions::kStretchMin, RetrievalOptions::kStretchMax};
  }
  [[nodiscard]] double Score(const Measured& measured, const Match& match) const;
  void AddCandidate(const ObjectObservations& object,
                    const Match& match,
                    Proposals& proposals) const;
  [[nodiscard]] Match Unstretched(const Match& match, const Measured& measured) const;

  std::shared_ptr<const ModelLibrary> library_;
  ClassTable classes_;
  RetrievalOptions options_;
  InputChannels channels_;
  // Made on first use: most runs need a few classes only.
  struct Made {
    std::mutex mutex;
    std::unique_ptr<const CoarseShape> shape;

    // While the mutex is held.
    void Ensure(const VoxelGrid& grid) {
      if (!shape) shape = std::make_unique<const CoarseShape>(grid);
    }
  };
  mutable std::vector<Made> made_;
};

const CoarseShape& RetrievalProposer::Coarse(std::size_t model) const {
  Made& made = made_[model];
  const std::lock_guard<std::mutex> lock(made.mutex);
  made.Ensure(library_->models[model].shape);
  return *made.shape;
}

// Objects of one class come for the same models at once: those that another thread is at are left
// to it instead of waited for.
void RetrievalProposer::MakeCoarse(std::span<const std::size_t> models) const {
  ParallelFor(models.size(), [&](std::size_t n) {
    Made& made = made_[models[n]];
    const std::unique_lock<std::mutex> lock(made.mutex, std::try_to_lock);
    if (lock) made.Ensure(library_->models[models[n]].shape);
  });
}

// By which factor the model's real size misses what was measured, 1 where it fits within its
// stretch. Of the object some may be hidden, so that models may be larger. Silhouettes alone
// measure no size.
double RetrievalProposer::SizeMisfit(const LibraryModel& model, const Measured& measured) const {
  constexpr double kHidden = 2.0;  // at least half of each side is seen
  if (measured.depth.boxes.empty()) return 1;
  const auto sides = [](const Eigen::Vector3d& size_m) {
    return std::array<double, 3>{
        size_m.head<2>().maxCoeff(), size_m.head<2>().minCoeff(), size_m.z()};
  };
  const std::array<double, 3> real = sides(model.size_m);
  const std::array<double, 3> seen = sides(measured.depth.boxes.front().size_m);
  double misfit = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double most_m = seen[axis] * (axis == 2 ? 1.0 : kHidden);
    misfit = std::max({misfit,
                       seen[axis] / (real[axis] * RetrievalOptions::kStretchMax),
                       real[axis] * RetrievalOptions::kStretchMin / most_m});
  }
  return misfit;
}

// Models of the classes that may stand for the object's; for an object of the fallback class, or of
// one without models, all of its size. What nobody named was given its class by its size: of the
// models of its class those of its size, or those nearest to it where there are none.
std::vector<std::size_t> RetrievalProposer::ModelsFor(const ObjectObservations& object,
                                                      const Measured& measured) const {
  const ObjectClass* const object_class = classes_.Find(object.class_name);
  const auto is_of_class = [&](const LibraryModel& model) {
    return model.class_name == object.class_name ||
           (object_class != nullptr &&
            std::ranges::count(object_class->library_classes, model.class_name) > 0);
  };
  const bool by_class = std::ranges::any_of(library_->models, is_of_class) &&
                        !(object_class != nullptr && object_class->traits.fallback);
  std::vector<std::pair<double, std::size_t>> by_misfit;
  for (std::size_t n = 0; n < library_->models.size(); ++n) {
    const LibraryModel& model = library_->models[n];
    if (by_class && !is_of_class(model)) continue;
    by_misfit.emplace_back(by_class && object.is_named ? 1 : SizeMisfit(model, measured), n);
  }
  std::ranges::sort(by_misfit);
  const bool none_fits = by_misfit.empty() || by_misfit.front().first > 1;
  const auto least =
      by_class && none_fits ? static_cast<std::size_t>(options_.max_models) : std::size_t{0};
  std::vector<std::size_t> models;
  for (const auto& [misfit, n] : by_misfit) {
    if (misfit <= 1 || models.size() < least) models.push_back(n);
  }
  std::ranges::sort(models);
  return models;
}

double RetrievalProposer::Score(const Measured& measured, const Match& match) const {
  const CoarseShape& shape = Coarse(match.model);
  if (measured.silhouettes.empty()) return ScorePlaced(shape, match.placement, measured.depth);
  return ScoreSilhouettes(
      shape, match.placement, library_->models[match.model].size_m, measured.silhouettes);
}

Match RetrievalProposer::BestPlacement(std::size_t model, const Measured& measured) const {
  const Eigen::Vector3d& real_m = library_->models[model].size_m;
  if (!measured.silhouettes.empty()) {
    const SilhouetteFit fit = FitSilhouettes(
        Coarse(model),
        real_m,
        measured.silhouettes,
        {RetrievalOptions::kStretchMin, RetrievalOptions::kStretchMax, measured.has_ground});
    return {model, fit.score, fit.placement};
  }
  const PlacedShape placed = PlaceShape(Coarse(model), real_m, measured.depth, Limits());
  return {model, placed.score, placed.placement};
}

Match RetrievalProposer::Unstretched(const Match& match, const Measured& measured) const {
  const Eigen::Vector3d& real_m = library_->models[match.model].size_m;
  const double factor = std::cbrt((match.placement.size_m.array() / real_m.array()).prod());
  Match even = match;
  even.placement.size_m = factor * real_m;
  even.score = Score(measured, even);
  return even;
}

void RetrievalProposer::AddCandidate(const ObjectObservations& object,
                                     const Match& match,
                                     Proposals& proposals) const {
  const LibraryModel& model = library_->models[match.model];
  std::array<int, 3> percent{};
  Eigen::Vector3d factors;
  for (int n = 0; n < 3; ++n) {
    const double factor = match.placement.size_m[n] / model.size_m[n];
    const int steps = static_cast<int>(std::lround(100.0 * factor / kStretchStep_percent));
    percent[static_cast<std::size_t>(n)] = steps * kStretchStep_percent;
    factors[n] = 0.01 * steps * kStretchStep_percent;
  }
  ShapeCandidate candidate;
  candidate.object = object.id;
  candidate.source = CandidateSource::kRetrieval;
  candidate.model = ModelKey(model, percent);
  candidate.proposal_score = match.score;
  candidate.library_id = model.id;
  const bool even = percent[0] == percent[1] && percent[1] == percent[2];
  if (!even) candidate.stretch = factors;
  candidate.credit = model.name + " by " + model.creator + ", " + model.licence;
  SetSize(match.placement.size_m.maxCoeff(),
          RetrievalOptions::kSizeMargin,
          classes_.Find(object.class_name),
          candidate);
  for (const ShapeCandidate& other : proposals.candidates) {
    if (other.model == candidate.model) return;
  }
  if (!proposals.models.contains(candidate.model)) {
    proposals.models[candidate.model] =
        even ? model.shape : shape::StretchGrid(model.shape, factors);
  }
  proposals.candidates.push_back(std::move(candidate));
}

Result<Proposals> RetrievalProposer::Propose(const ObjectObservations& object) const {
  Proposals proposals;
  const std::string subject =
      "object " + std::to_string(object.id.value) + " (" + object.class_name + "): ";
  if (classes_.TraitsOf(object.class_name).fused_only) {
    proposals.notes.push_back(subject + "no model stands for its class");
    return proposals;
  }
  const bool by_depth = channels_ == InputChannels::kColourAndDepth;
  Measured measured;
  if (by_depth) {
    measured.depth = MeasureDepth(
        object, !classes_.TraitsOf(object.class_name).yaw_free, RetrievalOptions::kMaxViews);
  } else {
    measured = MeasureSilhouettes(object.views, RetrievalOptions::kMaxViews);
  }
  if (measured.empty()) {
    proposals.notes.push_back(subject + (by_depth ? "too few depth points for retrieval"
                                                  : "no silhouette for retrieval"));
    return proposals;
  }
  const std::vector<std::size_t> models = ModelsFor(object, measured);
  if (models.empty()) {
    proposals.notes.push_back(subject + "no library model of its class or size");
    return proposals;
  }
  MakeCoarse(models);
  std::vector<Match> matches(models.size());
  ParallelFor(models.size(),
              [&](std::size_t n) { matches[n] = BestPlacement(models[n], measured); });
  std::stable_sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) {
    return a.score > b.score;
  });
  // The best designs are offered in the catalogue's own proportions as well: a stretch fitted to a
  // partly seen object may be wrong.
  constexpr std::size_t kAlsoUnstretched = 3;
  for (std::size_t n = 0; n < matches.size() && static_cast<int>(n) < options_.max_models; ++n) {
    if (matches[n].score <= 0) break;
    AddCandidate(object, matches[n], proposals);
    if (n < kAlsoUnstretched) AddCandidate(object, Unstretched(matches[n], measured), proposals);
  }
  if (proposals.candidates.empty()) proposals.notes.push_back(subject + "no library model fits it");
  BestFirst(proposals.candidates);
  return proposals;
}

}  // namespace

void Describe(OptionsVisitor& visitor, RetrievalOptions& options) {
  visitor.Field(
      "max_models", options.max_models, {1, 100}, "1", "library designs offered per object");
}

std::unique_ptr<Proposer> MakeRetrievalProposer(std::shared_ptr<const ModelLibrary> library,
                                                const ClassTable& classes,
                                                const RetrievalOptions& options,
                                                InputChannels channels) {
  DEEPSLAM_CHECK(library != nullptr, "retrieval without a library");
  return std::make_unique<RetrievalProposer>(std::move(library), classes, options, channels);
}

}  // namespace deepslam::propose
