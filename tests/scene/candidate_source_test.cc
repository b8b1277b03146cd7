#include "deepslam/scene/candidate_source.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

TEST(SourceTraits, EverySourceHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (const SourceTraits& traits : AllSourceTraits()) {
    EXPECT_FALSE(traits.name.empty());
    EXPECT_FALSE(traits.in_words.empty()) << traits.name;
    EXPECT_TRUE(names.insert(traits.name).second) << traits.name;
    EXPECT_TRUE(std::all_of(traits.name.begin(), traits.name.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || c == '_';
    })) << traits.name;
  }
}

// What the table says of one column has to fit what it says of the others.
TEST(SourceTraits, AreOfOnePiece) {
  for (const SourceTraits& traits : AllSourceTraits()) {
    // What was measured is of this depth, and there is no whole model to complete.
    if (traits.is_partial) {
      EXPECT_TRUE(traits.follows_depth) << traits.name;
      EXPECT_FALSE(traits.can_be_completed) << traits.name;
    }
    // What is made in selection is made of the depth.
    if (traits.is_derived) {
      EXPECT_TRUE(traits.follows_depth) << traits.name;
    }
    // Whoever follows the depth agrees with it by nature and needs a margin for it; of others only
    // who has many designs to choose from.
    const bool needs_margin = traits.follows_depth || traits.margin == WinningMargin::kCatalogue;
    EXPECT_EQ(needs_margin, traits.margin != WinningMargin::kNone) << traits.name;
    EXPECT_EQ(traits.is_partial, traits.margin == WinningMargin::kUnseenSides) << traits.name;
  }
}

TEST(SourceTraits, StandInTheOrderOfTheEnumeration) {
  EXPECT_EQ(TraitsOf(CandidateSource::kNetwork).name, "network");
  EXPECT_EQ(TraitsOf(CandidateSource::kMeanLatent).name, "mean_latent");
  EXPECT_EQ(TraitsOf(CandidateSource::kRetrieval).name, "retrieval");
  EXPECT_EQ(TraitsOf(CandidateSource::kFused).name, "fused");
  EXPECT_EQ(TraitsOf(CandidateSource::kRefined).name, "refined");
  EXPECT_EQ(TraitsOf(CandidateSource::kCompleted).name, "completed");
}

}  // namespace
}  // namespace deepslam
