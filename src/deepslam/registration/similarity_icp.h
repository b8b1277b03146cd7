// Similarity ICP of a voxel model against one or many views at once: Eq. (1) of the paper, made
// well-posed.
//
// Eq. (1) measures the distance from each measured point to the model along the measured normal.
// Alone it rewards a wrong scale: a model that is large enough to present one flat patch to all
// points, or measured points shrunk into one spot of the model, leave no residual. What prevents it
// here:
//  - residuals are metric, in the object frame (the scale acts on the model, not on the
//  measurement);
//  - the way back: model surface that the camera must see is compared with what it measured there
//  (along the measured
//    normal where the object is, sideways towards the silhouette where the ray goes on into free
//    space);
//  - hard bounds on the scale, and a soft prior at the size the candidate's source believes.
// Robust by Tukey's weight on the distance, whose radius shrinks from coarse to fine over the
// iterations.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "deepslam/geometry/similarity.h"
#include "deepslam/registration/measured_view.h"
#include "deepslam/registration/view_matches.h"
#include "deepslam/registration/visible_surface.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::registration {

struct SimilarityIcpOptions {
  bool free_scale = true;
  bool both_directions = true;  // false: Eq. (1) alone, for showing why it is not enough
  int num_iterations = 12;
  double start_radius_m = 0.15;  // of the robust weight
  double end_radius_m = 0.05;
  // Least radius for measured points beside an edge of the model, which nothing nearer can claim.
  double edge_radius_m = 0;
  int point_stride = 1;       // every n-th measured point, and every n-th of the model's surface
  double min_scale_m = 1e-3;  // metres per object unit
  double max_scale_m = 1e3;
  // Priors as standard deviations; 0 = none.
  double upright_sigma_rad = 0.035;  // of the model's z against the views' up (UprightSigma)
  bool ground_firm = false;          // the bottom stays on the ground whatever the data say
  double ground_sigma_m = 0;         // of the model's bottom against the ground, where one is known
  double expected_scale_m = 0;       // with size_sigma, relative
  double size_sigma = 0;
  double hold_sigma_m = 0;  // of the start pose itself
  double hold_sigma_rad = 0;
};

// Starts at `world_from_object` and returns the refined similarity. Views that are empty are
// skipped; where nothing can be matched the start comes back, a free scale brought within its
// bounds. Always finite for a finite start and finite views.
[[nodiscard]] Similarity3 AlignShape(const shape::ShapeModel& model,
                                     VisibleSurface& visible,
                                     std::span<const MeasuredView* const> views,
                                     const Similarity3& world_from_object,
                                     const SimilarityIcpOptions& options);

// What AlignShape brings to vanish at a pose, its priors left out: both directions, all views.
// Residuals without weight are left out.
[[nodiscard]] std::vector<MotionResidual> ResidualsAt(const shape::ShapeModel& model,
                                                      VisibleSurface& visible,
                                                      std::span<const MeasuredView* const> views,
                                                      const Similarity3& world_from_object,
                                                      double radius_m,
                                                      const SimilarityIcpOptions& options);

// The deviation of the upright prior for so many views, rad. What tilts a wrong model does so in
// all of them alike, so that the prior counts once per view; where no ground is known, up is a
// guess that is wrong in all of them alike, and counts once.
[[nodiscard]] double UprightSigma(const MeasuredView& any_view,
                                  int num_views,
                                  const SimilarityIcpOptions& options);

// How badly a placed model disagrees with the views, in [0, 2]: mean truncated squared distance of
// the points to the model, plus that of the model's visible surface to the measurement, each
// relative to `radius_m`. 1 for a part that could not be scored at all.
[[nodiscard]] double Disagreement(const shape::ShapeModel& model,
                                  VisibleSurface& visible,
                                  std::span<const MeasuredView* const> views,
                                  const Similarity3& world_from_object,
                                  double radius_m,
                                  int point_stride);

}  // namespace deepslam::registration
