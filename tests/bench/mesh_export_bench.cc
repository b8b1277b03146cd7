// Stages mesh and export on a hall of 50 objects: surface, decimation, colours, compressed scene,
// embedded shapes. The aim is less than 10 s together on two cores.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/mesh/colour_mesh.h"
#include "deepslam/mesh/object_mesh.h"
#include "deepslam/shape/voxel_code.h"
#include "support/voxel_shapes.h"

namespace deepslam {
namespace {

using testing_support::FillGrid;

constexpr std::size_t kNumObjects = 50;
constexpr int kNumViews = 12;

// A chair with a leaning back and splayed legs; `v` in [0, 1] makes each another one.
VoxelGrid Chair(double v) {
  return FillGrid([=](double x, double y, double z) {
    const double lean = x + 14 + 0.15 * (1 + v) * z;
    const bool seat = std::hypot(x, 0.8 * y) < 17 + 4 * v && z > -2 && z < 2;
    const bool back = z > 0 && z < 28 && std::abs(y) < 14 && std::abs(lean) < 2;
    const double leg_x = std::abs(x) - 10 + 0.12 * z;
    const double leg_y = std::abs(y) - 10 + 0.12 * z;
    const bool leg = z < -1 && z > -31 && std::hypot(leg_x, leg_y) < 1.5 + v;
    return seat || back || leg;
  });
}

// A cabinet or sofa as a fusion of noisy depth has it: full, with bumps.
VoxelGrid Bumpy(double v) {
  return FillGrid([=](double x, double y, double z) {
    const double bump =
        1.5 * std::sin(0.45 * x + 9 * v) * std::cos(0.5 * y) * std::sin(0.4 * z + v);
    return std::abs(x) < 14 + 6 * v + bump && std::abs(y) < 30 + bump && std::abs(z) < 18 + bump &&
           !(x > 0 && z > 2 && std::abs(y) < 24);
  });
}

VoxelGrid Table(double v) {
  return FillGrid([=](double x, double y, double z) {
    const double r = std::hypot(x, 0.7 * y);
    return (r < 20 + 5 * v && std::abs(z - 15) < 2) || (r < 3 && z < 15 && z > -15) ||
           (r < 12 && std::abs(z + 15) < 2);
  });
}

const std::vector<VoxelGrid>& Grids() {
  static const std::vector<VoxelGrid> kGrids = [] {
    std::vector<VoxelGrid> grids;
    for (std::size_t n = 0; n < kNumObjects; ++n) {
      const double v = static_cast<double>(n) / kNumObjects;
      grids.push_back(n % 5 < 3 ? Chair(v) : n % 5 == 3 ? Table(v) : Bumpy(v));
    }
    return grids;
  }();
  return kGrids;
}

// Views from all round, of a grey wall at the object's distance.
std::vector<ObjectView> Views() {
  std::vector<ObjectView> views;
  for (int n = 0; n < kNumViews; ++n) {
    ObjectView view;
    view.camera = {240, 240, 400, 400, 120, 120};
    view.depth_crop_m = DepthImage(240, 240, 2.0F);
    view.colour_crop = ColourImage(240, 240, Rgb8{120, 130, static_cast<std::uint8_t>(10 * n)});
    view.mask_crop = Mask(240, 240, 1);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.5 * n, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Matrix3d axes;  // camera looks along -x of the turned frame
    axes << 0, 0, -1, 1, 0, 0, 0, -1, 0;
    view.world_from_camera = {Eigen::Quaterniond(turn * axes), turn * Eigen::Vector3d(2, 0, 0)};
    views.push_back(view);
  }
  return views;
}

std::vector<TriangleMesh> MakeMeshes() {
  const std::vector<ObjectView> views = Views();
  std::vector<TriangleMesh> meshes(kNumObjects);
  ParallelFor(kNumObjects, [&](std::size_t i) {
    const Result<TriangleMesh> mesh = mesh::MakeObjectMesh(Grids()[i], 1.0, {});
    if (mesh.ok()) meshes[i] = mesh::ColourMesh(*mesh, views, {});
  });
  return meshes;
}

const std::vector<TriangleMesh>& Meshes() {
  static const std::vector<TriangleMesh> kMeshes = MakeMeshes();
  return kMeshes;
}

gltf::GltfScene Scene() {
  gltf::GltfScene scene;
  for (std::size_t n = 0; n < kNumObjects; ++n) {
    gltf::GltfObject object;
    object.name = "object_" + std::to_string(n);
    object.class_name = "object";
    object.instance = static_cast<int>(n);
    object.mesh = Meshes()[n];
    object.world_from_object.translation_m.x() = static_cast<double>(n);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

void MeshFiftyObjects(benchmark::State& state) {
  Grids();
  std::size_t num_faces = 0;
  for (auto _ : state) {
    num_faces = 0;
    for (const TriangleMesh& mesh : MakeMeshes()) num_faces += mesh.faces.size();
  }
  state.counters["faces"] = static_cast<double>(num_faces);
}
BENCHMARK(MeshFiftyObjects)->Unit(benchmark::kMillisecond)->UseRealTime();

void ExportFiftyObjects(benchmark::State& state) {
  const gltf::GltfScene scene = Scene();
  std::size_t bytes = 0;
  for (auto _ : state) {
    bytes = gltf::WriteGlb(scene, {})->size();
    benchmark::DoNotOptimize(gltf::WriteGlb(scene, {.draco = false}));
  }
  state.counters["glb_bytes"] = static_cast<double>(bytes);
}
BENCHMARK(ExportFiftyObjects)->Unit(benchmark::kMillisecond)->UseRealTime();

// All fifty as fused winners.
void EmbedFiftyShapes(benchmark::State& state) {
  Grids();
  std::size_t bytes = 0;
  for (auto _ : state) {
    bytes = 0;
    for (const VoxelGrid& grid : Grids()) bytes += shape::EncodeVoxels(grid).size();
  }
  state.counters["bytes_per_shape"] = static_cast<double>(bytes) / kNumObjects;
}
BENCHMARK(EmbedFiftyShapes)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace deepslam
