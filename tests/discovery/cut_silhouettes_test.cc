#include "deepslam/discovery/cut_silhouettes.h"

#include <vector>

#include <gtest/gtest.h>

#include "support/box_world.h"

namespace deepslam::discovery {
namespace {

using instances::Instance;
using instances::Silhouette;
using namespace testing_support;  // NOLINT

constexpr int kTable = 0;
constexpr int kBox = 1;
constexpr int kChair = 2;

ClassTable Classes() {
  ClassTable table;
  table.classes = {{"chair", {"chair"}, {}, 0.4, 1.5, 0.4, 1.4, {}, {}},
                   {"table", {"dining table"}, {}, 0.4, 4, 0.3, 1.2, {}, {.support_plane = true}}};
  return table;
}

Silhouette Of(int instance, const Mask& mask) {
  Silhouette silhouette;
  silhouette.instance = instance;
  silhouette.mask = mask;
  silhouette.box_px = {0, 0, mask.width() - 1.0, mask.height() - 1.0};
  return silhouette;
}

// A table with a box on it and a chair before it, as one frame shows them.
class CutSilhouettesTest : public testing::Test {
 protected:
  CutSilhouettesTest() {
    std::vector<Cuboid> world = TableAt(kTable, 0, 0);
    world.push_back({kBox, {-0.3, -0.1, 0.74}, {0.0, 0.2, 0.86}});
    Append(world, ChairAt(kChair, 0.2, -0.7, -1));
    pose_ = LookAt({0.8, -2.0, 1.6}, {0, 0, 0.5});
    view_ = RenderBoxes(world, SmallCamera(), pose_);
    table_.class_name = "table";
    table_.has_support_plane = true;
    table_.box_level = {{0, 0}, 0, 1.2, 0.8, 0, 0.84};
    chair_.class_name = "chair";
    chair_.box_level = {{0.2, -0.7}, 0, 0.45, 0.45, 0, 0.9};
  }

  // 1 where the frame shows one of the objects above `min_height_m`.
  [[nodiscard]] Mask Shown(std::vector<int> objects, double min_height_m = 0) const {
    Mask mask(view_.object.width(), view_.object.height());
    for (int v = 0; v < mask.height(); ++v) {
      for (int u = 0; u < mask.width(); ++u) {
        const Eigen::Vector3d p = pose_ * SmallCamera().Unproject(u, v, view_.frame.depth_m(u, v));
        mask(u, v) = std::ranges::count(objects, view_.object(u, v)) > 0 && p.z() > min_height_m;
      }
    }
    return mask;
  }

  [[nodiscard]] int CountIn(const Mask& mask, int object) const {
    int count = 0;
    for (std::size_t p = 0; p < mask.size(); ++p)
      count += mask.data()[p] != 0 && view_.object.data()[p] == object ? 1 : 0;
    return count;
  }

  void Cut(std::vector<Silhouette>& silhouettes) {
    const std::vector<Instance> things = {table_, chair_};
    const PinholeCamera camera = SmallCamera();
    CutSilhouettes({view_.frame, camera, pose_, things}, Classes(), {}, silhouettes);
  }

  Pose3 pose_;
  BoxView view_;
  Instance table_;
  Instance chair_;
};

// The surface is too coarse for the legs and takes the foot of the box for the top.
TEST_F(CutSilhouettesTest, ATableIsItsTopAndItsLegsWithoutWhatStandsOnIt) {
  std::vector<Silhouette> silhouettes = {Of(0, Shown({kTable, kBox}, 0.6)),
                                         Of(1, Shown({kChair}, 0.05))};
  const int num_leg_pixels =
      CountIn(Shown({kTable}, 0.05), kTable) - CountIn(Shown({kTable}, 0.69), kTable);
  const int num_before = CountIn(silhouettes[0].mask, kTable);
  Cut(silhouettes);
  EXPECT_LT(CountIn(silhouettes[0].mask, kBox), CountIn(Shown({kBox}), kBox) / 4);
  EXPECT_GT(CountIn(silhouettes[0].mask, kTable), num_before + num_leg_pixels / 3);
  EXPECT_EQ(CountIn(silhouettes[0].mask, kChair), 0);
}

// No layer is found in the box, which is too narrow; the silhouette as the surface has it remains.
TEST_F(CutSilhouettesTest, NothingAboveTheTopIsTheTablesThoughTheFrameShowsNoLayer) {
  table_.box_level = {{5, 5}, 0, 1.2, 0.8, 0, 0.84};
  std::vector<Silhouette> silhouettes = {Of(kTable, Shown({kTable, kBox}))};
  Cut(silhouettes);
  const int of_box = CountIn(silhouettes[0].mask, kBox);
  const int of_table = CountIn(silhouettes[0].mask, kTable);
  ASSERT_GT(of_box, 100);
  table_.top_m = 0.74;
  Cut(silhouettes);
  EXPECT_LT(CountIn(silhouettes[0].mask, kBox), of_box / 2);
  EXPECT_EQ(CountIn(silhouettes[0].mask, kTable), of_table);
  EXPECT_EQ(silhouettes[0].num_points, of_table + CountIn(silhouettes[0].mask, kBox));
}

TEST_F(CutSilhouettesTest, ThingsWithoutASupportPlaneStayAsTheyAre) {
  table_.has_support_plane = false;
  std::vector<Silhouette> silhouettes = {Of(0, Shown({kTable, kBox}, 0.6)),
                                         Of(1, Shown({kChair}, 0.05))};
  const Mask table = silhouettes[0].mask;
  const Mask chair = silhouettes[1].mask;
  Cut(silhouettes);
  EXPECT_EQ(silhouettes[0].mask, table);
  EXPECT_EQ(silhouettes[1].mask, chair);
}

// A table that the surface has in two: what one of them leaves is the other's.
TEST_F(CutSilhouettesTest, NoPixelIsOfTwoThingsAndEachHasItsOwn) {
  const Mask top = Shown({kTable, kBox}, 0.6);
  for (const int split_u : {SmallCamera().width / 3, SmallCamera().width / 2}) {
    Mask left = top;
    Mask right = top;
    for (int v = 0; v < top.height(); ++v) {
      for (int u = 0; u < top.width(); ++u) (u < split_u ? right : left)(u, v) = 0;
    }
    std::vector<Silhouette> silhouettes = {Of(0, left), Of(0, right)};
    Cut(silhouettes);
    for (std::size_t pixel = 0; pixel < top.size(); ++pixel) {
      const bool both =
          silhouettes[0].mask.data()[pixel] != 0 && silhouettes[1].mask.data()[pixel] != 0;
      ASSERT_FALSE(both) << pixel;
    }
    for (const Silhouette& silhouette : silhouettes) EXPECT_GT(silhouette.box_px.area_px(), 0);
  }
}

TEST_F(CutSilhouettesTest, WithoutDepthThereIsNothingToCut) {
  view_.frame.depth_m = DepthImage(view_.object.width(), view_.object.height());
  std::vector<Silhouette> silhouettes = {Of(0, Mask(view_.object.width(), view_.object.height()))};
  const Mask before = silhouettes[0].mask;
  Cut(silhouettes);
  EXPECT_EQ(silhouettes[0].mask, before);
  silhouettes.clear();
  Cut(silhouettes);
  EXPECT_TRUE(silhouettes.empty());
}

}  // namespace
}  // namespace deepslam::discovery
