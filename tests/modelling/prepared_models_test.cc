#include "deepslam/modelling/prepared_models.h"

#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "support/voxel_shapes.h"

namespace deepslam::modelling {
namespace {

using testing_support::Box;
using testing_support::Sphere;

constexpr std::size_t kPlenty = std::size_t{1} << 30;

TEST(PreparedModels, AModelIsPreparedOnce) {
  PreparedModels models(kPlenty);
  const PreparedModel first = models.Prepare("chair", Sphere(20));
  EXPECT_EQ(first, models.Prepare("chair", Sphere(20)));
  EXPECT_NE(first, models.Prepare("ball", Sphere(20)));
}

TEST(PreparedModels, AnotherGridOfTheSameNameIsAnotherModel) {
  PreparedModels models(kPlenty);
  const PreparedModel ball = models.Prepare("chair", Sphere(20));
  const PreparedModel box = models.Prepare("chair", Box(10, 20, 30));
  EXPECT_EQ(box->grid().occupied, Box(10, 20, 30).occupied);
  EXPECT_EQ(ball, models.Prepare("chair", Sphere(20))) << "the first one stays";
}

TEST(PreparedModels, KeepsNoneWhereAllAreTooMany) {
  const std::size_t num_voxels = VoxelGrid().occupied.size();
  PreparedModels models(8 * num_voxels);  // a grid, its field and its surface; not twice
  const PreparedModel alone = models.Prepare("a", Sphere(20));
  EXPECT_EQ(alone, models.Prepare("a", Sphere(20)));
  const PreparedModel second = models.Prepare("b", Sphere(20));
  EXPECT_EQ(alone.use_count(), 1) << "let go";
  for (const char* const name : {"a", "b"}) {
    const PreparedModel again = models.Prepare(name, Sphere(20));
    EXPECT_EQ(again.use_count(), 1);
    EXPECT_EQ(again->grid().occupied, second->grid().occupied);
  }
}

TEST(PreparedModels, ManyThreadsGetTheSameShape) {
  PreparedModels models(kPlenty);
  std::vector<int> wrong(60, 0);
  ParallelFor(wrong.size(), [&](std::size_t i) {
    const double radius = 10.0 + static_cast<double>(i % 3);
    const PreparedModel model = models.Prepare(std::to_string(i % 3), Sphere(radius));
    wrong[i] = model->grid().occupied == Sphere(radius).occupied ? 0 : 1;
  });
  EXPECT_EQ(wrong, std::vector<int>(60, 0));
}

TEST(PreparedModels, InNoMemoryEachIsForTheCallerAlone) {
  PreparedModels models(0);
  EXPECT_NE(models.Prepare("a", Sphere(20)), models.Prepare("a", Sphere(20)));
}

}  // namespace
}  // namespace deepslam::modelling
