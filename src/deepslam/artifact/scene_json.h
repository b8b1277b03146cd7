// JSON forms of the vocabulary's small values, which stand in several files.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/artifact/json_visitor.h"
#include "deepslam/core/image.h"
#include "deepslam/geometry/box.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/detection.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::artifact {

inline constexpr Range kShare{0, 1};
inline constexpr Range kSizeM{0, 1e3};

void Describe(JsonVisitor& visitor, Eigen::Vector3d& value);        // [x, y, z]
void Describe(JsonVisitor& visitor, Eigen::Quaterniond& rotation);  // [x, y, z, w], unit
void Describe(JsonVisitor& visitor, Pose3& b_from_a);  // {rotation_xyzw, translation_m}
void Describe(JsonVisitor& visitor, Plane& plane);     // {normal, d_m}
void Describe(JsonVisitor& visitor, Box2& box);        // COCO's [x, y, width, height]
void Describe(JsonVisitor& visitor, Box3& box);        // {min, max}; null: empty
void Describe(JsonVisitor& visitor, PixelMask& mask);  // COCO's {size: [h, w], counts}; null: empty
void Describe(JsonVisitor& visitor, Rgb8& colour);     // [red, green, blue]
void Describe(JsonVisitor& visitor, Eigen::Matrix3d& matrix);  // row-major
void Describe(JsonVisitor& visitor, Matrix6d& matrix);
void Describe(JsonVisitor& visitor, SymmetricMatrix6d& matrix);  // all of it
void Describe(JsonVisitor& visitor, ViewRegistration& view);
void Describe(JsonVisitor& visitor, TrackingStatus& status);
void Describe(JsonVisitor& visitor, DetectionSource& source);
void Describe(JsonVisitor& visitor, CandidateSource& source);

}  // namespace deepslam::artifact
