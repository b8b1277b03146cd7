#include "deepslam/render/ray_scene.h"

#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/render/render_view.h"

namespace deepslam::render {
namespace {

using testing::HasSubstr;

TriangleMesh Square(float half) {
  TriangleMesh mesh;
  mesh.vertices = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TriangleMesh Soup(int num_faces, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh;
  for (int f = 0; f < num_faces; ++f) {
    const Eigen::Vector3d middle(
        random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1));
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d corner =
          middle + 0.3 * Eigen::Vector3d(
                             random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1));
      mesh.vertices.push_back(corner.cast<float>());
    }
    const auto first = static_cast<std::uint32_t>(3 * f);
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

// Distance along a ray to a triangle (Moeller, Trumbore), infinity for a miss.
double ToTriangle(const Eigen::Vector3d& origin,
                  const Eigen::Vector3d& direction,
                  const Eigen::Vector3d& a,
                  const Eigen::Vector3d& b,
                  const Eigen::Vector3d& c) {
  const double miss = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d sides;
  sides << b - a, c - a, -direction;
  if (std::abs(sides.determinant()) < 1e-12) return miss;
  const Eigen::Vector3d weights = sides.inverse() * (origin - a);
  return weights.x() >= 0 && weights.y() >= 0 && weights.x() + weights.y() <= 1 && weights.z() > 0
             ? weights.z()
             : miss;
}

TEST(RayScene, AgreesWithEveryTriangleTriedInTurn) {
  const TriangleMesh soup = Soup(60, 1);
  const Pose3 world_from_soup{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
      {4, -1, 2}};
  RayScene scene;
  ASSERT_TRUE(scene.AddMesh(soup, world_from_soup).ok());
  scene.Commit();
  Random random(2);
  int num_hits = 0;
  std::vector<Eigen::Vector3f> from;
  std::vector<Eigen::Vector3f> to;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d origin =
        world_from_soup.translation_m +
        3 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    const Eigen::Vector3d goal =
        world_from_soup.translation_m +
        0.7 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    const Eigen::Vector3d direction = (goal - origin).normalized();
    double expected = std::numeric_limits<double>::infinity();
    for (const auto& face : soup.faces) {
      expected = std::min(expected,
                          ToTriangle(origin,
                                     direction,
                                     world_from_soup * soup.vertices[face[0]].cast<double>(),
                                     world_from_soup * soup.vertices[face[1]].cast<double>(),
                                     world_from_soup * soup.vertices[face[2]].cast<double>()));
    }
    const std::optional<RayHit> hit = scene.Cast(origin.cast<float>(), direction.cast<float>());
    ASSERT_EQ(hit.has_value(), std::isfinite(expected)) << "ray " << i;
    if (!hit) continue;
    ++num_hits;
    EXPECT_NEAR(hit->distance_m, expected, 1e-4);
    EXPECT_LE(hit->normal_world.cast<double>().dot(direction), 1e-6);
    EXPECT_TRUE(scene.Occluded(origin.cast<float>(),
                               (origin + (expected + 0.01) * direction).cast<float>()));
    EXPECT_FALSE(scene.Occluded(origin.cast<float>(),
                                (origin + (expected - 0.01) * direction).cast<float>()));
    for (const double end : {0.01, -0.01}) {
      from.emplace_back(origin.cast<float>());
      to.emplace_back((origin + (expected + end) * direction).cast<float>());
    }
  }
  EXPECT_GT(num_hits, 300);
  std::vector<std::uint8_t> occluded(from.size());
  scene.AreOccluded(from, to, occluded);
  for (std::size_t n = 0; n < occluded.size(); ++n) ASSERT_EQ(occluded[n], n % 2 == 0 ? 1 : 0);
}

TEST(RayScene, TellsInstancesFacesAndPlacesOnThemApart) {
  RayScene scene;
  ASSERT_EQ(*scene.AddMesh(Square(1), Pose3{Eigen::Quaterniond::Identity(), {0, 0, 1}}), 0);
  ASSERT_EQ(*scene.AddMesh(Square(1), Pose3{Eigen::Quaterniond::Identity(), {5, 0, 2}}), 1);
  scene.Commit();
  EXPECT_EQ(scene.num_instances(), 2);
  const auto hit = scene.Cast({5.5f, -0.5f, 0}, {0, 0, 1});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->instance, 1);
  EXPECT_EQ(hit->face, 0u);
  EXPECT_NEAR(hit->distance_m, 2, 1e-6);
  // Corners (-1,-1), (1,-1), (1,1) of the first face: (0.5,-0.5) = 0.25 a + 0.5 b + 0.25 c.
  EXPECT_NEAR(hit->weight_b, 0.5, 1e-5);
  EXPECT_NEAR(hit->weight_c, 0.25, 1e-5);
  EXPECT_FALSE(scene.Cast({2.5f, 0, 0}, {0, 0, 1}).has_value());
}

TEST(RayScene, RefusesBrokenMeshes) {
  RayScene scene;
  EXPECT_THAT(scene.AddMesh(TriangleMesh(), Pose3()).error().message, HasSubstr("no faces"));
  TriangleMesh mesh = Square(1);
  mesh.faces[1][2] = 9;
  EXPECT_THAT(scene.AddMesh(mesh, Pose3()).error().message,
              HasSubstr("face 1 names vertex 9 of 4"));
  mesh = Square(1);
  mesh.vertices[2].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(scene.AddMesh(mesh, Pose3()).error().message, HasSubstr("vertex 2 is not finite"));
}

TEST(RenderView, DepthIsAlongTheAxisAndEqualForAnyThreads) {
  RayScene scene;
  ASSERT_TRUE(scene.AddMesh(Square(50), Pose3()).ok());
  ASSERT_TRUE(scene.AddMesh(Soup(40, 3), Pose3{Eigen::Quaterniond::Identity(), {0, 0, 1}}).ok());
  scene.Commit();
  const PinholeCamera camera{64, 48, 60, 60, 31.5, 23.5};
  // 3 m above the plane z = 0, looking straight down.
  const Pose3 above{
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX())), {0, 0, 3}};
  const RenderedView view = RenderView(scene, camera, above);
  int num_plane = 0;
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      if (view.hits(u, v).instance != 0) continue;
      EXPECT_NEAR(view.depth_m(u, v), 3, 1e-5);
      ++num_plane;
    }
  }
  EXPECT_GT(num_plane, 100);
  const ThreadLimit one(1);
  EXPECT_EQ(RenderView(scene, camera, above).depth_m, view.depth_m);
}

// Embree can be told to bound the scheduler that it shares with everything else.
TEST(RayScene, LeavesParallelLoopsTheirThreads) {
  const ThreadLimit three(3);
  const auto allowed = [] {
    return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  };
  ASSERT_EQ(allowed(), 3U);
  RayScene scene;
  ASSERT_TRUE(scene.AddMesh(Square(1), Pose3()).ok());
  scene.Commit();
  EXPECT_EQ(allowed(), 3U);
}

}  // namespace
}  // namespace deepslam::render
