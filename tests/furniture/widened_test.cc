#include "deepslam/furniture/widened.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/furniture/design.h"
#include "deepslam/furniture/joined.h"
#include "deepslam/scene/mesh_box.h"
#include "deepslam/shape/crumbs.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::furniture {
namespace {

TriangleMesh MakeMesh(Kind kind, std::uint64_t number) {
  return MakeDesign(kind, Random(7, "widened test", number)).mesh;
}

VoxelGrid ShapeOf(const TriangleMesh& mesh) {
  const Result<VoxelGrid> shape = shape::Voxelize(mesh);
  EXPECT_TRUE(shape);
  return shape ? *shape : VoxelGrid{};
}

int CountWithArms(Kind kind) {
  int count = 0;
  for (std::uint64_t n = 0; n < 30; ++n) {
    const VoxelGrid shape = ShapeOf(MakeMesh(kind, n));
    const std::optional<float> seat = SeatHeight(shape);
    count += seat && HasArms(shape, *seat) ? 1 : 0;
  }
  return count;
}

TEST(HasArms, OfArmchairsNotOfStools) {
  EXPECT_GE(CountWithArms(Kind::kArmchair), 24);
  EXPECT_LE(CountWithArms(Kind::kStool), 1);
  EXPECT_FALSE(HasArms(VoxelGrid{}, 0.5F));
}

// A seat from -1 to 1 with arms a tenth of the width thick: at one side alone, at neither.
TEST(HasArms, NeedsBoth) {
  for (const int arms : {0, 1, 2}) {
    VoxelGrid shape;
    for (int i = 4; i < 60; ++i) {
      for (int j = 4; j < 60; ++j) {
        const bool arm = (arms > 0 && j < 10) || (arms > 1 && j >= 54);
        for (int k = 4; k < (i < 10 ? 60 : arm ? 42 : 28); ++k)
          shape.occupied[VoxelGrid::Index(i, j, k)] = 1;
      }
    }
    EXPECT_EQ(HasArms(shape, 24.0F / 56), arms == 2) << arms;
  }
}

TEST(StandsBelowBothSides, OnLegsOrABodyNotOnAStar) {
  const auto count = [](Kind kind) {
    int found = 0;
    for (std::uint64_t n = 0; n < 30; ++n) {
      const VoxelGrid shape = ShapeOf(MakeMesh(kind, n));
      const std::optional<float> seat = SeatHeight(shape);
      found += seat && StandsBelowBothSides(shape, *seat) ? 1 : 0;
    }
    return found;
  };
  EXPECT_GE(count(Kind::kArmchair), 24);
  EXPECT_LE(count(Kind::kOfficeChair), 3);
  EXPECT_FALSE(StandsBelowBothSides(VoxelGrid{}, 0.5F));
}

TEST(Widened, KeepsTheArmsWhereTheSeatIsWider) {
  for (std::uint64_t n = 0; n < 100; ++n) {
    Random random(3, "widened", n);
    const Proportions drawn = DrawWidened(random);
    const double seat = drawn.stretch.y() * drawn.width.to / drawn.width.from;
    const double arms = drawn.stretch.y() * (1 - drawn.width.to) / (1 - drawn.width.from);
    EXPECT_GE(arms, std::exp(-0.181));
    EXPECT_LE(arms, std::exp(0.181));
    EXPECT_GE(seat / arms, 1.59);
    EXPECT_LE(seat / arms, 3.21);
  }
}

TEST(Widened, ArmchairsAreInOnePieceAndWiderThanDeep) {
  for (std::uint64_t n = 0; n < 12; ++n) {
    Random random(3, "widened", n);
    const TriangleMesh sofa = Reproportion(MakeMesh(Kind::kArmchair, n), DrawWidened(random));
    const Eigen::Vector3f size = BoxOfFaces(sofa).sizes();
    EXPECT_GT(size.y(), 1.1F * size.x()) << n;
    std::size_t largest = 0;
    std::size_t all = 0;
    for (const auto& part : shape::PartsOf(ShapeOf(sofa), 1)) {
      largest = std::max(largest, part.size());
      all += part.size();
    }
    EXPECT_GE(static_cast<double>(largest), 0.97 * static_cast<double>(all)) << n;
  }
}

}  // namespace
}  // namespace deepslam::furniture
