#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <map>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/propose/best_first.h"
#include "deepslam/propose/candidate_size.h"
#include "deepslam/propose/joined_encoding.h"
#include "deepslam/propose/level_box.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/network_crop.h"
#include "deepslam/propose/place_shape.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::propose {
namespace {

class NetworkProposer final : public Proposer {
 public:
  NetworkProposer(ShapePriors priors,
                  ClassTable classes,
                  const NetworkOptions& options,
                  InputChannels channels)
      : priors_(std::move(priors)),
        classes_(std::move(classes)),
        options_(options),
        channels_(channels) {}

  [[nodiscard]] std::string name() const override { return "network"; }
  [[nodiscard]] Result<Proposals> Propose(const ObjectObservations& object) const override;

 private:
  void Add(const ObjectObservations& object,
           const ShapePrior& prior,
           const PriorEncoding& encoding,
           const ObjectView* view,
           double size_m,
           Proposals& proposals) const;
  void AddFitted(const ObjectObservations& object,
                 const MeasuredDepth& measured,
                 Proposals& proposals) const;

  ShapePriors priors_;
  ClassTable classes_;
  NetworkOptions options_;
  InputChannels channels_;
};

// Longest side of what was measured, and its middle in the world; size 0: nothing was.
struct Extent {
  double size_m = 0;
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();
};

Extent MeasureExtent(const LevelCloud& cloud) {
  Extent extent;
  if (cloud.points.empty()) return extent;
  const LevelBox box = MeasureBox(cloud.points);
  extent.size_m = box.size_m.maxCoeff();
  extent.center_world = cloud.level_from_world.Inverse() *
                        Eigen::Vector3d(box.center_m.x(), box.center_m.y(), 0.5 * box.size_m.z());
  return extent;
}

std::string NoteStart(const ObjectObservations& object) {
  return "object " + std::to_string(object.id.value) + " (" + object.class_name + "): ";
}

std::string NoteOf(const ObjectObservations& object, const ObjectView& view) {
  return NoteStart(object) + "frame " + std::to_string(view.frame.value) + ": ";
}

void NetworkProposer::Add(const ObjectObservations& object,
                          const ShapePrior& prior,
                          const PriorEncoding& encoding,
                          const ObjectView* view,
                          double size_m,
                          Proposals& proposals) const {
  const bool by_depth = channels_ == InputChannels::kColourAndDepth;
  Result<VoxelGrid> shape = prior.Decode(encoding.latents, by_depth);
  if (!shape.ok()) {
    proposals.notes.push_back(NoteStart(object) + shape.error().message);
    return;
  }
  std::array<char, 48> key{};
  if (view != nullptr) {
    std::snprintf(key.data(), key.size(), "net_%03d_%06d", object.id.value, view->detection.value);
  } else {
    std::snprintf(key.data(), key.size(), "net_%03d_mean", object.id.value);
  }
  ShapeCandidate candidate;
  candidate.object = object.id;
  candidate.source = view != nullptr ? CandidateSource::kNetwork : CandidateSource::kMeanLatent;
  if (view != nullptr) candidate.view = view->detection;
  candidate.model = key.data();
  candidate.proposal_score = std::clamp(encoding.confidence, 0.0, 1.0);
  candidate.latents.assign(encoding.latents.begin(), encoding.latents.end());
  const ObjectClass* const object_class = classes_.Find(object.class_name);
  if (size_m > 0) {
    SetSize(size_m, NetworkOptions::kSizeMargin, object_class, candidate);
  } else if (object_class != nullptr) {
    candidate.min_size_m = object_class->min_size_m;
    candidate.max_size_m = object_class->max_size_m;
  }
  proposals.models.emplace(candidate.model, std::move(*shape));
  proposals.candidates.push_back(std::move(candidate));
}

// The shape that was added last, in the proportions that agree best with all depth: of one view, of
// which the picture's border cuts a part, a network cannot know how long a table is for its height.
void NetworkProposer::AddFitted(const ObjectObservations& object,
                                const MeasuredDepth& measured,
                                Proposals& proposals) const {
  if (proposals.candidates.empty() || measured.empty()) return;
  const ShapeCandidate& last = proposals.candidates.back();
  const VoxelGrid& grid = proposals.models.at(last.model);
  const CoarseShape shape(grid);
  if (shape.empty() || !(last.size_m > 0)) return;
  const Eigen::Vector3d extent = shape.extent().cast<double>();
  const Eigen::Vector3d believed_m = last.size_m / extent.maxCoeff() * extent;
  // Wider than a design's: a product has been measured, a network guesses.
  constexpr PlaceLimits kLimits = {0.5, 1.6, 0.3};
  const PlacedShape placed = PlaceShape(shape, believed_m, measured, kLimits);
  const Eigen::Vector3d factors = placed.placement.size_m.cwiseQuotient(believed_m);
  // Sides changed by nearly one factor: the candidate would be the last one again.
  constexpr double kAlikeSides = 1.05;
  if (placed.score <= 0 || factors.maxCoeff() < kAlikeSides * factors.minCoeff()) return;
  ShapeCandidate candidate = last;
  candidate.source = CandidateSource::kMeanLatent;
  candidate.view = DetectionId();
  candidate.model += "_fitted";
  candidate.latents.clear();  // they give the shape in its own proportions
  SetSize(placed.placement.size_m.maxCoeff(),
          NetworkOptions::kSizeMargin,
          classes_.Find(object.class_name),
          candidate);
  VoxelGrid stretched = shape::StretchGrid(grid, factors);
  proposals.models.emplace(candidate.model, std::move(stretched));
  proposals.candidates.push_back(std::move(candidate));
}

// Numbers of the surest, at most so many; equally sure ones in their order.
std::vector<std::size_t> SurestFirst(std::span<const PriorEncoding> encodings, std::size_t most) {
  std::vector<std::size_t> order(encodings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return encodings[a].confidence > encodings[b].confidence;
  });
  order.resize(std::min(order.size(), most));
  return order;
}

Result<Proposals> NetworkProposer::Propose(const ObjectObservations& object) const {
  Proposals proposals;
  const auto found = priors_.find(object.class_name);
  if (found == priors_.end() || classes_.TraitsOf(object.class_name).fused_only) {
    proposals.notes.push_back(NoteStart(object) + "its class has no prior");
    return proposals;
  }
  const ShapePrior& prior = *found->second;
  const bool by_depth = channels_ == InputChannels::kColourAndDepth;
  const int num_read = std::max(NetworkOptions::kReadViews, options_.max_views);
  const bool has_front = !classes_.TraitsOf(object.class_name).yaw_free;
  const MeasuredDepth measured =
      by_depth ? MeasureDepth(object, has_front, num_read) : MeasuredDepth();
  const Extent extent = MeasureExtent(measured.cloud);
  std::vector<PriorEncoding> encodings;
  std::vector<const ObjectView*> encoded;
  for (const std::size_t n : ChooseViews(object.views, extent.center_world, num_read)) {
    const ObjectView& view = object.views[n];
    const Result<NetworkCrop> crop = MakeNetworkCrop(view, by_depth);
    if (!crop.ok()) {
      proposals.notes.push_back(NoteOf(object, view) + crop.error().message);
      continue;
    }
    const Result<PriorEncoding> encoding = prior.Encode(*crop);
    if (!encoding.ok()) {
      proposals.notes.push_back(NoteOf(object, view) + encoding.error().message);
      continue;
    }
    encodings.push_back(*encoding);
    encoded.push_back(&view);
  }
  for (const std::size_t n : SurestFirst(encodings, static_cast<std::size_t>(options_.max_views)))
    Add(object, prior, encodings[n], encoded[n], extent.size_m, proposals);
  if (options_.mean_latent && encodings.size() > 1)
    Add(object, prior, JoinEncodings(encodings), nullptr, extent.size_m, proposals);
  if (options_.fit_proportions) AddFitted(object, measured, proposals);
  if (proposals.candidates.empty() && proposals.notes.empty())
    proposals.notes.push_back(NoteStart(object) + "none of its views shows a silhouette");
  BestFirst(proposals.candidates);
  return proposals;
}

}  // namespace

void Describe(OptionsVisitor& visitor, NetworkOptions& options) {
  visitor.Field("max_views",
                options.max_views,
                {1, 1000},
                "1",
                "views of an object whose own shape is offered, of those that are read the surest");
  visitor.Field("mean_latent",
                options.mean_latent,
                "also offer the shape of the views' latents together, their geometric median");
  visitor.Field("fit_proportions",
                options.fit_proportions,
                "also offer that shape stretched along its axes to what all depth says");
}

std::unique_ptr<Proposer> MakeNetworkProposer(ShapePriors priors,
                                              const ClassTable& classes,
                                              const NetworkOptions& options,
                                              InputChannels channels) {
  return std::make_unique<NetworkProposer>(std::move(priors), classes, options, channels);
}

}  // namespace deepslam::propose
