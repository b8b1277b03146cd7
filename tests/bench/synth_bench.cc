// Rendering of captures: a whole frame, and its parts. The room is that of configs/scenes/
// demo_room.yaml with furniture made of boxes, divided as finely as textured models are, since
// benchmarks need no catalogues. Real time; all cores.
#include <cmath>
#include <numbers>

#include <benchmark/benchmark.h>

#include "deepslam/render/render_view.h"
#include "deepslam/synth/lighting.h"
#include "deepslam/synth/render_capture.h"
#include "deepslam/synth/sensor_faults.h"
#include "support/box_meshes.h"

namespace deepslam::synth {
namespace {

// Faces no longer than this, as MakeFurnitureModel divides textured ones.
constexpr float kEdgeM = 0.012f;

void Divide(const std::array<Eigen::Vector3f, 3>& face, TriangleMesh& mesh) {
  const float longest = std::max(
      {(face[0] - face[1]).norm(), (face[1] - face[2]).norm(), (face[2] - face[0]).norm()});
  if (longest > kEdgeM) {
    const std::array<Eigen::Vector3f, 3> middle = {
        0.5f * (face[0] + face[1]), 0.5f * (face[1] + face[2]), 0.5f * (face[2] + face[0])};
    Divide({face[0], middle[0], middle[2]}, mesh);
    Divide({middle[0], face[1], middle[1]}, mesh);
    Divide({middle[2], middle[1], face[2]}, mesh);
    Divide(middle, mesh);
    return;
  }
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), face.begin(), face.end());
  mesh.faces.push_back({first, first + 1, first + 2});
}

FurnitureModel Model(const TriangleMesh& coarse, float height_m) {
  FurnitureModel model;
  Eigen::Vector3f low = coarse.vertices[0];
  Eigen::Vector3f high = low;
  for (const auto& face : coarse.faces) {
    std::array<Eigen::Vector3f, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      corners[c] = coarse.vertices[face[c]] - Eigen::Vector3f(0, 0, height_m / 2);
      low = low.cwiseMin(corners[c]);
      high = high.cwiseMax(corners[c]);
    }
    Divide(corners, model.mesh);
  }
  model.mesh.colours.assign(model.mesh.vertices.size(), {140, 110, 80});
  model.shiny.assign(model.mesh.faces.size(), 0);
  model.size_m = (high - low).cast<double>();
  return model;
}

SceneDescription DemoRoom() {
  SceneDescription scene;
  scene.seed = 7;
  scene.camera = scene.sensor.camera;
  scene.room_size_m = {6.2, 6.0, 2.6};
  scene.num_posters = 6;
  scene.lights = {{{0.6, 0.4, 2.55}, 0.9, 2.4}, {{-1.5, -1.2, 2.55}, 0.6, 1.3}};
  scene.objects = {{"table", "table", {0, 0}, 0, 1, std::nullopt},
                   {"chair", "chair", {0.95, 0.35}, 195, 2, std::nullopt},
                   {"chair", "chair", {-0.9, -0.15}, 10, 3, std::nullopt},
                   {"chair", "chair", {0.15, -1.05}, 80, 4, std::nullopt}};
  scene.orbit = {{0, -0.1}, 2.5, 1.6, 0.45, -160, 140, 0.012, 0.7};
  return scene;
}

World DemoWorld() {
  ClassTable classes;
  classes.classes.resize(1);
  classes.classes[0].name = "table";
  classes.classes[0].traits.support_plane = true;
  return *BuildWorld(
      DemoRoom(),
      {{"table", Model(testing_support::TableMesh(1.4f, 0.8f, 0.75f, 0.08f), 0.75f)},
       {"chair", Model(testing_support::ChairMesh(0.45f, 0.5f, 0.45f, 0.9f, 0.04f), 0.9f)}},
      classes);
}

void WholeFrame(benchmark::State& state) {
  const CaptureRenderer renderer(DemoWorld());
  int frame = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.Render(frame));
    frame = (frame + 7) % renderer.num_frames();
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(WholeFrame)->Unit(benchmark::kMillisecond)->UseRealTime();

// A scene as the renderer builds it, and a view of its middle frame.
struct Staged {
  World world = DemoWorld();
  render::RayScene scene;
  Pose3 pose = CaptureRenderer(world).Render(60).world_from_camera;
  SensedView sensed;

  Staged() {
    for (const RoomPart& part : world.room) (void)scene.AddMesh(part.mesh, Pose3());
    for (const PlacedObject& object : world.objects)
      (void)scene.AddMesh(object.mesh, object.world_from_object);
    scene.Commit();
    const PinholeCamera& camera = world.description.camera;
    sensed.view = render::RenderView(scene, camera, pose);
    sensed.reflectance = Image<float>(camera.width, camera.height, 0.4f);
  }
};

void FirstHits(benchmark::State& state) {
  const Staged staged;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        render::RenderView(staged.scene, staged.world.description.camera, staged.pose));
  }
}
BENCHMARK(FirstHits)->Unit(benchmark::kMillisecond)->UseRealTime();

void Light(benchmark::State& state) {
  const Staged staged;
  const SceneDescription& scene = staged.world.description;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        SurfaceLight(staged.scene, staged.sensed.view, scene, scene.camera, staged.pose));
  }
}
BENCHMARK(Light)->Unit(benchmark::kMillisecond)->UseRealTime();

void DepthFaults(benchmark::State& state) {
  const Staged staged;
  const SceneDescription& scene = staged.world.description;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        ApplyDepthFaults(staged.sensed, scene.camera, staged.pose, scene, {1, 1}));
  }
}
BENCHMARK(DepthFaults)->Unit(benchmark::kMillisecond)->UseRealTime();

void ColourFaults(benchmark::State& state) {
  const PinholeCamera camera = DemoRoom().camera;
  const Image<Eigen::Vector3f> radiance(
      camera.width, camera.height, Eigen::Vector3f::Constant(0.3f));
  for (auto _ : state) benchmark::DoNotOptimize(DevelopColour(radiance, SensorFaults(), 1, {1, 1}));
}
BENCHMARK(ColourFaults)->Unit(benchmark::kMillisecond)->UseRealTime();

void MotionBlur(benchmark::State& state) {
  const PinholeCamera camera = DemoRoom().camera;
  const Image<Eigen::Vector3f> radiance(
      camera.width, camera.height, Eigen::Vector3f::Constant(0.3f));
  const DepthImage depth(camera.width, camera.height, 2.5f);
  Pose3 moved;
  moved.translation_m.x() = 0.01;
  for (auto _ : state) {
    benchmark::DoNotOptimize(MotionBlurred(radiance, depth, camera, moved, moved.Inverse()));
  }
}
BENCHMARK(MotionBlur)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace deepslam::synth
