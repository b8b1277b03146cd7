// Where a model may stand in the world, from the alignments of single views, scored against all
// views.
#pragma once

#include <span>
#include <vector>

#include "deepslam/registration/register_shape.h"
#include "deepslam/registration/visible_surface.h"
#include "deepslam/scene/layout.h"

namespace deepslam::registration {

// What is known of a placement before any point is looked at.
struct PlacementPrior {
  double min_m = 0;  // metres per object unit
  double max_m = 0;
  double expected_m = 0;  // 0 = unknown
  bool stands = true;     // whole furniture stands on the ground; a fused part of it need not
  // The room, along the path of the views; none where it is not known or the thing has no front.
  const Layout* layout = nullptr;
};

struct WorldHypothesis {
  Similarity3 world_from_object;
  double disagreement = 0;  // Disagreement() + FacingCost(); smaller is better
};

// What turning its back to the cameras costs a placement, and its front to a wall, in units of
// Disagreement(). Of what is left of a chair behind a table, or of a cabinet seen from afar, the
// depth cannot tell the front from the back; but cameras go where people do, and furniture faces
// them, with its back to the wall it stands at. Far below what seeing the legs or the seat says.
[[nodiscard]] double FacingCost(const shape::ShapeModel& model,
                                const Similarity3& world_from_object,
                                std::span<const MeasuredView* const> views,
                                const Layout* layout);

// Every azimuth of the best seed views, carried into the world by the tracked cameras, each at the
// scale of its moments and at the size the source believes, moved vertically until the model stands
// on the ground where one is known. Best first, near-duplicates left out, at most
// RegisterOptions::kNumRefinedHypotheses.
[[nodiscard]] std::vector<WorldHypothesis> FindHypotheses(
    const shape::ShapeModel& model,
    VisibleSurface& visible,
    std::span<const MeasuredView* const> views,
    const PlacementPrior& prior);

}  // namespace deepslam::registration
