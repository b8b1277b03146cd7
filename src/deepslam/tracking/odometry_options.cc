#include "deepslam/tracking/odometry_options.h"

#include <array>
#include <string_view>

namespace deepslam::tracking {

void Describe(OptionsVisitor& visitor, OdometryOptions& options) {
  static constexpr std::array<std::string_view, 2> kReferences = {"keyframe", "previous"};
  Describe(visitor, options.alignment);
  visitor.Choice("reference", options.reference, kReferences, "what a frame is aligned to");
  visitor.Field("motion_prediction", options.motion_prediction, "start from constant velocity too");
  visitor.Field(
      "rotation_search", options.rotation_search, "start from an image-based rotation too");
  visitor.Retired("skip_edges", "keyframes are joined to those that see the same; remove it");
  visitor.Retired("wide_search", "doubtful alignments are not searched for again; remove it");
  visitor.Field("keyframe_distance_m",
                options.keyframe_distance_m,
                {0.005, 10},
                "m",
                "a new keyframe beyond this distance");
  visitor.Field("keyframe_angle_deg",
                options.keyframe_angle_deg,
                {0.5, 180},
                "deg",
                "a new keyframe beyond this angle");
  visitor.Field("keyframe_min_overlap",
                options.keyframe_min_overlap,
                {0, 1},
                "1",
                "a new keyframe below this overlap");
  visitor.Field("num_relocalisation_keyframes",
                options.num_relocalisation_keyframes,
                {2, 200},
                "1",
                "last keyframes kept to find the way back after a loss");
  visitor.Field("lost_translation_m",
                options.lost_translation_m,
                {0.001, 100},
                "m",
                "standard deviation of an edge across a loss");
  visitor.Field("lost_rotation_deg",
                options.lost_rotation_deg,
                {0.01, 180},
                "deg",
                "standard deviation of an edge across a loss");
  visitor.Field("capture_translation_m",
                options.capture_translation_m,
                {1e-6, 10},
                "m",
                "standard deviation of relative poses that came with the capture");
  visitor.Field("capture_rotation_deg",
                options.capture_rotation_deg,
                {1e-4, 180},
                "deg",
                "standard deviation of relative poses that came with the capture");
}

}  // namespace deepslam::tracking
