// Scenes held against maps, and what Draco does to their surfaces.
#include "deepslam/presentation/scene_check.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"
#include "deepslam/gltf/draco_encode.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/mesh/object_mesh.h"
#include "deepslam/mesh/surface_distance.h"
#include "deepslam/presentation/expand_map.h"
#include "deepslam/presentation/map_rounding.h"
#include "deepslam/shape/voxel_code.h"
#include "support/voxel_shapes.h"

namespace deepslam::presentation {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const TriangleMesh& ChairMesh() {
  static const TriangleMesh kMesh =
      *mesh::MakeObjectMesh(testing_support::ChairWithThinLegs(), 1.0, {});
  return kMesh;
}

CompactMap MapOfTwo() {
  CompactMap map;
  map.ground_outline_m = {{-1, -1}, {2, -1}, {2, 1}};
  for (int n = 1; n <= 2; ++n) {
    CompactObject entry;
    entry.id = ObjectId{n};
    entry.name = "chair_0" + std::to_string(n);
    entry.class_name = "chair";
    entry.confidence = 0.123456;
    entry.world_from_object = {
        Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * n, Eigen::Vector3d::UnitZ())),
        {1.23456789 * n, 2, 0.5}};
    entry.shape.voxel_code = shape::EncodeVoxels(testing_support::ChairWithThinLegs());
    Eigen::Vector3f low = ChairMesh().vertices.front();
    Eigen::Vector3f high = low;
    for (const Eigen::Vector3f& p : ChairMesh().vertices) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    entry.size_m = (high - low).cast<double>();
    map.objects.push_back(entry);
  }
  return map;
}

gltf::ValidationReport ReportOf(const CompactMap& map) {
  return gltf::ValidateGlb(*gltf::WriteGlb(*ExpandMap(map, nullptr, {}, "0.1.0"), {}));
}

TEST(CompareWithMap, FindsNothingBetweenAMapAndItsScene) {
  const CompactMap map = MapOfTwo();
  EXPECT_THAT(CompareWithMap(ReportOf(map), Rounded(map)), ElementsAre());
}

struct Change {
  const char* what;
  std::function<void(CompactMap&)> apply;
};

TEST(CompareWithMap, NamesTheObjectAndWhatDiffers) {
  const gltf::ValidationReport report = ReportOf(MapOfTwo());
  const Change changes[] = {
      {"name is", [](auto& map) { map.objects[1].name = "chair_07"; }},
      {"class is", [](auto& map) { map.objects[1].class_name = "sofa"; }},
      {"confidence is", [](auto& map) { map.objects[1].confidence += 0.001; }},
      {"source of the shape is",
       [](auto& map) { map.objects[1].source = CandidateSource::kFused; }},
      {"place is", [](auto& map) { map.objects[1].world_from_object.translation_m.y() += 0.001; }},
      {"turned by",
       [](auto& map) {
         map.objects[1].world_from_object.rotation =
             map.objects[1].world_from_object.rotation *
             Eigen::AngleAxisd(1e-5, Eigen::Vector3d::UnitX());
       }},
      {"size is", [](auto& map) { map.objects[1].size_m.z() += 0.05; }},
      {"of the scene is not in the map", [](auto& map) { map.objects.pop_back(); }},
      {"of the map is not in the scene",
       [](auto& map) {
         map.objects.push_back(map.objects[0]);
         map.objects.back().id = ObjectId{9};
       }},
      {"ground", [](auto& map) { map.ground_outline_m.clear(); }},
  };
  for (const Change& change : changes) {
    CompactMap map = MapOfTwo();
    change.apply(map);
    const std::vector<std::string> found = CompareWithMap(report, map);
    EXPECT_THAT(found, ElementsAre(HasSubstr(change.what))) << change.what;
  }
}

// Points spread evenly over the surface.
std::vector<Eigen::Vector3f> Sampled(const TriangleMesh& mesh, double spacing) {
  Random random(1);
  std::vector<Eigen::Vector3f> points;
  double due = 0;
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f& a = mesh.vertices[face[0]];
    const Eigen::Vector3f u = mesh.vertices[face[1]] - a;
    const Eigen::Vector3f v = mesh.vertices[face[2]] - a;
    for (due += 0.5 * u.cross(v).norm() / (spacing * spacing); due >= 1; --due) {
      auto s = static_cast<float>(random.Uniform());
      auto t = static_cast<float>(random.Uniform());
      if (s + t > 1) std::tie(s, t) = std::pair(1 - s, 1 - t);
      points.emplace_back(a + s * u + t * v);
    }
  }
  return points;
}

bool AllNear(const TriangleMesh& from, const TriangleMesh& to, double distance) {
  const std::vector<std::uint8_t> near = mesh::AreNear(Sampled(from, 0.004), to, distance);
  return near.size() > 5000 &&
         std::count(near.begin(), near.end(), 1) == static_cast<std::ptrdiff_t>(near.size());
}

// As a reader of scene.glb gets it, in the mesh's own axes.
TriangleMesh Decoded(const TriangleMesh& mesh, int bits) {
  const gltf::RenderMesh render = gltf::MakeRenderMesh(mesh, 0.7);
  const Result<gltf::DracoPayload> payload = gltf::DracoEncode(render, bits, 8);
  TriangleMesh decoded;
  for (const Eigen::Vector3f& p : payload->decoded.positions)
    decoded.vertices.emplace_back(p.z(), p.x(), p.y());
  decoded.faces = payload->decoded.faces;
  return decoded;
}

// The bound that docs/artifacts.md states for scene.glb, both ways, at points all over the
// surfaces.
TEST(Draco, DecodedSurfacesStayWithinTheStatedDistance) {
  const VoxelGrid sofa = testing_support::FillGrid([](double x, double y, double z) {
    const double bump = 1.2 * std::sin(0.5 * x) * std::cos(0.6 * y) * std::sin(0.5 * z);
    return std::abs(x) < 16 + bump && std::abs(y) < 30 + bump && std::abs(z) < 16 + bump;
  });
  for (const VoxelGrid& grid :
       {testing_support::ChairWithThinLegs(), testing_support::RoundTable(), sofa}) {
    const TriangleMesh source = *mesh::MakeObjectMesh(grid, 1.0, {});
    for (const int bits : {10, 14}) {
      const TriangleMesh decoded = Decoded(source, bits);
      const double bound = std::sqrt(3.0) * gltf::QuantisationError(source.vertices, bits);
      EXPECT_LE(mesh::SurfaceDistance(source, decoded), bound);
      EXPECT_TRUE(AllNear(source, decoded, bound));
      EXPECT_TRUE(AllNear(decoded, source, bound));
      EXPECT_FALSE(AllNear(source, decoded, 0.01 * bound));  // the check can fail
    }
  }
}

}  // namespace
}  // namespace deepslam::presentation
