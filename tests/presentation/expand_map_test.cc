// The scene made again from map.json alone, against the scene it was written beside.
#include "deepslam/presentation/expand_map.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "deepslam/artifact/map_json.h"
#include "deepslam/core/sha256.h"
#include "deepslam/gltf/validate.h"
#include "deepslam/mesh/ground_polygon.h"
#include "deepslam/presentation/habitat_pair.h"
#include "deepslam/presentation/labelled_surface.h"
#include "deepslam/presentation/map_rounding.h"
#include "deepslam/shape/binvox.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxel_code.h"
#include "support/voxel_shapes.h"

namespace deepslam::presentation {
namespace {

using testing::HasSubstr;

ModelLibrary OneTable() {
  ModelLibrary library;
  LibraryModel model;
  model.id = "maker/table";
  model.class_name = "table";
  model.shape = testing_support::RoundTable();
  model.checksum = Sha256Hex(shape::WriteBinvox(model.shape));
  library.models = {model};
  return library;
}

const Eigen::Vector3d kStretch(1.1, 0.95, 0.01 * 23 * 5);

VoxelGrid StretchedTable() { return shape::StretchGrid(OneTable().models[0].shape, kStretch); }

TriangleMesh TableMesh(double scale_m) {
  static const TriangleMesh kUnit = *mesh::MakeObjectMesh(StretchedTable(), 1.0, {});
  TriangleMesh mesh = kUnit;
  for (Eigen::Vector3f& p : mesh.vertices) p *= static_cast<float>(scale_m);
  return mesh;
}

Pose3 SomePose(double turn) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d(0.01, 0.02, 1).normalized())),
          {1.23456789, -2.3456789, 0.3456789}};
}

// Two tables of the library and a fused box.
CompactMap MakeMap() {
  CompactMap map;
  map.tool_version = "0.1.0";
  map.capture_hash = "ab12";
  map.ground_world = Plane{};
  map.ground_outline_m = {{-1, -1}, {2.00004, -1}, {2, 1}, {0, 0.5}};
  map.class_colours = {{"table", {10, 20, 30}}};
  const CompactShape cad = {{},
                            "maker/table",
                            OneTable().models[0].checksum,
                            kStretch,
                            Sha256Hex(shape::WriteBinvox(StretchedTable())),
                            ""};
  for (int n = 0; n < 2; ++n) {
    CompactObject entry;
    entry.id = ObjectId{3 + n};
    entry.name = "table_0" + std::to_string(3 + n);
    entry.class_name = "table";
    entry.confidence = 0.71;
    entry.world_from_object = SomePose(0.7 + n);
    entry.scale_m = 0.123456789 + n;
    entry.credit = "Maker";
    entry.shape = cad;
    map.objects.push_back(entry);
  }
  CompactObject fused = map.objects[0];
  fused.id = ObjectId{7};
  fused.name = "table_07";
  fused.source = CandidateSource::kFused;
  fused.shape = {};
  fused.shape.voxel_code = shape::EncodeVoxels(StretchedTable());
  map.objects.push_back(fused);
  return map;
}

CompactMap SomeMap() {
  static const CompactMap kMap = MakeMap();
  return kMap;
}

// As another program would get it: written, read.
Result<gltf::GltfScene> Expanded(const CompactMap& map, const ModelLibrary& library) {
  const Result<CompactMap> read =
      artifact::DecodeMap(*artifact::EncodeMap(Rounded(map), "map.json"), "map.json");
  if (!read.ok()) return read.error();
  return ExpandMap(*read, &library, {}, "0.2.0");
}

TEST(ExpandMap, GivesObjectsBackWithinTheStatedQuantisation) {
  const CompactMap map = SomeMap();
  const Result<gltf::GltfScene> scene = Expanded(map, OneTable());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->objects.size(), 3U);
  for (std::size_t n = 0; n < 3; ++n) {  // the fused one as the others
    const CompactObject& entry = map.objects[n];
    const gltf::GltfObject& object = scene->objects[n];
    EXPECT_EQ(object.name, entry.name);
    EXPECT_EQ(object.instance, entry.id.value);
    EXPECT_EQ(object.class_colour, (Rgb8{10, 20, 30}));
    const TriangleMesh truth = TableMesh(entry.scale_m);
    ASSERT_EQ(object.mesh.faces, truth.faces);
    // Half a step of place, and of rotation and scale times the object's radius, each by the number
    // of rounded components.
    const double radius_m = entry.scale_m;
    const double bound_m =
        0.5 * (2 * kMapPlaceStepM + 8 * kMapRotationStep * radius_m + 2 * kMapScaleStepM) +
        1e-6 * radius_m;  // floats
    for (std::size_t v = 0; v < truth.vertices.size(); ++v) {
      const Eigen::Vector3d a = entry.world_from_object * truth.vertices[v].cast<double>();
      const Eigen::Vector3d b = object.world_from_object * object.mesh.vertices[v].cast<double>();
      ASSERT_LT((a - b).norm(), bound_m);
    }
  }
}

TEST(ExpandMap, GivesTheRoundedGroundBackExactly) {
  // A floor whose corners lie nearer to each other than the map's steps, and off them.
  const std::vector<Eigen::Vector2d> outline = {
      {-1.00412, -1.00378}, {2.00004, -1.00771}, {2.0001, -1.0076}, {1.98, 1.234567}, {0, 0.5}};
  const TriangleMesh ground = RoundedGround(*mesh::TriangulateOutline(outline));
  CompactMap map = SomeMap();
  map.ground_outline_m = mesh::OutlineOf(ground);
  const Result<gltf::GltfScene> scene = Expanded(map, OneTable());
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->ground->vertices, ground.vertices);
  EXPECT_EQ(ground.vertices.size(), 4U);  // two corners fell together
  for (const Eigen::Vector3f& p : ground.vertices) {
    const auto off = [&](const Eigen::Vector2d& q) {
      return (p.head<2>().cast<double>() - q).cwiseAbs().maxCoeff();
    };
    EXPECT_TRUE(std::any_of(outline.begin(), outline.end(), [&](const Eigen::Vector2d& q) {
      return off(q) <= 0.5 * kMapOutlineStepM + 1e-6;
    }));
  }
}

TEST(ExpandMap, SceneIsValidAndLikeObjectsShareAMesh) {
  const Result<gltf::GltfScene> scene = Expanded(SomeMap(), OneTable());
  ASSERT_TRUE(scene.ok());
  const gltf::ValidationReport report = gltf::ValidateGlb(*gltf::WriteGlb(*scene, {}));
  EXPECT_TRUE(report.ok()) << report.errors.front();
  EXPECT_TRUE(report.has_ground);
  EXPECT_EQ(report.num_objects, 3);
  EXPECT_EQ(report.num_meshes, 2 + 1);  // both tables, the fused one, the ground
}

TEST(ExpandMap, SaysWhatIsMissing) {
  const auto fault = [](const CompactMap& map, const ModelLibrary* library) {
    const Result<gltf::GltfScene> scene = ExpandMap(map, library, {}, "0.2.0");
    EXPECT_FALSE(scene.ok());
    if (scene.ok()) return std::string();
    EXPECT_EQ(scene.error().code, ErrorCode::kInvalidInput);
    return scene.error().message;
  };
  const ModelLibrary library = OneTable();
  EXPECT_THAT(fault(SomeMap(), nullptr), HasSubstr("--library"));
  const ModelLibrary empty;
  EXPECT_THAT(fault(SomeMap(), &empty), HasSubstr("no model maker/table"));
  ModelLibrary changed = OneTable();
  changed.models[0].checksum = "0123";
  EXPECT_THAT(fault(SomeMap(), &changed), HasSubstr("table_03"));
  CompactMap stretched = SomeMap();
  stretched.objects[1].shape.stretch.x() = 1.2;  // not what the map was made with
  EXPECT_THAT(fault(stretched, &library), HasSubstr("table_04"));
  CompactMap latents = SomeMap();
  latents.objects[0].shape = {};
  latents.objects[0].shape.latents = {0.1F, 0.2F};
  EXPECT_THAT(fault(latents, &library), HasSubstr("decoder"));
  CompactMap damaged = SomeMap();
  damaged.objects[2].shape.voxel_code.resize(40);
  EXPECT_THAT(fault(damaged, &library), HasSubstr("table_07"));
  CompactMap crossing = SomeMap();
  crossing.ground_outline_m = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  EXPECT_THAT(fault(crossing, &library), HasSubstr("ground outline"));
}

TEST(ExpandMap, NamesTheVersionsOfBothPrograms) {
  const Result<gltf::GltfScene> scene = Expanded(SomeMap(), OneTable());
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->generator, "deepslam 0.2.0");
  EXPECT_EQ(scene->provenance.at("deepslam_version"), "0.1.0");
  EXPECT_EQ(scene->provenance.at("capture_sha256"), "ab12");
}

TEST(JoinSurfaces, LabelsEveryVertexWithItsObject) {
  const Result<gltf::GltfScene> scene = Expanded(SomeMap(), OneTable());
  ASSERT_TRUE(scene.ok());
  const LabelledSurface joined = JoinSurfaces(*scene);
  ASSERT_EQ(joined.labels.size(), joined.mesh.vertices.size());
  ASSERT_EQ(joined.mesh.colours.size(), joined.mesh.vertices.size());
  std::size_t at = 0;
  for (const gltf::GltfObject& object : scene->objects) {
    for (const Eigen::Vector3f& p : object.mesh.vertices) {
      ASSERT_EQ(joined.labels[at], object.instance);
      ASSERT_EQ(joined.mesh.colours[at], object.class_colour);
      const Eigen::Vector3d p_world = object.world_from_object * p.cast<double>();
      ASSERT_LT((joined.mesh.vertices[at].cast<double>() - p_world).norm(), 1e-6);
      ++at;
    }
  }
  EXPECT_EQ(std::count(joined.labels.begin(), joined.labels.end(), kGroundLabel),
            static_cast<std::ptrdiff_t>(scene->ground->vertices.size()));
  for (const auto& face : joined.mesh.faces) {
    EXPECT_EQ(joined.labels[face[0]], joined.labels[face[1]]);
    EXPECT_EQ(joined.labels[face[0]], joined.labels[face[2]]);
  }
}

TEST(EncodeHabitatPair, CarriesEveryObject) {
  const Result<gltf::GltfScene> scene = Expanded(SomeMap(), OneTable());
  ASSERT_TRUE(scene.ok());
  const Result<HabitatPair> pair = EncodeHabitatPair(*scene);
  ASSERT_TRUE(pair.ok());
  EXPECT_TRUE(pair->txt.starts_with("HM3D Semantic Annotations\n1,800000,\"table\",0\n"));
  EXPECT_THAT(pair->txt, HasSubstr("\"floor\",0\n"));
  EXPECT_TRUE(gltf::ValidateGlb(pair->glb).ok());
}

}  // namespace
}  // namespace deepslam::presentation
