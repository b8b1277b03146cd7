// Keyframes that look alike, by bags of binary words (Galvez-Lopez, Tardos 2012): a tree of words
// made of the capture's own descriptors, an inverted index, and the words' rarity as weight.
//
// Work per keyframe grows with the lists of its words, which are bounded: a word that more than
// one keyframe in `kCommonWord` has says nothing and is left out.
#pragma once

#include <span>
#include <vector>

#include "deepslam/loop/keyframe_features.h"

namespace deepslam::loop {

struct SimilarKeyframe {
  std::size_t index = 0;  // into the features given
  double score = 0;       // 0 to 1: shared weight of the words
};

struct SimilarityOptions {
  int min_gap = 20;           // entries between two keyframes that are compared
  int max_candidates = 5;     // per keyframe
  double min_relative = 0.3;  // of the similarity to the keyframe's own neighbour
};

// Per entry of `features` (in the order of the path) the earlier entries that look most like it,
// best first; of neighbours among them the best. Empty lists where there is nothing to compare.
// Same result for any thread count.
[[nodiscard]] std::vector<std::vector<SimilarKeyframe>> FindSimilarKeyframes(
    std::span<const KeyframeFeatures> features, const SimilarityOptions& options);

}  // namespace deepslam::loop
