#include "deepslam/instances/nearest_elements.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/core/random.h"

namespace deepslam::instances {
namespace {

constexpr double kVoxelM = 0.05;
// From the middle of a cell half as wide to its corner.
const double kCellRadiusM = std::sqrt(3.0) * kVoxelM / 4;

std::vector<Eigen::Vector3f> RandomPoints(int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(Eigen::Vector3d(random.Uniform(-0.5, 0.5),
                                        random.Uniform(-0.5, 0.5),
                                        random.Uniform(-0.5, 0.5))
                            .cast<float>());
  }
  return points;
}

SurfaceElements ElementsOf(const std::vector<Eigen::Vector3f>& points) {
  return {points, std::vector<Eigen::Vector3f>(points.size(), Eigen::Vector3f::UnitZ()), kVoxelM};
}

TEST(NearestElements, TheOneFoundIsTheNearestButForTheSizeOfACell) {
  const SurfaceElements elements = ElementsOf(RandomPoints(400, 1));
  const NearestElements nearest(elements);
  NearestElements::Cursor cursor(nearest);
  int num_found = 0;
  for (const Eigen::Vector3f& point : RandomPoints(3000, 2)) {
    double least_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3f& p : elements.points())
      least_m = std::min(least_m, static_cast<double>((p - point).norm()));
    const int found = cursor.At(point);
    if (found < 0) {
      EXPECT_GT(least_m, 1.5 * kVoxelM - kCellRadiusM);
      continue;
    }
    const double found_m = (elements.points()[static_cast<std::size_t>(found)] - point).norm();
    EXPECT_LE(found_m, least_m + 2 * kCellRadiusM);
    EXPECT_LE(found_m, 1.5 * kVoxelM + kCellRadiusM);
    ++num_found;
  }
  EXPECT_GT(num_found, 1000);
}

// A cursor remembers where it was; what it says does not depend on that.
TEST(NearestElements, ACursorSaysTheSameWhereverItComesFrom) {
  const SurfaceElements elements = ElementsOf(RandomPoints(400, 3));
  const NearestElements nearest(elements);
  NearestElements::Cursor cursor(nearest);
  for (const Eigen::Vector3f& point : RandomPoints(1000, 4))
    EXPECT_EQ(cursor.At(point), NearestElements::Cursor(nearest).At(point));
}

TEST(NearestElements, ThereIsNoneFarAwayNorOfWhatIsNoPoint) {
  const SurfaceElements elements = ElementsOf({{0, 0, 0}, {-1, 2, -3}});
  const NearestElements nearest(elements);
  NearestElements::Cursor cursor(nearest);
  EXPECT_GE(cursor.At({-1, 2, -3}), 0);
  EXPECT_EQ(cursor.At({0, 0, 5}), -1);
  EXPECT_EQ(cursor.At({1e30F, 0, 0}), -1);
  EXPECT_EQ(cursor.At({std::numeric_limits<float>::quiet_NaN(), 0, 0}), -1);
  EXPECT_EQ(cursor.At({0, -std::numeric_limits<float>::infinity(), 0}), -1);
  const SurfaceElements nothing = ElementsOf({});
  const NearestElements of_nothing(nothing);
  EXPECT_EQ(NearestElements::Cursor(of_nothing).At({0, 0, 0}), -1);
}

}  // namespace
}  // namespace deepslam::instances
