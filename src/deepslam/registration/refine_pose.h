// A placed model's position, rotation and scale, refined jointly over all its views by Ceres from a
// pose that is nearly right: the fine end of similarity_icp.h, by all points, down to a closer
// radius, with losses on the residuals themselves.
#pragma once

#include <span>

#include "deepslam/registration/similarity_icp.h"

namespace deepslam::registration {

// Residuals: Eq. (1) of all measured points, the model's visible surface against what was measured
// there and against free space (ResidualsAt), upright, bottom on the ground, and the size its
// source believes; the scale stays within options' bounds. Matched anew between rounds of Ceres.
// The start itself where it is not finite, and, with its scale brought within the bounds, where
// nothing can be matched or Ceres finds nothing usable; always finite for a finite start. Lengths
// of options: only priors and bounds are used.
[[nodiscard]] Similarity3 RefinePose(const shape::ShapeModel& model,
                                     VisibleSurface& visible,
                                     std::span<const MeasuredView* const> views,
                                     const Similarity3& world_from_object,
                                     const SimilarityIcpOptions& options);

}  // namespace deepslam::registration
