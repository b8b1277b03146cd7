#include "deepslam/synth/render_capture.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "deepslam/core/parallel.h"
#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/truth.h"
#include "small_world.h"
#include "support/box_meshes.h"

namespace deepslam::synth {
namespace {

using testing::AllOf;
using testing::HasSubstr;

CaptureRenderer Renderer(const SceneDescription& scene) {
  return CaptureRenderer(*BuildWorld(scene, {{"box", BoxModel()}}, Classes()));
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
  scene.faults = SensorFaults::None();
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

// Nearest of a mesh's triangles along a ray, each tried (Moeller, Trumbore 1997), in doubles.
double DistanceToMesh(const TriangleMesh& mesh,
                      const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& direction) {
  double nearest = 1e9;
  for (const auto& face : mesh.faces) {
    const auto corner = [&](std::size_t c) { return mesh.vertices[face[c]].cast<double>().eval(); };
    const Eigen::Vector3d ab = corner(1) - corner(0);
    const Eigen::Vector3d ac = corner(2) - corner(0);
    const Eigen::Vector3d h = direction.cross(ac);
    const double determinant = ab.dot(h);
    if (std::abs(determinant) < 1e-14) continue;
    const Eigen::Vector3d s = origin - corner(0);
    const double u = s.dot(h) / determinant;
    const double v = direction.dot(s.cross(ab)) / determinant;
    const double t = ac.dot(s.cross(ab)) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1 && t > 0) nearest = std::min(nearest, t);
  }
  return nearest;
}

TEST(CaptureRenderer, NoiseFreeDepthEqualsARayCastOfAllTrianglesWithinAMillimetre) {
  SceneDescription scene = SmallScene();
  scene.faults = SensorFaults::None();
  scene.num_frames = 2;
  scene.clutter = {2, 2};
  scene.openings = {{2, 1.5, 1.0, 0.5, 1.2, 1}};
  FurnitureModel chair;
  chair.mesh = testing_support::ChairMesh(0.5f, 0.5f, 0.45f, 0.9f, 0.05f);
  for (Eigen::Vector3f& vertex : chair.mesh.vertices) vertex.z() -= 0.45f;
  chair.size_m = {0.5, 0.5, 0.9};
  scene.objects = {{"chair", "chair", {-0.5, 0.2}, 40, 1, std::nullopt},
                   {"table", "box", {0.4, -0.6}, 10, 2, std::nullopt}};
  const CaptureRenderer renderer(
      *BuildWorld(scene, {{"box", BoxModel()}, {"chair", chair}}, Classes()));
  const RenderedFrame rendered = renderer.Render(1);
  int num_off = 0;
  int num_on_objects = 0;
  for (int v = 0; v < scene.camera.height; ++v) {
    for (int u = 0; u < scene.camera.width; ++u) {
      const Eigen::Vector3d origin = rendered.world_from_camera.translation_m;
      const Eigen::Vector3d ray = rendered.world_from_camera.rotation * scene.camera.Ray(u, v);
      double expected = DistanceToMesh(RoomMesh(renderer.world()), origin, ray);
      for (const TriangleMesh& thing : renderer.world().clutter)
        expected = std::min(expected, DistanceToMesh(thing, origin, ray));
      for (const PlacedObject& object : renderer.world().objects) {
        const Pose3 object_from_world = object.world_from_object.Inverse();
        expected = std::min(
            expected,
            DistanceToMesh(
                object.mesh, object_from_world * origin, object_from_world.rotation * ray));
      }
      const double seen = static_cast<double>(rendered.frame.depth_m(u, v));
      num_off += std::abs(seen - (expected < 1e8 ? expected : 0)) > 1e-3 ? 1 : 0;
      num_on_objects += rendered.instances(u, v) != 0 ? 1 : 0;
    }
  }
  // A ray along an edge may take either side of it.
  EXPECT_LE(num_off, 3);
  EXPECT_GT(num_on_objects, 300);
}

TEST(CaptureRenderer, ExposureDriftsAsWideAsAskedAndSlowly) {
  SceneDescription scene = SmallScene();
  EXPECT_EQ(ExposureGain(scene, 3), 1);
  scene.faults.exposure_change_stops = 0.5;
  double squares = 0;
  double last = std::log2(ExposureGain(scene, 0));
  for (int i = 1; i <= 6000; ++i) {
    const double stops = std::log2(ExposureGain(scene, 0.1 * i));
    EXPECT_LT(std::abs(stops - last), 0.15) << "in a tenth of a second";
    squares += stops * stops / 6000;
    last = stops;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.5, 0.05);
  // Brighter pictures where more light is let in.
  const auto mean = [](const ColourImage& image) {
    double sum = 0;
    for (const Rgb8& c : image) sum += c.g;
    return sum / static_cast<double>(image.size());
  };
  scene.faults = SensorFaults::None();
  const RenderedFrame plain = Renderer(scene).Render(4);
  scene.faults.exposure_change_stops = 2;
  const double gain = ExposureGain(scene, plain.frame.time_s);
  const RenderedFrame drifted = Renderer(scene).Render(4);
  EXPECT_EQ(mean(drifted.frame.colour) > mean(plain.frame.colour), gain > 1) << gain;
  EXPECT_EQ(drifted.frame.depth_m, plain.frame.depth_m);
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
  scene.faults = SensorFaults::None();
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
  const World world = *BuildWorld(SmallScene(), {{"box", BoxModel()}}, Classes());
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
    const Result<World> world = BuildWorld(scene, models, Classes());
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
  scene.openings = {{0, 3.5, 0.9, 0, 2.0, 9}};
  EXPECT_THAT(refusal(scene), AllOf(HasSubstr("line 9"), HasSubstr("beyond its wall of 4.00")));
  scene = SmallScene();
  scene.objects.assign(300, scene.objects[0]);
  EXPECT_THAT(refusal(scene), HasSubstr("300 objects"));
}

TEST(BuildWorld, LetsTheCameraUnderATopButNotAgainstItNorIntoABox) {
  FurnitureModel top = BoxModel();
  top.mesh.faces = {{1, 5, 7}, {1, 7, 3}};  // without sides and bottom
  SceneDescription scene = SmallScene();
  scene.orbit.radius_m = 0.2;
  scene.orbit.height_m = 0.5;
  EXPECT_TRUE(BuildWorld(scene, {{"box", top}}, Classes()).ok());
  EXPECT_FALSE(BuildWorld(scene, {{"box", BoxModel()}}, Classes()).ok());
  scene.orbit.height_m = 0.74;
  EXPECT_FALSE(BuildWorld(scene, {{"box", top}}, Classes()).ok());
}

TEST(BuildWorld, WarnsOfAWayThroughAWall) {
  EXPECT_TRUE(BuildWorld(SmallScene(), {{"box", BoxModel()}}, Classes())->warnings.empty());
  SceneDescription scene = SmallScene();
  scene.orbit.radius_m = 3;
  const Result<World> world = BuildWorld(scene, {{"box", BoxModel()}}, Classes());
  ASSERT_TRUE(world.ok());
  ASSERT_EQ(world->warnings.size(), 1u);
  EXPECT_THAT(world->warnings[0], AllOf(HasSubstr("wall"), HasSubstr("frame 0")));
}

TEST(BuildWorld, StretchesModelsToTheSizeAsked) {
  SceneDescription scene = SmallScene();
  scene.objects[0].size_m = Eigen::Vector3d(1.0, 0.5, 0.7);
  const World world = *BuildWorld(scene, {{"box", BoxModel()}}, Classes());
  Eigen::Vector3f high = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& v : world.objects[0].mesh.vertices) high = high.cwiseMax(v);
  EXPECT_LT((high - Eigen::Vector3f(0.5f, 0.25f, 0.35f)).norm(), 1e-6f);
  EXPECT_DOUBLE_EQ(world.objects[0].world_from_object.translation_m.z(), 0.35);
}

TEST(BuildWorld, ClutterStandsOnTablesAndOnTheFloor) {
  SceneDescription scene = SmallScene();
  scene.clutter = {2, 3};
  const World world = *BuildWorld(scene, {{"box", BoxModel()}}, Classes());
  ASSERT_FALSE(world.clutter.empty());
  int num_on_table = 0;
  for (const TriangleMesh& thing : world.clutter) {
    float lowest = 1e9f;
    for (const Eigen::Vector3f& v : thing.vertices) lowest = std::min(lowest, v.z());
    const bool on_table = std::abs(lowest - static_cast<float>(kBoxSizeM)) < 1e-5f;
    EXPECT_TRUE(on_table || std::abs(lowest) < 1e-6f) << lowest;
    num_on_table += on_table ? 1 : 0;
  }
  EXPECT_GT(num_on_table, 0);
  EXPECT_EQ(world.objects.size(), 1u) << "clutter is no object";
  const World bare = *BuildWorld(scene, {{"box", BoxModel()}}, {});
  EXPECT_EQ(world.clutter.size() - bare.clutter.size(), static_cast<std::size_t>(num_on_table))
      << "nothing stands on a class without a support plane";
}

TEST(CaptureRenderer, OpeningsAreHolesInTheirWallAndNowhereElse) {
  SceneDescription scene = SmallScene();
  scene.faults = SensorFaults::None();
  scene.num_posters = 0;
  scene.objects.clear();
  const RenderedFrame whole = Renderer(scene).Render(0);
  // The camera stands east and looks west.
  scene.openings = {{2, 1.5, 1.0, 0.5, 1.2, 1}};
  const RenderedFrame open = Renderer(scene).Render(0);
  int num_open = 0;
  for (int v = 0; v < scene.camera.height; ++v) {
    for (int u = 0; u < scene.camera.width; ++u) {
      const Eigen::Vector3d p =
          whole.world_from_camera *
          scene.camera.Unproject(u, v, static_cast<double>(whole.true_depth_m(u, v)));
      // From inside, the west wall's left end is south.
      const bool expected =
          std::abs(p.x() + 2) < 1e-3 && p.y() > -0.5 && p.y() < 0.5 && p.z() > 0.5 && p.z() < 1.7;
      num_open += expected ? 1 : 0;
      if (expected) {
        EXPECT_TRUE(open.true_depth_m(u, v) == 0 ||
                    open.true_depth_m(u, v) > whole.true_depth_m(u, v));
      } else {
        EXPECT_NEAR(open.true_depth_m(u, v), whole.true_depth_m(u, v), 1e-4);
      }
    }
  }
  EXPECT_GT(num_open, 50);
}

TEST(CaptureRenderer, TableTopsReturnDepthNearTheirEdgesOnly) {
  SceneDescription scene = SmallScene();
  scene.faults = SensorFaults::None();
  const RenderedFrame whole = Renderer(scene).Render(0);
  scene.faults.table_edges_m = 0.1;
  const CaptureRenderer renderer = Renderer(scene);
  const RenderedFrame edges = renderer.Render(0);
  const Pose3 box_from_camera =
      renderer.world().objects[0].world_from_object.Inverse() * whole.world_from_camera;
  int num_blind = 0, num_rim = 0;
  for (int v = 0; v < scene.camera.height; ++v) {
    for (int u = 0; u < scene.camera.width; ++u) {
      const Eigen::Vector3d p =
          box_from_camera *
          scene.camera.Unproject(u, v, static_cast<double>(whole.true_depth_m(u, v)));
      const double to_edge = kBoxSizeM / 2 - p.head<2>().cwiseAbs().maxCoeff();
      const bool top = whole.instances(u, v) == 1 && p.z() > kBoxSizeM / 2 - 1e-3;
      // A cell of the top's map is 5 mm wide.
      if (top && to_edge > 0.107) {
        EXPECT_EQ(edges.frame.depth_m(u, v), 0) << to_edge;
        ++num_blind;
      } else if (!top || to_edge < 0.093) {
        EXPECT_EQ(edges.frame.depth_m(u, v), whole.frame.depth_m(u, v));
        num_rim += top ? 1 : 0;
      }
    }
  }
  EXPECT_GT(num_blind, 50);
  EXPECT_GT(num_rim, 30);
  EXPECT_EQ(edges.true_depth_m, whole.true_depth_m) << "the truth has a whole top";
}

TEST(CaptureRenderer, DroppedFramesLeaveGapsInTime) {
  SceneDescription scene = SmallScene();
  scene.num_frames = 100;
  scene.faults.dropped_share = 0.3;
  const std::vector<int> kept = KeptFrames(scene);
  EXPECT_NEAR(static_cast<double>(kept.size()), 70, 15);
  const CaptureRenderer renderer = Renderer(scene);
  ASSERT_EQ(renderer.num_frames(), static_cast<int>(kept.size()));
  EXPECT_DOUBLE_EQ(renderer.Render(20).frame.time_s, kept[20] / scene.frames_per_s);
  EXPECT_EQ(renderer.Render(20).world_from_camera,
            CameraPath(scene)[static_cast<std::size_t>(kept[20])]);
}

SceneDescription Walking() {
  SceneDescription scene = SmallScene();
  scene.num_frames = 200;
  scene.walk.points_m = {{1.5, -1.5, 1.5}, {1.5, 1.5, 1.5}, {-1.5, 1.5, 1.5}, {-1.5, -1.5, 1.5}};
  scene.walk.look_at_m = {{0, 0, 0.5}};
  scene.walk.shake_m = scene.walk.shake_deg = scene.walk.step_m = 0;
  return scene;
}

TEST(CameraPath, WalksPassTheirPointsAtEvenSpeed) {
  SceneDescription scene = Walking();
  scene.walk.closed = true;
  const std::vector<Pose3> path = CameraPath(scene);
  EXPECT_LT((path.back().translation_m - path.front().translation_m).norm(), 1e-6);
  double low = 1e9, high = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step = (path[i].translation_m - path[i - 1].translation_m).norm();
    low = std::min(low, step);
    high = std::max(high, step);
  }
  EXPECT_LT(high, 1.1 * low);
  for (const Eigen::Vector3d& point : scene.walk.points_m) {
    double nearest = 1e9;
    for (const Pose3& pose : path) nearest = std::min(nearest, (pose.translation_m - point).norm());
    EXPECT_LT(nearest, high);
  }
  scene.walk.laps = 2;
  const std::vector<Pose3> twice = CameraPath(scene);
  EXPECT_LT((twice[50].translation_m - twice[149].translation_m).norm(), 2.2 * high);
}

TEST(CameraPath, OutAndBackComesTheSameWay) {
  SceneDescription scene = Walking();
  scene.walk.and_back = true;
  scene.walk.look_at_m.clear();
  const std::vector<Pose3> path = CameraPath(scene);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_LT((path[i].translation_m - path[199 - i].translation_m).norm(), 1e-9);
    EXPECT_LT(path[i].rotation.angularDistance(path[199 - i].rotation), 1e-6);
  }
  EXPECT_LT((path[99].translation_m - scene.walk.points_m.back()).norm(), 0.05);
}

}  // namespace
}  // namespace deepslam::synth
