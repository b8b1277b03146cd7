// Where a whole shape comes from, and what that says of it. Whoever places, scores or draws
// candidates asks for these properties and never which source it is, so that a new source states
// its own here and nothing else changes.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace deepslam {

enum class CandidateSource {
  kNetwork,     // class-specific network, from one view
  kMeanLatent,  // decoder at the mean latent over an object's views
  kRetrieval,   // CAD model of the library
  kFused,       // the object's own fused measurement
  kRefined,     // a network's shape that followed all depth of its object
  kCompleted,   // a whole model, or a refined shape, that took over what was measured
};
inline constexpr std::size_t kNumCandidateSources = 6;  // values of CandidateSource

// The margin by which a candidate's score wins; the figures are options of selection.
enum class WinningMargin {
  kNone,
  kUnseenSides,  // a little, and more the more sides nobody saw
  kCatalogue,    // the more the more sides nobody saw
  kRefined,
  kCompleted,
};

struct SourceTraits {
  std::string_view name;      // in artifacts and scenes
  std::string_view in_words;  // for people
  // The shape holds only what was measured: sides nobody saw are missing, it has no front of its
  // own, and its bottom need not be where the thing meets the ground.
  bool is_partial = false;
  // The shape was made of this object's depth, in all or in part. It agrees with it wherever it
  // stands, so it says nothing of where the object is.
  bool follows_depth = false;
  // Made in selection, of a candidate that a source proposed; its model lies there.
  bool is_derived = false;
  // A whole model that may take over what was measured.
  bool can_be_completed = false;
  WinningMargin margin = WinningMargin::kNone;
};

[[nodiscard]] const SourceTraits& TraitsOf(CandidateSource source);

// In artifacts and scenes.
[[nodiscard]] inline std::string_view NameOf(CandidateSource source) {
  return TraitsOf(source).name;
}

// In the order of the enumeration.
[[nodiscard]] const std::array<SourceTraits, kNumCandidateSources>& AllSourceTraits();

}  // namespace deepslam
