#include "deepslam/artifact/coarse_surface_file.h"

#include <string>

#include <gmock/gmock.h>

namespace deepslam::artifact {
namespace {

using testing::HasSubstr;

CoarseSurface Sample() {
  CoarseSurface surface;
  surface.voxel_m = 0.04;
  surface.mesh.vertices = {{0, 0, 0}, {1, 0, 0.1F}, {0, 1, 0}};
  surface.mesh.faces = {{0, 1, 2}};
  surface.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  surface.num_frames = {1, 2, 300};
  SpaceBlock low;
  low.index = {-3, 4, 5};
  low.passed.fill(255);
  low.blind[17] = 3;
  SpaceBlock high;
  high.index = {2, -1, 0};
  for (std::size_t n = 0; n < SpaceBlock::kVoxels; ++n)
    high.passed[n] = static_cast<std::uint8_t>(n % 7);
  surface.space = ObservedSpace(0.04, {low, high});
  surface.viewpoints = {{0, 0, 1.5F}, {1, 2, 3}};
  surface.level_from_tracking = {
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX())), {1, 2, 3}};
  surface.has_ground = true;
  return surface;
}

Result<CoarseSurface> Decode(const std::string& mesh, const std::string& space) {
  return DecodeCoarseSurface(mesh, "surface.ply", space, "space.bin");
}

TEST(CoarseSurfaceFile, ReadsBackWhatWasWritten) {
  const CoarseSurface sample = Sample();
  const std::string mesh = *EncodeSurfaceMesh(sample, "surface.ply");
  const std::string space = EncodeSpace(sample);
  const Result<CoarseSurface> read = Decode(mesh, space);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->mesh.vertices, sample.mesh.vertices);
  EXPECT_EQ(read->normals, sample.normals);
  EXPECT_EQ(read->num_frames, sample.num_frames);
  EXPECT_EQ(read->viewpoints, sample.viewpoints);
  EXPECT_EQ(read->level_from_tracking, sample.level_from_tracking);
  EXPECT_TRUE(read->has_ground);
  ASSERT_EQ(read->space.blocks().size(), 2U);
  EXPECT_EQ(read->space.blocks()[1].passed, sample.space.blocks()[1].passed);
  EXPECT_EQ(*EncodeSurfaceMesh(*read, "surface.ply"), mesh);
  EXPECT_EQ(EncodeSpace(*read), space);
}

TEST(CoarseSurfaceFile, EmptyIsAValueToo) {
  CoarseSurface nothing;
  nothing.voxel_m = 0.04;
  const Result<CoarseSurface> read =
      Decode(*EncodeSurfaceMesh(nothing, "surface.ply"), EncodeSpace(nothing));
  // A mesh without vertices has no normals, nor are there any missing.
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(read->space.empty());
}

TEST(CoarseSurfaceFile, RefusesWhatIsCutOff) {
  const std::string mesh = *EncodeSurfaceMesh(Sample(), "surface.ply");
  const std::string space = EncodeSpace(Sample());
  for (std::size_t length = 0; length < space.size(); length += length < 200 ? 1 : 61) {
    const Result<CoarseSurface> read = Decode(mesh, space.substr(0, length));
    ASSERT_FALSE(read.ok()) << length;
    EXPECT_THAT(read.error().message, HasSubstr("space.bin"));
  }
  EXPECT_FALSE(Decode(mesh, space + "x").ok());
  EXPECT_FALSE(Decode(mesh.substr(0, mesh.size() - 1), space).ok());
}

TEST(CoarseSurfaceFile, SurvivesFlippedBytes) {
  const std::string mesh = *EncodeSurfaceMesh(Sample(), "surface.ply");
  const std::string space = EncodeSpace(Sample());
  for (std::size_t at = 0; at < 400; ++at) {
    for (const char flip : {'\x01', '\x80', '\xff'}) {
      std::string damaged = space;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      const Result<CoarseSurface> read = Decode(mesh, damaged);
      if (!read.ok()) continue;
      EXPECT_EQ(read->mesh.vertices.size(), 3U);
      EXPECT_TRUE(read->level_from_tracking.translation_m.allFinite());
    }
  }
}

TEST(CoarseSurfaceFile, RefusesOtherVersionsAndMeshesWithoutNormals) {
  const CoarseSurface sample = Sample();
  const std::string mesh = *EncodeSurfaceMesh(sample, "surface.ply");
  std::string future = EncodeSpace(sample);
  future[future.find('1')] = '2';
  EXPECT_THAT(Decode(mesh, future).error().message, HasSubstr("version"));
  EXPECT_THAT(Decode(mesh, "glTF").error().message, HasSubstr("space.bin: is no deepslam space"));
  CoarseSurface bare = sample;
  bare.normals.clear();
  EXPECT_THAT(Decode(*EncodeSurfaceMesh(bare, "surface.ply"), EncodeSpace(sample)).error().message,
              HasSubstr("surface.ply"));
}

}  // namespace
}  // namespace deepslam::artifact
