#include "deepslam/furniture/joined.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "deepslam/furniture/design.h"
#include "deepslam/scene/mesh_box.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::furniture {
namespace {

struct Seat {
  TriangleMesh mesh;
  VoxelGrid shape;
  std::optional<float> height;

  [[nodiscard]] SeatMesh Part() const { return {mesh, shape, height.value_or(0)}; }
};

Seat MakeSeat(Kind kind, std::uint64_t number) {
  Seat seat;
  seat.mesh = MakeDesign(kind, Random(7, "joined test", number)).mesh;
  Result<VoxelGrid> shape = shape::Voxelize(seat.mesh);
  EXPECT_TRUE(shape);
  if (shape) seat.shape = std::move(*shape);
  seat.height = SeatHeight(seat.shape);
  return seat;
}

float Height(const TriangleMesh& mesh) { return BoxOfFaces(mesh).sizes().z(); }

TEST(SeatHeight, IsThatOfChairs) {
  int found = 0;
  for (std::uint64_t n = 0; n < 30; ++n) {
    const Seat seat = MakeSeat(Kind::kChair, n);
    if (!seat.height) continue;
    ++found;
    const float height_m = *seat.height * Height(seat.mesh);
    EXPECT_GE(height_m, 0.36F) << n;
    EXPECT_LE(height_m, 0.62F) << n;
  }
  EXPECT_GE(found, 27);
}

// A plate on a post, and a post on a plate: what is open to above lies too high, or too low.
TEST(SeatHeight, IsNoneWithoutASeatWithinTheHeight) {
  EXPECT_FALSE(SeatHeight(VoxelGrid{}));
  for (const int plate : {1, 62}) {
    VoxelGrid shape;
    for (int i = 16; i < 48; ++i) {
      for (int j = 16; j < 48; ++j) shape.occupied[VoxelGrid::Index(i, j, plate)] = 1;
    }
    for (int k = 1; k <= 62; ++k) shape.occupied[VoxelGrid::Index(32, 32, k)] = 1;
    EXPECT_FALSE(SeatHeight(shape)) << plate;
  }
}

// The topmost layer of a grid has nothing above it either.
TEST(SeatHeight, EndsAtTheGrid) {
  VoxelGrid full;
  std::fill(full.occupied.begin(), full.occupied.end(), 1);
  EXPECT_FALSE(SeatHeight(full));
}

TEST(JoinAtSeat, WithItselfIsItself) {
  for (std::uint64_t n = 0; n < 8; ++n) {
    const Seat seat = MakeSeat(Kind::kChair, n);
    if (!seat.height) continue;
    const TriangleMesh joined = JoinAtSeat(seat.Part(), seat.Part());
    const Result<VoxelGrid> shape = shape::Voxelize(joined);
    ASSERT_TRUE(shape);
    EXPECT_GE(shape::GridIntersectionOverUnion(*shape, seat.shape), 0.9) << n;
  }
}

TEST(JoinAtSeat, HasTheLegsOfOneAndTheBackOfTheOther) {
  int joins = 0;
  for (std::uint64_t n = 0; n < 12; ++n) {
    const Seat lower = MakeSeat(Kind::kChair, n);
    const Seat upper = MakeSeat(Kind::kChair, n + 50);
    if (!lower.height || !upper.height) continue;
    ++joins;
    const TriangleMesh joined = JoinAtSeat(lower.Part(), upper.Part());
    const float seat_m = *lower.height * Height(lower.mesh);
    const float back_m = (1 - *upper.height) * Height(upper.mesh);
    EXPECT_NEAR(Height(joined), seat_m + back_m, 1e-4F) << n;
    const Eigen::AlignedBox3f plan = BoxOfFaces(lower.mesh);
    for (const Eigen::Vector3f& place : joined.vertices) {
      ASSERT_TRUE(place.allFinite());
      EXPECT_GE(place.y(), plan.min().y() - 1e-4F);
      EXPECT_LE(place.y(), plan.max().y() + 1e-4F);
    }
    EXPECT_EQ(joined.colours.size(), joined.vertices.size());
  }
  EXPECT_GE(joins, 9);
}

TEST(JoinAtSeat, OfNothingIsWhatTheOtherGives) {
  const Seat seat = MakeSeat(Kind::kChair, 1);
  ASSERT_TRUE(seat.height);
  const TriangleMesh nothing;
  const VoxelGrid empty;
  EXPECT_TRUE(JoinAtSeat({nothing, empty, 0.5F}, {nothing, empty, 0.5F}).empty());
  const TriangleMesh legs = JoinAtSeat(seat.Part(), {nothing, empty, 0.5F});
  EXPECT_NEAR(Height(legs), *seat.height * Height(seat.mesh), 1e-4F);
}

}  // namespace
}  // namespace deepslam::furniture
