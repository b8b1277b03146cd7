#include "deepslam/fuse/tsdf.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/pipelines/integration/ScalableTSDFVolume.h>

#include "deepslam/artifact/ply.h"
#include "deepslam/core/parallel.h"
#include "deepslam/fuse/canonical_mesh.h"

namespace deepslam::fuse {
namespace {

const PinholeCamera kCamera{160, 120, 150, 150, 79.5, 59.5};
const Eigen::Vector3d kCentre(0, 0, 1.5);
constexpr double kRadius = 0.4;

FuseOptions CoarseOptions() {
  FuseOptions options;
  options.voxel_m = 0.03;
  options.truncation_m = 0.09;
  options.min_component_faces = 0;
  return options;
}

// Depth of a sphere in front of a wall at z = 2.5 of the world, seen from `world_from_camera`.
Frame SphereAndWall(const Pose3& world_from_camera) {
  Frame frame;
  frame.depth_m = DepthImage(kCamera.width, kCamera.height, 0.0F);
  frame.colour = ColourImage(kCamera.width, kCamera.height, {200, 100, 50});
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const Eigen::Vector3d ray = kCamera.Ray(u, v);
      const Eigen::Vector3d direction = world_from_camera.rotation * ray;
      const Eigen::Vector3d from_centre = world_from_camera.translation_m - kCentre;
      const double a = direction.squaredNorm();
      const double b = from_centre.dot(direction);
      const double c = from_centre.squaredNorm() - kRadius * kRadius;
      double depth = (2.5 - world_from_camera.translation_m.z()) / direction.z();
      if (b * b - a * c > 0) depth = std::min(depth, (-b - std::sqrt(b * b - a * c)) / a);
      frame.depth_m(u, v) = static_cast<float>(depth);
    }
  }
  return frame;
}

std::vector<Pose3> Cameras() {
  std::vector<Pose3> poses;
  for (const double x : {-0.3, 0.0, 0.3}) {
    for (const double y : {-0.2, 0.2}) poses.push_back({Eigen::Quaterniond::Identity(), {x, y, 0}});
  }
  return poses;
}

TriangleMesh Fused(const FuseOptions& options) {
  TsdfFusion fusion(options);
  for (const Pose3& pose : Cameras()) {
    EXPECT_TRUE(fusion.Integrate(SphereAndWall(pose), kCamera, pose, nullptr).ok());
  }
  return fusion.ExtractMesh();
}

TEST(TsdfFusion, FindsSphereAndWallWithinAVoxel) {
  const TriangleMesh mesh = Fused(CoarseOptions());
  ASSERT_GT(mesh.faces.size(), 1000U);
  int num_sphere = 0;
  int num_far = 0;
  for (const Eigen::Vector3f& p : mesh.vertices) {
    const Eigen::Vector3d q = p.cast<double>();
    const double to_sphere = std::abs((q - kCentre).norm() - kRadius);
    const double to_wall = std::abs(q.z() - 2.5);
    num_sphere += to_sphere < 0.03 ? 1 : 0;
    num_far += std::min(to_sphere, to_wall) > 0.03 ? 1 : 0;
  }
  EXPECT_GT(num_sphere, 300);
  // Only the sphere's rim, where rays of one pixel pass it by, may be off.
  EXPECT_LT(num_far, static_cast<int>(mesh.vertices.size()) / 20);
  ASSERT_EQ(mesh.colours.size(), mesh.vertices.size());
  EXPECT_NEAR(mesh.colours[mesh.colours.size() / 2].r, 200, 2);
}

TEST(TsdfFusion, GivesEqualMeshesEveryTime) {
  const TriangleMesh a = Fused(CoarseOptions());
  const TsdfFusion other(CoarseOptions());  // moves what is allocated next
  const TriangleMesh b = Fused(CoarseOptions());
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.colours, b.colours);
}

TEST(TsdfFusion, DoesNotDependOnTheNumberOfThreads) {
  const auto with_threads = [](int num_threads) {
    const ThreadLimit limit(num_threads);
    return Fused(CoarseOptions());
  };
  const TriangleMesh one = with_threads(1);
  const TriangleMesh four = with_threads(4);
  EXPECT_EQ(one.vertices, four.vertices);
  EXPECT_EQ(one.faces, four.faces);
  EXPECT_EQ(one.colours, four.colours);
}

// The same frames by the library whose arithmetic is ours.
TEST(TsdfFusion, HasTheSurfaceOfOpen3d) {
  const FuseOptions options = CoarseOptions();
  open3d::pipelines::integration::ScalableTSDFVolume volume(
      options.voxel_m,
      options.truncation_m,
      open3d::pipelines::integration::TSDFVolumeColorType::RGB8);
  for (const Pose3& pose : Cameras()) {
    const Frame frame = SphereAndWall(pose);
    open3d::geometry::RGBDImage image;
    image.depth_.Prepare(kCamera.width, kCamera.height, 1, 4);
    image.color_.Prepare(kCamera.width, kCamera.height, 3, 1);
    std::memcpy(image.depth_.data_.data(), frame.depth_m.data(), 4 * frame.depth_m.size());
    std::memcpy(image.color_.data_.data(), frame.colour.data(), 3 * frame.colour.size());
    volume.Integrate(
        image,
        {kCamera.width, kCamera.height, kCamera.fx, kCamera.fy, kCamera.cx, kCamera.cy},
        pose.Inverse().Matrix());
  }
  const auto theirs = volume.ExtractTriangleMesh();
  const TriangleMesh ours = Fused(options);
  EXPECT_NEAR(static_cast<double>(ours.vertices.size()),
              static_cast<double>(theirs->vertices_.size()),
              0.002 * static_cast<double>(theirs->vertices_.size()));
  EXPECT_NEAR(static_cast<double>(ours.faces.size()),
              static_cast<double>(theirs->triangles_.size()),
              0.002 * static_cast<double>(theirs->triangles_.size()));
  constexpr double kSame_m = 1e-5;
  std::vector<Eigen::Vector3d> sorted = theirs->vertices_;
  const auto by_x = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return a.x() < b.x();
  };
  std::sort(sorted.begin(), sorted.end(), by_x);
  std::size_t num_other = 0;
  for (const Eigen::Vector3f& p : ours.vertices) {
    const Eigen::Vector3d q = p.cast<double>();
    const Eigen::Vector3d slack(kSame_m, 0, 0);
    const auto begin = std::lower_bound(sorted.begin(), sorted.end(), q - slack, by_x);
    const auto end = std::upper_bound(sorted.begin(), sorted.end(), q + slack, by_x);
    const bool there = std::any_of(begin, end, [&](const Eigen::Vector3d& other) {
      return (other - q).cwiseAbs().maxCoeff() < kSame_m;
    });
    num_other += there ? 0U : 1U;
  }
  // Where a voxel falls on the border of two pixels, rounding decides which it takes.
  EXPECT_LE(num_other, ours.vertices.size() / 100);
}

TEST(TsdfFusion, ColoursAreTheMeanOfWhatWasSeen) {
  TsdfFusion fusion(CoarseOptions());
  Frame frame = SphereAndWall({});
  for (const std::uint8_t grey : {std::uint8_t{100}, std::uint8_t{101}, std::uint8_t{105}}) {
    frame.colour = ColourImage(kCamera.width, kCamera.height, {grey, 0, 255});
    ASSERT_TRUE(fusion.Integrate(frame, kCamera, {}, nullptr).ok());
  }
  const TriangleMesh mesh = std::move(fusion).TakeMesh();
  ASSERT_FALSE(mesh.colours.empty());
  for (const Rgb8& colour : mesh.colours) ASSERT_EQ(colour, (Rgb8{102, 0, 255}));
}

TEST(TsdfFusion, TakenMeshIsTheExtractedOne) {
  TsdfFusion fusion(CoarseOptions());
  ASSERT_TRUE(fusion.Integrate(SphereAndWall({}), kCamera, {}, nullptr).ok());
  const TriangleMesh extracted = fusion.ExtractMesh();
  const TriangleMesh taken = std::move(fusion).TakeMesh();
  EXPECT_EQ(extracted.vertices, taken.vertices);
  EXPECT_EQ(extracted.faces, taken.faces);
}

TEST(TsdfFusion, LeavesOutWhatTheMaskCovers) {
  TsdfFusion fusion(CoarseOptions());
  const Pose3 pose;
  const Frame frame = SphereAndWall(pose);
  Mask sphere(kCamera.width, kCamera.height, 0);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) sphere(u, v) = frame.depth_m(u, v) < 2.4F ? 1 : 0;
  }
  ASSERT_TRUE(fusion.Integrate(frame, kCamera, pose, &sphere).ok());
  const Result<TriangleMesh> mesh = fusion.ExtractMesh();
  ASSERT_FALSE(mesh->empty());
  for (const Eigen::Vector3f& p : mesh->vertices) EXPECT_NEAR(p.z(), 2.5, 0.05);
}

TEST(TsdfFusion, KeepsToTheNumberOfFaces) {
  FuseOptions options = CoarseOptions();
  options.max_faces = 500;
  const TriangleMesh mesh = Fused(options);
  EXPECT_LE(mesh.faces.size(), 500U);
  EXPECT_GT(mesh.faces.size(), 100U);
  EXPECT_EQ(mesh.vertices, Fused(options).vertices);
}

TEST(TsdfFusion, RefusesBadFramesAndGoesOn) {
  TsdfFusion fusion(CoarseOptions());
  const Frame good = SphereAndWall({});
  Frame small = good;
  small.depth_m = DepthImage(3, 3, 1.0F);
  EXPECT_EQ(fusion.Integrate(small, kCamera, {}, nullptr).error().code, ErrorCode::kInvalidInput);
  Pose3 nan;
  nan.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(fusion.Integrate(good, kCamera, nan, nullptr).ok());
  EXPECT_FALSE(fusion.Integrate(good, kCamera, {{1, 0, 0, 0}, {1e12, 0, 0}}, nullptr).ok());
  const Mask mask(2, 2, 0);
  EXPECT_FALSE(fusion.Integrate(good, kCamera, {}, &mask).ok());
  PinholeCamera flat = kCamera;
  flat.fx = 0;
  EXPECT_FALSE(fusion.Integrate(good, flat, {}, nullptr).ok());
  Frame blind = good;
  for (float& depth : blind.depth_m) depth = 0;
  EXPECT_TRUE(fusion.Integrate(blind, kCamera, {}, nullptr).ok());
  EXPECT_TRUE(fusion.ExtractMesh().empty());
  EXPECT_EQ(fusion.CountSurfacePoints(), 0);
  EXPECT_TRUE(fusion.Integrate(good, kCamera, {}, nullptr).ok());
  EXPECT_GT(fusion.CountSurfacePoints(), 0);
}

TEST(TsdfFusion, StopsBeforeTheRoomOutgrowsItsBound) {
  FuseOptions options = CoarseOptions();
  options.max_voxel_blocks = 3;
  TsdfFusion fusion(options);
  const Status status = fusion.Integrate(SphereAndWall({}), kCamera, {}, nullptr);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("max_voxel_blocks"), std::string::npos);
  EXPECT_TRUE(fusion.ExtractMesh().empty());
}

// The report's size of a fused cloud against one that is written: surface points at 1 cm, binary
// PLY with colour.
TEST(ExpectedSurfacePoints, GivesTheSizeOfAWrittenCloud) {
  FuseOptions options = CoarseOptions();
  options.voxel_m = 0.02;  // as the room is fused by default
  options.truncation_m = 0.06;
  const TriangleMesh room = Fused(options);
  options.voxel_m = 0.01;
  options.truncation_m = 0.03;
  options.max_faces = 10'000'000;
  TriangleMesh cloud = Fused(options);
  cloud.faces.clear();
  const Result<std::string> ply = artifact::EncodePly({std::move(cloud), {}, {}}, "cloud.ply");
  ASSERT_TRUE(ply.ok());
  const auto bytes = static_cast<double>(ply->size());
  EXPECT_NEAR(15.0 * static_cast<double>(ExpectedSurfacePoints(room, 0.01)), bytes, 0.07 * bytes);
  // Not by its scale alone: half the voxel, four times the points.
  EXPECT_NEAR(static_cast<double>(ExpectedSurfacePoints(room, 0.005)),
              4.0 * static_cast<double>(ExpectedSurfacePoints(room, 0.01)),
              2.0);
}

TEST(CanonicalMesh, DoesNotDependOnTheOrderOfVerticesAndFaces) {
  TriangleMesh a;
  a.vertices = {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {9, 9, 9}};
  a.faces = {{1, 0, 2}, {0, 3, 2}};
  TriangleMesh b;
  b.vertices = {{0, 1, 0}, {1, 1, 0}, {1, 0, 0}, {0, 0, 0}};
  b.faces = {{1, 0, 2}, {2, 0, 3}};
  EXPECT_EQ(CanonicalMesh(a).vertices, CanonicalMesh(b).vertices);
  EXPECT_EQ(CanonicalMesh(a).faces, CanonicalMesh(b).faces);
  EXPECT_EQ(CanonicalMesh(a).vertices.size(), 4U);
}

TEST(WithoutSmallComponents, KeepsTheLargeOnes) {
  TriangleMesh mesh;
  for (int n = 0; n < 5; ++n) mesh.vertices.emplace_back(static_cast<float>(n), 0.0F, 0.0F);
  for (int n = 0; n < 3; ++n) mesh.vertices.emplace_back(static_cast<float>(n), 5.0F, 0.0F);
  mesh.faces = {{0, 1, 2}, {2, 3, 4}, {5, 6, 7}};
  EXPECT_EQ(WithoutSmallComponents(mesh, 2).faces.size(), 2U);
  EXPECT_EQ(WithoutSmallComponents(mesh, 1).faces.size(), 3U);
}

}  // namespace
}  // namespace deepslam::fuse
