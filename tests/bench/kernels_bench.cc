// The kernels that stages behind tracking and detection spend their time in, one by one, on
// rendered views of a chair: what is measured of a view, models, and their pictures.
//   deepslam_kernels_bench --benchmark_repetitions=5
#include <random>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "deepslam/registration/measured_view.h"
#include "deepslam/registration/similarity_icp.h"
#include "deepslam/registration/visible_surface.h"
#include "deepslam/segment/segment_objects.h"
#include "deepslam/shape/render_voxels.h"
#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/view_points.h"
#include "support/box_world.h"
#include "support/furniture_world.h"

namespace deepslam {
namespace {

using testing_support::ChairGrid;
using testing_support::FurnitureWorld;
using testing_support::ViewsAround;

constexpr int kNumViews = 8;

// Points and normals of a view, at most so many; per view.
void ExtractViewPoints(benchmark::State& state) {
  const FurnitureWorld world(ChairGrid(), 0.9);
  const std::vector<ObjectView> views = ViewsAround(world, kNumViews);
  for (auto _ : state) {
    for (const ObjectView& view : views) {
      benchmark::DoNotOptimize(
          shape::ExtractViewPoints(view, static_cast<int>(state.range(0))).points_camera.data());
    }
  }
  state.SetItemsProcessed(state.iterations() * kNumViews);
}
BENCHMARK(ExtractViewPoints)->ArgName("points")->Arg(400)->Arg(2000)->Unit(benchmark::kMillisecond);

// Signed distances and surface points of a 64^3 model.
void PrepareShapeModel(benchmark::State& state) {
  const VoxelGrid grid = ChairGrid();
  for (auto _ : state) benchmark::DoNotOptimize(shape::ShapeModel(grid).bottom());
}
BENCHMARK(PrepareShapeModel)->Unit(benchmark::kMillisecond);

// A placed model's depth, as large as the views; per view.
void RenderDepth(benchmark::State& state) {
  const FurnitureWorld world(ChairGrid(), 0.9);
  const std::vector<ObjectView> views = ViewsAround(world, kNumViews);
  const shape::ShapeModel model(ChairGrid());
  for (auto _ : state) {
    for (const ObjectView& view : views) {
      const Similarity3 camera_from_object =
          view.world_from_camera.Inverse() * world.world_from_object();
      benchmark::DoNotOptimize(
          shape::RenderDepth(model, camera_from_object, view.camera.Reduced(2)).row(0));
    }
  }
  state.SetItemsProcessed(state.iterations() * kNumViews);
}
BENCHMARK(RenderDepth)->Unit(benchmark::kMillisecond);

// A model aligned with all views together, from beside its place; per iteration and view.
void AlignShape(benchmark::State& state) {
  const FurnitureWorld world(ChairGrid(), 0.9);
  const std::vector<registration::MeasuredView> views =
      registration::PrepareViews(ViewsAround(world, kNumViews));
  std::vector<const registration::MeasuredView*> pointers;
  for (const registration::MeasuredView& view : views) pointers.push_back(&view);
  const shape::ShapeModel model(ChairGrid());
  Similarity3 start = world.world_from_object();
  start.translation_m.x() += 0.05;
  registration::VisibleSurface visible(model);
  const registration::SimilarityIcpOptions options;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        registration::AlignShape(model, visible, pointers, start, options).scale);
  }
  state.SetItemsProcessed(state.iterations() * kNumViews * options.num_iterations);
}
BENCHMARK(AlignShape)->Unit(benchmark::kMillisecond);

// A table with two chairs before it in a corner, 640 x 480 with depth noise, cut out of its frame.
void SegmentFrame(benchmark::State& state) {
  using testing_support::Cuboid;
  const std::vector<Cuboid> world = {{-1, {-4, -4, -0.1}, {4, 4, 0}},
                                     {-1, {-4, 3, 0}, {4, 3.1, 3}},
                                     {-1, {2.5, -4, 0}, {2.6, 4, 3}},
                                     {0, {-0.8, 1.2, 0.7}, {0.8, 2.0, 0.75}},
                                     {0, {-0.75, 1.25, 0}, {-0.7, 1.3, 0.7}},
                                     {0, {0.7, 1.25, 0}, {0.75, 1.3, 0.7}},
                                     {1, {-0.6, 0.6, 0.4}, {-0.2, 1.0, 0.45}},
                                     {1, {-0.6, 0.58, 0.4}, {-0.2, 0.62, 0.9}},
                                     {2, {0.2, 0.6, 0.4}, {0.6, 1.0, 0.45}},
                                     {2, {0.2, 0.58, 0.4}, {0.6, 0.62, 0.9}}};
  const PinholeCamera camera = {640, 480, 520, 520, 319.5, 239.5};
  const Pose3 world_from_camera = testing_support::LookAt({-0.8, -1.2, 1.5}, {0, 1.2, 0.5});
  testing_support::BoxView view = RenderBoxes(world, camera, world_from_camera);
  std::mt19937 random(1);
  std::normal_distribution<float> noise;
  for (float& depth_m : view.frame.depth_m) {
    if (depth_m > 0) depth_m += 0.0015F * depth_m * depth_m * noise(random);
  }
  std::vector<Detection> detections;
  for (const auto& [object, name] : {std::pair{0, "table"}, {1, "chair"}, {2, "chair"}}) {
    if (auto found = DetectTruth(view, object, name)) detections.push_back(*found);
  }
  const Plane ground = testing_support::FloorIn(world_from_camera);
  ClassTable classes;
  classes.classes.resize(1);
  classes.classes[0].name = "table";
  classes.classes[0].traits.support_plane = true;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        segment::SegmentFrame({view.frame, camera, ground, detections}, classes, {}).data());
  }
}
BENCHMARK(SegmentFrame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace deepslam
