#include "deepslam/instances/surface_elements.h"

#include <algorithm>
#include <limits>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"

namespace deepslam::instances {
namespace {

constexpr double kVoxelM = 0.05;

std::vector<Eigen::Vector3f> RandomPoints(int count) {
  Random random(1);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(Eigen::Vector3d(random.Uniform(-0.5, 0.5),
                                        random.Uniform(-0.5, 0.5),
                                        random.Uniform(-0.5, 0.5))
                            .cast<float>());
  return points;
}

std::vector<Eigen::Vector3f> Upward(std::size_t count) {
  return std::vector<Eigen::Vector3f>(count, Eigen::Vector3f::UnitZ());
}

TEST(SurfaceElements, PairsAreThoseOfATrialOfAllPairs) {
  const std::vector<Eigen::Vector3f> vertices = RandomPoints(800);
  const SurfaceElements elements(vertices, Upward(vertices.size()), kVoxelM);
  const double reach_m = 1.9 * kVoxelM;
  std::vector<ElementPair> expected;
  for (int i = 0; i < static_cast<int>(elements.size()); ++i) {
    for (int j = i + 1; j < static_cast<int>(elements.size()); ++j) {
      const Eigen::Vector3f way = elements.points()[static_cast<std::size_t>(i)] -
                                  elements.points()[static_cast<std::size_t>(j)];
      if (way.squaredNorm() <= static_cast<float>(reach_m * reach_m)) expected.emplace_back(i, j);
    }
  }
  EXPECT_GT(expected.size(), 100U);
  EXPECT_EQ(elements.PairsWithin(reach_m), expected);
}

TEST(SurfaceElements, DoNotDependOnTheOrderOfVoxels) {
  std::vector<Eigen::Vector3f> vertices = RandomPoints(300);
  const SurfaceElements elements(vertices, Upward(vertices.size()), 1e-4);
  std::ranges::reverse(vertices);
  const SurfaceElements turned(vertices, Upward(vertices.size()), 1e-4);
  EXPECT_EQ(elements.points(), turned.points());
}

TEST(SurfaceElements, LeaveOutWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<Eigen::Vector3f> vertices = {
      {0, 0, 0}, {nan, 0, 0}, {0, infinity, 0}, {1e30F, 0, 0}, {1, 0, 0}};
  const SurfaceElements elements(vertices, Upward(vertices.size()), kVoxelM);
  EXPECT_EQ(elements.size(), 2U);
  EXPECT_THAT(elements.of_vertex(), testing::ElementsAre(0, -1, -1, -1, 1));
  EXPECT_EQ(SurfaceElements({}, {}, kVoxelM).size(), 0U);
}

}  // namespace
}  // namespace deepslam::instances
