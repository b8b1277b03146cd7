#include "deepslam/modelling/moved_objects.h"

#include <algorithm>
#include <optional>

namespace deepslam::modelling {
namespace {

std::optional<Pose3> AfterFromBefore(const Trajectory& before,
                                     const Trajectory& after,
                                     FrameIdx frame) {
  if (!frame.valid() || frame.value >= static_cast<int>(before.frames.size())) return std::nullopt;
  const Pose3& from = before.at(frame).world_from_camera;
  const Pose3& to = after.at(frame).world_from_camera;
  return from == to ? Pose3{} : to * from.Inverse();
}

}  // namespace

Pose3 MovedWith(const Trajectory& before, const Trajectory& after, const MapObject& object) {
  Pose3 best;
  double share = -1;
  for (const ViewRegistration& view : object.views) {
    const std::optional<Pose3> own = AfterFromBefore(before, after, view.frame);
    if (!own || view.inlier_share <= share) continue;
    share = view.inlier_share;
    best = *own;
  }
  return best;
}

double MovedApart_m(const Trajectory& before,
                    const Trajectory& after,
                    const MapObject& object,
                    const Eigen::Vector3d& centre) {
  const Pose3 best = MovedWith(before, after, object);
  double apart_m = 0;
  for (const ViewRegistration& view : object.views) {
    const std::optional<Pose3> own = AfterFromBefore(before, after, view.frame);
    if (own) apart_m = std::max(apart_m, (*own * centre - best * centre).norm());
  }
  return apart_m;
}

void MoveObjects(const Trajectory& before, const Trajectory& after, ObjectMap& map) {
  for (MapObject& object : map.objects)
    object.world_from_object = MovedWith(before, after, object) * object.world_from_object;
}

}  // namespace deepslam::modelling
