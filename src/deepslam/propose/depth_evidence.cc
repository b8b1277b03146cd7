#include "deepslam/propose/depth_evidence.h"

namespace deepslam::propose {

shape::DepthView LevelView(const ObjectView& view, const Pose3& level_from_world) {
  return {view, (level_from_world * view.world_from_camera).Inverse()};
}

}  // namespace deepslam::propose
