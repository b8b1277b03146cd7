// Shapes of an object that all its depth makes of others (module refine): networks' shapes moved
// until they agree with it, the best model completed by it. Further candidates, which compete with
// those they came from.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "deepslam/modelling/candidate_set.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/shape_candidate.h"

namespace deepslam::modelling {

// From the network's candidate that agrees best, and from the mean latent of the views: each
// refined. Candidates come with invalid ids and views; a start that leads nowhere gives a note.
// `set` is scored.
[[nodiscard]] Proposals RefineShapes(const CandidateSet& set,
                                     std::span<const ObjectView> views,
                                     const propose::ShapePrior& prior,
                                     const ObjectOptions& options);

// The whole model that would be selected, completed by what was measured, under a name that begins
// with `change`; its size is what was measured, and its bounds reach to it. Nothing where there is
// none.
[[nodiscard]] Proposals CompleteBest(const CandidateSet& set,
                                     std::span<const ObjectView> views,
                                     std::string_view change,
                                     const ObjectOptions& options);

// With select.refine.pose: the similarity of what would be selected, refined jointly over all
// views. Its registration and score are replaced where the score improves and it still wins; else
// nothing changes. Index of what was replaced. `set` is scored.
std::optional<std::size_t> RefineWinner(std::span<const ObjectView> views,
                                        const ObjectOptions& options,
                                        CandidateSet& set);

}  // namespace deepslam::modelling
