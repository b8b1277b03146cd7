#include "deepslam/scene/candidate_source.h"

namespace deepslam {
namespace {

constexpr std::array<SourceTraits, kNumCandidateSources> kTraits = {
    {{.name = "network", .in_words = "network", .can_be_completed = true},
     {.name = "mean_latent", .in_words = "network, mean of views", .can_be_completed = true},
     {.name = "retrieval",
      .in_words = "CAD library",
      .can_be_completed = true,
      .margin = WinningMargin::kCatalogue},
     {.name = "fused",
      .in_words = "own measurement",
      .is_partial = true,
      .follows_depth = true,
      .margin = WinningMargin::kUnseenSides},
     {.name = "refined",
      .in_words = "network, refined",
      .follows_depth = true,
      .is_derived = true,
      .can_be_completed = true,
      .margin = WinningMargin::kRefined},
     {.name = "completed",
      .in_words = "model, completed by own measurement",
      .follows_depth = true,
      .is_derived = true,
      .margin = WinningMargin::kCompleted}}};

}  // namespace

const SourceTraits& TraitsOf(CandidateSource source) {
  return kTraits.at(static_cast<std::size_t>(source));
}

const std::array<SourceTraits, kNumCandidateSources>& AllSourceTraits() { return kTraits; }

}  // namespace deepslam
