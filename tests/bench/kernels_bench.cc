// The kernels that stages behind tracking and detection spend their time in, one by one, on
// rendered views of a chair: what is measured of a view, models, and their pictures.
//   deepslam_kernels_bench --benchmark_repetitions=5
#include <benchmark/benchmark.h>

#include "deepslam/registration/measured_view.h"
#include "deepslam/registration/similarity_icp.h"
#include "deepslam/registration/visible_surface.h"
#include "deepslam/shape/render_voxels.h"
#include "deepslam/shape/shape_model.h"
#include "deepslam/shape/view_points.h"
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

}  // namespace
}  // namespace deepslam
