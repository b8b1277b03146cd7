// A placed model against one view, in both directions: measured points against the model, and the
// model's visible surface against what was measured where it falls.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/normal_equations.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/registration/measured_view.h"
#include "deepslam/registration/visible_surface.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::registration {

struct MatchOptions {
  double radius_m = 0.05;    // of the robust weight
  double edge_radius_m = 0;  // its least for measured points beside an edge of the model
  bool both_directions = true;
  int point_stride = 1;  // every n-th measured point, and every n-th of the model's surface
};

// What one measured point, or one visible point of the model, says of a small motion of the object
// in its own metric frame: that `residual_m`, which grows by direction . displacement of x, shall
// vanish. Weight: information, with robust weight on the distance, in 1 / m^2.
struct MotionResidual {
  Eigen::Vector3d direction_object = Eigen::Vector3d::Zero();  // unit
  Eigen::Vector3d x_object_m = Eigen::Vector3d::Zero();
  double residual_m = 0;
  double weight = 0;  // > 0
};

// The residuals of a view that is not empty and a model that is not empty.
[[nodiscard]] std::vector<MotionResidual> ResidualsOf(const shape::ShapeModel& model,
                                                      VisibleSurface& visible,
                                                      const MeasuredView& view,
                                                      const Similarity3& world_from_object,
                                                      const MatchOptions& options);

// Their normal equations for (translation; rotation; log scale), added to `equations`. Returns how
// many residuals there are.
int AddResidualsOf(const shape::ShapeModel& model,
                   VisibleSurface& visible,
                   const MeasuredView& view,
                   const Similarity3& world_from_object,
                   const MatchOptions& options,
                   SevenEquations& equations);

// Truncated squared distances relative to a radius, each in [0, 1], summed.
struct Misfit {
  double sum = 0;
  int count = 0;
};
struct ViewMisfit {
  Misfit forward;   // of the measured points to the model
  Misfit backward;  // of the model's visible surface to the measurement
};
// For a view and a model as above.
[[nodiscard]] ViewMisfit MisfitOf(const shape::ShapeModel& model,
                                  VisibleSurface& visible,
                                  const MeasuredView& view,
                                  const Similarity3& world_from_object,
                                  double radius_m,
                                  int point_stride);

// A measured point with its normal (object frame, object units) against the model; `scale_m` is
// metres per object unit.
struct PointMatch {
  double distance_m = 0;        // to the surface, >= 0
  double plane_residual_m = 0;  // along the measured normal (Eq. 1)
  double facing = 0;            // measured normal . model normal
};
[[nodiscard]] PointMatch MatchPoint(const shape::ShapeModel& model,
                                    const Eigen::Vector3d& point_object,
                                    const Eigen::Vector3d& normal_object,
                                    double scale_m);

}  // namespace deepslam::registration
