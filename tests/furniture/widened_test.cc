#include "deepslam/furniture/widened.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/furniture/joined.h"
#include "deepslam/scene/mesh_box.h"
#include "deepslam/shape/crumbs.h"
#include "furniture/design_shapes.h"

namespace deepslam::furniture {
namespace {

TriangleMesh MakeMesh(Kind kind, std::uint64_t number) {
  return MakeMesh(kind, number, "widened test");
}

// Of thirty designs of this kind.
int CountSeats(Kind kind, bool (*has)(const VoxelGrid& shape, float seat_height)) {
  int count = 0;
  for (std::uint64_t n = 0; n < 30; ++n) {
    const VoxelGrid shape = ShapeOf(MakeMesh(kind, n));
    const std::optional<float> seat = SeatHeight(shape);
    count += seat && has(shape, *seat) ? 1 : 0;
  }
  return count;
}

TEST(HasArms, OfArmchairsNotOfStools) {
  EXPECT_GE(CountSeats(Kind::kArmchair, HasArms), 24);
  EXPECT_LE(CountSeats(Kind::kStool, HasArms), 1);
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
  EXPECT_GE(CountSeats(Kind::kArmchair, StandsBelowBothSides), 24);
  EXPECT_LE(CountSeats(Kind::kOfficeChair, StandsBelowBothSides), 3);
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
