#include "deepslam/synth/render_capture.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "deepslam/core/parallel.h"
#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/truth.h"
#include "small_world.h"

namespace deepslam::synth {
namespace {

using testing::AllOf;
using testing::HasSubstr;

CaptureRenderer Renderer(const SceneDescription& scene) {
  return CaptureRenderer(*BuildWorld(scene, {{"box", BoxModel()}}));
}

// Nearest of the room's six planes and the box, by intersecting the ray with slabs: no triangles,
// no Embree.
double DistanceInRoom(const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& direction,
                      const Eigen::Vector3d& room_size,
                      const Pose3& world_from_box) {
  const auto slabs = [](const Eigen::Vector3d& o,
                        const Eigen::Vector3d& d,
                        const Eigen::Vector3d& low,
                        const Eigen::Vector3d& high) {
    double enter = -1e9, leave = 1e9;
    for (int k = 0; k < 3; ++k) {
      const double a = (low[k] - o[k]) / d[k];
      const double b = (high[k] - o[k]) / d[k];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return std::pair{enter, leave};
  };
  const Eigen::Vector3d low(-room_size.x() / 2, -room_size.y() / 2, 0);
  const double wall = slabs(origin, direction, low, low + room_size).second;
  const Pose3 box_from_world = world_from_box.Inverse();
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(kBoxSizeM / 2);
  const auto [enter, leave] =
      slabs(box_from_world * origin, box_from_world.rotation * direction, -half, half);
  return enter > 0 && enter < leave ? std::min(wall, enter) : wall;
}

TEST(CaptureRenderer, NoiseFreeDepthEqualsAnAnalyticRayCastWithinAMillimetre) {
  SceneDescription scene = SmallScene();
  scene.faults = {false, false, false};
  scene.num_posters = 0;
  const CaptureRenderer renderer = Renderer(scene);
  const Pose3 world_from_box = renderer.world().objects[0].world_from_object;
  for (int i = 0; i < renderer.num_frames(); i += 2) {
    const RenderedFrame rendered = renderer.Render(i);
    int num_off = 0;
    for (int v = 0; v < scene.camera.height; ++v) {
      for (int u = 0; u < scene.camera.width; ++u) {
        const Eigen::Vector3d ray = scene.camera.Ray(u, v);
        const double expected = DistanceInRoom(rendered.world_from_camera.translation_m,
                                               rendered.world_from_camera.rotation * ray,
                                               scene.room_size_m,
                                               world_from_box);
        if (std::abs(rendered.frame.depth_m(u, v) - expected) > 1e-3) ++num_off;
      }
    }
    EXPECT_EQ(num_off, 0) << "frame " << i;
    EXPECT_EQ(rendered.frame.depth_m, rendered.true_depth_m);
  }
}

TEST(CaptureRenderer, InstancesAreTheObjectsPixels) {
  const CaptureRenderer renderer = Renderer(SmallScene());
  const RenderedFrame rendered = renderer.Render(0);
  const Pose3 camera_from_box =
      rendered.world_from_camera.Inverse() * renderer.world().objects[0].world_from_object;
  const std::optional<Eigen::Vector2d> middle =
      SmallScene().camera.Project(camera_from_box * Eigen::Vector3d::Zero());
  ASSERT_TRUE(middle.has_value());
  EXPECT_EQ(rendered.instances(static_cast<int>(middle->x()), static_cast<int>(middle->y())), 1);
  EXPECT_EQ(rendered.instances(0, 0), 0);
}

TEST(CaptureRenderer, SameSeedSameBytesInAnyOrderOnAnyThreads) {
  const CaptureRenderer first = Renderer(SmallScene());
  const RenderedFrame once = first.Render(2);
  const CaptureRenderer second = Renderer(SmallScene());
  (void)second.Render(5);
  const ThreadLimit one(1);
  const RenderedFrame again = second.Render(2);
  EXPECT_EQ(again.frame.colour, once.frame.colour);
  EXPECT_EQ(again.frame.depth_m, once.frame.depth_m);
  EXPECT_EQ(again.instances, once.instances);
  EXPECT_EQ(again.world_from_camera, once.world_from_camera);

  SceneDescription other = SmallScene();
  other.seed = 4;
  EXPECT_NE(Renderer(other).Render(2).frame.depth_m, once.frame.depth_m);
}

TEST(CaptureRenderer, BoxShadesTheFloorBesideIt) {
  SceneDescription scene = SmallScene();
  scene.faults = {false, false, false};
  scene.floor = "tiles";
  const RenderedFrame shaded = Renderer(scene).Render(0);
  scene.objects.clear();
  const RenderedFrame empty = Renderer(scene).Render(0);
  int num_darker = 0, num_floor = 0;
  for (int v = 0; v < scene.camera.height; ++v) {
    for (int u = 0; u < scene.camera.width; ++u) {
      if (shaded.instances(u, v) != 0 || shaded.true_depth_m(u, v) != empty.true_depth_m(u, v))
        continue;
      ++num_floor;
      num_darker += shaded.frame.colour(u, v).g + 10 < empty.frame.colour(u, v).g ? 1 : 0;
      // Windows at the box's outline lack some light samples, so they are off a little either way.
      EXPECT_LE(shaded.frame.colour(u, v).g, empty.frame.colour(u, v).g + 16);
    }
  }
  EXPECT_GT(num_darker, 20);
  EXPECT_LT(num_darker, num_floor);
}

TEST(CameraPath, LooksAtTheCentreUprightAndMovesSmoothly) {
  SceneDescription scene = SmallScene();
  scene.num_frames = 60;
  scene.orbit.shake_deg = 0;
  scene.orbit.shake_m = 0;
  const std::vector<Pose3> path = CameraPath(scene);
  const Eigen::Vector3d target(0, 0, scene.orbit.target_height_m);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector3d p_camera = path[i].Inverse() * target;
    EXPECT_NEAR(p_camera.head<2>().norm(), 0, 1e-9);
    EXPECT_GT(p_camera.z(), 1);
    EXPECT_NEAR((path[i].rotation * Eigen::Vector3d::UnitX()).z(), 0, 1e-9) << "horizon is level";
    EXPECT_LT((path[i].rotation * Eigen::Vector3d::UnitY()).z(), 0) << "y is down";
    if (i == 0) continue;
    EXPECT_LT((path[i].translation_m - path[i - 1].translation_m).norm(), 0.06);
  }
  scene.orbit.shake_m = 0.01;
  const std::vector<Pose3> shaken = CameraPath(scene);
  EXPECT_GT((shaken[10].translation_m - path[10].translation_m).norm(), 1e-4);
  EXPECT_LT((shaken[10].translation_m - path[10].translation_m).norm(), 0.06);
}

TEST(BuildWorld, PutsObjectsOnTheFloorAndTellsTheTruth) {
  const World world = *BuildWorld(SmallScene(), {{"box", BoxModel()}});
  ASSERT_EQ(world.objects.size(), 1u);
  double lowest = 1e9;
  for (const Eigen::Vector3f& v : world.objects[0].mesh.vertices) {
    lowest = std::min(lowest, (world.objects[0].world_from_object * v.cast<double>()).z());
  }
  EXPECT_NEAR(lowest, 0, 1e-6);
  EXPECT_THAT(TruthJson(world),
              AllOf(HasSubstr("\"class\": \"table\""),
                    HasSubstr("\"size_m\": [0.800000, 0.800000, 0.800000]"),
                    HasSubstr("\"translation_m\": [0.000000, 0.000000, 0.400000]")));
}

TEST(BuildWorld, RefusesWhatCannotBe) {
  const std::map<std::string, FurnitureModel> models = {{"box", BoxModel()}};
  const auto refusal = [&](const SceneDescription& scene) {
    const Result<World> world = BuildWorld(scene, models);
    return world.ok() ? std::string() : world.error().message;
  };
  SceneDescription scene = SmallScene();
  scene.objects[0].model = "sofa";
  EXPECT_THAT(refusal(scene), AllOf(HasSubstr("line 7"), HasSubstr("'sofa'")));
  scene = SmallScene();
  scene.objects[0].position_m.x() = 1.8;
  EXPECT_THAT(refusal(scene), AllOf(HasSubstr("line 7"), HasSubstr("wall")));
  scene = SmallScene();
  scene.orbit.radius_m = 0.3;
  scene.orbit.height_m = 0.5;
  EXPECT_THAT(refusal(scene), AllOf(HasSubstr("camera enters table"), HasSubstr("frame 0")));
  scene = SmallScene();
  scene.orbit.radius_m = 3;
  EXPECT_THAT(refusal(scene), HasSubstr("camera leaves the room"));
}

}  // namespace
}  // namespace deepslam::synth
