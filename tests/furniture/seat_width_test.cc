#include "deepslam/furniture/seat_width.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/furniture/joined.h"
#include "deepslam/scene/mesh_box.h"
#include "deepslam/shape/small_components.h"
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

// Factors of the width between the arms and of the arms.
struct WidthFactors {
  double seat = 1;
  double arms = 1;
};

WidthFactors FactorsOf(const Proportions& drawn) {
  return {drawn.stretch.y() * drawn.width.to / drawn.width.from,
          drawn.stretch.y() * (1 - drawn.width.to) / (1 - drawn.width.from)};
}

TEST(SeatWidth, KeepsTheArmsWhereTheSeatIsWiderOrNarrower) {
  for (std::uint64_t n = 0; n < 100; ++n) {
    Random random(3, "widened", n);
    const WidthFactors wide = FactorsOf(DrawWidened(random));
    const WidthFactors narrow = FactorsOf(DrawNarrowed(random));
    for (const double arms : {wide.arms, narrow.arms}) {
      EXPECT_GE(arms, std::exp(-0.181));
      EXPECT_LE(arms, std::exp(0.181));
    }
    EXPECT_GE(wide.seat / wide.arms, 1.59);
    EXPECT_LE(wide.seat / wide.arms, 3.21);
    EXPECT_GE(narrow.seat / narrow.arms, 0.249);
    EXPECT_LE(narrow.seat / narrow.arms, 0.451);
  }
}

double LargestPart(const TriangleMesh& mesh) {
  std::size_t largest = 0;
  std::size_t all = 0;
  for (const auto& part : shape::PartsOf(ShapeOf(mesh), 1)) {
    largest = std::max(largest, part.size());
    all += part.size();
  }
  return static_cast<double>(largest) / static_cast<double>(all);
}

// Width over depth of designs of the kind with seats of other widths, on average; each in one
// piece.
double MeanWidthOverDepth(Kind kind, Proportions (*draw)(Random&)) {
  constexpr std::uint64_t kDesigns = 12;
  double sum = 0;
  for (std::uint64_t n = 0; n < kDesigns; ++n) {
    Random random(3, "seat width", n);
    const TriangleMesh made = Reproportion(MakeMesh(kind, n), draw(random));
    const Eigen::Vector3f size = BoxOfFaces(made).sizes();
    EXPECT_GE(LargestPart(made), 0.97) << n;
    sum += size.y() / size.x();
  }
  return sum / kDesigns;
}

TEST(SeatWidth, WidenedArmchairsAreAsWideAsSofas) {
  EXPECT_GT(MeanWidthOverDepth(Kind::kArmchair, DrawWidened), 1.5);
}

TEST(SeatWidth, NarrowedSofasAreAsWideAsArmchairs) {
  EXPECT_LT(MeanWidthOverDepth(Kind::kSofa, DrawNarrowed), 1.2);
}

}  // namespace
}  // namespace deepslam::furniture
