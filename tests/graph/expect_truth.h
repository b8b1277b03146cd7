// That an optimised map is the one its world was made of.
#pragma once

#include <gmock/gmock.h>

#include "graph/synthetic_graph.h"
#include "support/pose_matchers.h"

namespace deepslam::graph::testing_support {

inline void ExpectTruth(const OptimizedMap& map, const World& world) {
  using ::deepslam::testing_support::PoseNear;
  ASSERT_EQ(map.frames.size(), world.world_from_camera.size());
  for (std::size_t k = 0; k < map.frames.size(); ++k)
    EXPECT_THAT(map.frames[k].world_from_camera, PoseNear(world.world_from_camera[k], 1e-6, 1e-4));
  ASSERT_EQ(map.map.objects.size(), world.world_from_object.size());
  for (std::size_t k = 0; k < map.map.objects.size(); ++k) {
    EXPECT_THAT(map.map.objects[k].world_from_object,
                PoseNear(world.world_from_object[k], 1e-6, 1e-4));
  }
}

}  // namespace deepslam::graph::testing_support
