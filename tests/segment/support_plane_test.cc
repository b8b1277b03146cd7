// Tops of tables and what carries them, each by itself.
#include "deepslam/segment/support_plane.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "deepslam/segment/top_carriers.h"
#include "deepslam/segment/top_heights.h"
#include "support/box_world.h"

namespace deepslam::segment {
namespace {

using namespace testing_support;  // NOLINT

// A table 0.74 m high from before and above, cut into pieces.
class ATable : public testing::Test {
 protected:
  explicit ATable(std::vector<Cuboid> world = TableAt(0, 0, 0)) {
    const Pose3 world_from_camera = LookAt({0.5, -2.2, 1.5}, {0, 0, 0.5});
    view_ = RenderBoxes(world, SmallCamera(), world_from_camera);
    ground_ = FloorIn(world_from_camera);
    pieces_ = CutIntoPieces(view_.frame.depth_m, SmallCamera(), ground_, options_);
    heights_ = HeightsOf(pieces_);
    owners_ = Owners(view_.object.width(), view_.object.height(), -1);
    whole_image_.u_max = view_.object.width() - 1;
    whole_image_.v_max = view_.object.height() - 1;
  }

  std::optional<SupportPlane> Claim() {
    return ClaimSupportPlane(pieces_, heights_, SmallCamera(), ground_, whole_image_, 7, owners_);
  }

  // Above the floor, of a pixel of an object.
  [[nodiscard]] double HeightAt(int u, int v) const {
    const double depth_m = view_.frame.depth_m(u, v);
    return ground_.SignedDistance(SmallCamera().Unproject(u, v, depth_m));
  }

  SegmentOptions options_;
  BoxView view_;
  Plane ground_;
  ImagePieces pieces_;
  std::vector<PieceHeights> heights_;
  Owners owners_;
  Region whole_image_;
};

TEST_F(ATable, HasItsTopAtItsHeight) {
  const std::optional<SupportPlane> top = Claim();
  ASSERT_TRUE(top.has_value());
  EXPECT_NEAR(top->height_m, 0.74, 0.02);  // a bin
  int num_claimed = 0;
  for (int v = 0; v < owners_.height(); ++v) {
    for (int u = 0; u < owners_.width(); ++u) {
      if (owners_(u, v) < 0) continue;
      ++num_claimed;
      EXPECT_EQ(owners_(u, v), 7);
      EXPECT_EQ(view_.object(u, v), 0);
      EXPECT_NEAR(HeightAt(u, v), 0.74, 0.06);
    }
  }
  EXPECT_GT(num_claimed, 1000);
  // The outline on the ground is the table's: 1.2 m by 0.8 m.
  double area_m2 = 0;
  for (std::size_t n = 0; n < top->hull_ground_m.size(); ++n) {
    const Eigen::Vector2d& a = top->hull_ground_m[n];
    const Eigen::Vector2d& b = top->hull_ground_m[(n + 1) % top->hull_ground_m.size()];
    area_m2 += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  EXPECT_NEAR(area_m2, 0.96, 0.1);
}

TEST_F(ATable, PixelsOfOthersAreNotClaimed) {
  std::ranges::fill(owners_, 3);
  EXPECT_FALSE(Claim().has_value());
  EXPECT_TRUE(std::ranges::all_of(owners_, [](std::int32_t owner) { return owner == 3; }));
}

TEST_F(ATable, ItsLegsCarryIt) {
  const std::optional<SupportPlane> top = Claim();
  ASSERT_TRUE(top.has_value());
  const std::vector<OwnedTop> tops = {{7, *top}};
  ClaimCarriers(pieces_, ground_, tops, owners_);
  int num_legs = 0;
  int num_missed = 0;
  for (int v = 0; v < owners_.height(); ++v) {
    for (int u = 0; u < owners_.width(); ++u) {
      const bool leg = view_.object(u, v) == 0 && HeightAt(u, v) < 0.6 && HeightAt(u, v) > 0.1;
      num_legs += leg ? 1 : 0;
      num_missed += leg && owners_(u, v) != 7 ? 1 : 0;
      if (owners_(u, v) == 7) {
        EXPECT_EQ(view_.object(u, v), 0);
      }
    }
  }
  ASSERT_GT(num_legs, 100);
  EXPECT_LT(num_missed, num_legs / 5);
}

class ATableWithAChairUnderIt : public ATable {
 protected:
  static std::vector<Cuboid> World() {
    std::vector<Cuboid> world = TableAt(0, 0, 0);
    Append(world, {{1, {-0.2, -0.3, 0}, {0.2, 0.1, 0.45}}});
    return world;
  }
  ATableWithAChairUnderIt() : ATable(World()) {}
};

TEST_F(ATableWithAChairUnderIt, DoesNotOwnTheChair) {
  const std::optional<SupportPlane> top = Claim();
  ASSERT_TRUE(top.has_value());
  const std::vector<OwnedTop> tops = {{7, *top}};
  ClaimCarriers(pieces_, ground_, tops, owners_);
  for (int v = 0; v < owners_.height(); ++v) {
    for (int u = 0; u < owners_.width(); ++u)
      EXPECT_FALSE(owners_(u, v) == 7 && view_.object(u, v) == 1) << u << " " << v;
  }
}

class ALowBox : public ATable {
 protected:
  ALowBox() : ATable({{0, {-0.4, -0.4, 0}, {0.4, 0.4, 0.25}}}) {}
};

TEST_F(ALowBox, HasNoTop) { EXPECT_FALSE(Claim().has_value()); }

TEST_F(ATable, HeightsAreCountedOnceForEveryPixelOfAPiece) {
  for (std::size_t n = 0; n < heights_.size(); ++n) {
    EXPECT_EQ(heights_[n].all, pieces_.num_pixels[n]);
    EXPECT_LE(heights_[n].from_bin.front(), heights_[n].all);
    for (std::size_t bin = 1; bin < heights_[n].from_bin.size(); ++bin)
      EXPECT_LE(heights_[n].from_bin[bin], heights_[n].from_bin[bin - 1]);
  }
}

}  // namespace
}  // namespace deepslam::segment
