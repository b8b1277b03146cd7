// The part of an object's true surface that no frame of a capture saw, and how much of it a placed
// model has right. What lies on the seen side any method measures; the rest is what a prior knows.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::eval {

inline constexpr std::string_view kUnseenProtocol =
    "unseen surface: points of the true outer surface, 1 per cm^2, that no frame shows by the "
    "instance masks and measures within 3 cm or 2 % of the depth; the share within 5 cm of the "
    "placed model's surface";
inline constexpr double kUnseenToleranceM = 0.05;  // m; part of the protocol above

// What one frame shows. Depth, instances and camera have one size.
struct InstanceView {
  const PinholeCamera& camera;
  const Pose3& camera_from_world;
  const DepthImage& depth_m;              // 0: not measured
  const Image<std::uint16_t>& instances;  // number of the object that each pixel shows; 0: none
};

// Sets seen[n] where the frame shows points_world[n] as part of object `number`. Neither is ever
// reset, so that frames are added one after the other. `seen` has the points' size.
void MarkSeen(const InstanceView& view,
              int number,
              std::span<const Eigen::Vector3d> points_world,
              std::vector<bool>& seen);

// Share of the points within the tolerance of the model's surface; 0 without points or for an empty
// model.
[[nodiscard]] double ShareOnSurface(const shape::ShapeModel& model,
                                    const Similarity3& world_from_object,
                                    std::span<const Eigen::Vector3d> points_world,
                                    double tolerance_m = kUnseenToleranceM);

}  // namespace deepslam::eval
