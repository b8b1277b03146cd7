// What one view says about one placed model: its object points against the model's surface, and the
// model's surface against what the view measured where that surface should be seen.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/select/select_options.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::select {

// A view made ready for scoring; once per object.
struct ScoredView {
  DetectionId view;
  FrameIdx frame;
  std::vector<Eigen::Vector3f> points_camera;  // of the object's segment, metres
  PinholeCamera camera;                        // of the reduced crop
  DepthImage depth_m;
  Mask mask;
  Pose3 world_from_camera;
  std::optional<Plane> ground_camera;
};

// Keeps the order of `views`; an unusable view has neither points nor images.
[[nodiscard]] std::vector<ScoredView> PrepareForScoring(std::span<const ObjectView> views);

// Surface: each object point agrees fully within a tolerance of the model's surface
// (model_tolerance + 2 sigma of the sensor at its depth + half a voxel) and fades to nothing over
// `fade` beyond it. Reached: the points within `reach` of the surface; those further off may be of
// something else that was cut out with the object.
//
// Coverage: every pixel of the rendered model is
//   confirmed     if the point measured there, or in a neighbouring pixel, lies on the model by the
//   same measure, contradicted  if the ray goes on behind the model (violation), or ends before it
//   on the object itself, unknown       if depth is missing or something else stands before it; it
//   counts for nothing.
// Between confirmed and contradicted there is the same fade.
[[nodiscard]] ViewAgreement MeasureAgreement(const shape::ShapeModel& model,
                                             const Similarity3& camera_from_object,
                                             const ScoredView& view,
                                             const SelectOptions& options);

// Share of the whole model's surface that at least one view confirmed: facing the camera, and the
// measured point in its pixel lies on the model. The rest is the prior's word alone.
// `camera_from_object` runs parallel to `views`.
[[nodiscard]] double SeenShare(const shape::ShapeModel& model,
                               std::span<const Similarity3> camera_from_object,
                               std::span<const ScoredView> views);

}  // namespace deepslam::select
