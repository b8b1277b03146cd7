#include "deepslam/convex/mass_properties.h"

#include <gtest/gtest.h>

#include "convex/convex_samples.h"

namespace deepslam::convex {
namespace {

TEST(MassPropertiesOf, ABoxHasItsMoments) {
  const MassProperties box =
      MassPropertiesOf(testing_support::BoxMesh({1, 2, 3}, {1.2F, 2.6F, 4.0F}));
  EXPECT_NEAR(box.volume_m3, 0.12, 1e-6);
  EXPECT_LT((box.centre - Eigen::Vector3d(1.1, 2.3, 3.5)).norm(), 1e-5);
  // m (b^2 + c^2) / 12, ascending.
  const Eigen::Vector3d moments =
      0.12 / 12 *
      Eigen::Vector3d(0.2 * 0.2 + 0.6 * 0.6, 0.2 * 0.2 + 1.0 * 1.0, 0.6 * 0.6 + 1.0 * 1.0);
  EXPECT_LT((box.inertia - moments).norm(), 1e-6) << box.inertia.transpose();
  // The least is about the longest side.
  EXPECT_NEAR(std::abs((box.mesh_from_axes * Eigen::Vector3d::UnitX()).z()), 1, 1e-4);
}

TEST(MassPropertiesOf, TurningTurnsTheAxesAlone) {
  TriangleMesh mesh = testing_support::TableMesh();
  const MassProperties before = MassPropertiesOf(mesh);
  EXPECT_NEAR(before.volume_m3, testing_support::kTableM3, 1e-6);
  const Eigen::Quaternionf turn(Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, 2, -1).normalized()));
  for (Eigen::Vector3f& p : mesh.vertices) p = turn * p + Eigen::Vector3f(3, -2, 1);
  const MassProperties after = MassPropertiesOf(mesh);
  EXPECT_NEAR(after.volume_m3, before.volume_m3, 1e-6);
  EXPECT_LT((after.inertia - before.inertia).norm(), 1e-5);
}

TEST(MassPropertiesOf, NothingHasNone) {
  EXPECT_EQ(MassPropertiesOf({}).volume_m3, 0);
  TriangleMesh inside_out = testing_support::BoxMesh({0, 0, 0}, {1, 1, 1});
  for (auto& face : inside_out.faces) std::swap(face[1], face[2]);
  EXPECT_EQ(MassPropertiesOf(inside_out).volume_m3, 0);
}

}  // namespace
}  // namespace deepslam::convex
