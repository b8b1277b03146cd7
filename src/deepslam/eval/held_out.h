// Agreement of a placed model with depth that had no part in making it, where no truth is known.
#pragma once

#include <cstdint>
#include <string_view>

#include "deepslam/core/image.h"
#include "deepslam/frames/pixel_mask.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::eval {

inline constexpr std::string_view kHeldOutProtocol =
    "held-out depth: rendered model against frames that no view of the object comes from; agrees "
    "within 2 cm, contradicted where the ray goes on, hidden pixels left out";
inline constexpr std::string_view kOtherViewsProtocol =
    "views of another run of the same capture, made of other detections: rendered model against "
    "their frames, agrees within 2 cm, contradicted where the ray goes on, hidden pixels left out; "
    "depth_near is the share of their object's depth within 2 cm of the "
    "model's surface";
inline constexpr double kHeldOutToleranceM = 0.02;  // m; part of the protocol above

struct HeldOutAgreement {
  std::int64_t num_agree = 0;     // pixels measured within the tolerance of the model
  std::int64_t num_violated = 0;  // the ray goes on behind the model: free space
  std::int64_t num_hidden = 0;    // something nearer was measured: says nothing

  [[nodiscard]] std::int64_t num_judged() const { return num_agree + num_violated; }
  // Share of scored pixels that agree; 0 where none was scored.
  [[nodiscard]] double agreement() const;
  HeldOutAgreement& operator+=(const HeldOutAgreement& other);
};

// Depth and camera have one size.
[[nodiscard]] HeldOutAgreement ScoreHeldOut(const TriangleMesh& mesh,
                                            const Pose3& camera_from_mesh,
                                            const PinholeCamera& camera,
                                            const DepthImage& depth_m);

// Of the depth that a view measured of an object, what lies on the surface of its model.
struct MeasuredShare {
  std::int64_t num_near = 0;  // pixels within kHeldOutToleranceM of the surface
  std::int64_t num_measured = 0;

  [[nodiscard]] double share() const;  // 0 where nothing was measured
  MeasuredShare& operator+=(const MeasuredShare& other);
};

// `mask` is the object's part of the image; it, depth and camera have one size.
[[nodiscard]] MeasuredShare ScoreMeasured(const shape::ShapeModel& model,
                                          const Similarity3& camera_from_object,
                                          const PinholeCamera& camera,
                                          const DepthImage& depth_m,
                                          const Mask& mask);

}  // namespace deepslam::eval
