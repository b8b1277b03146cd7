#include "deepslam/detect/cluster_detector.h"

#include <gmock/gmock.h>

#include "support/box_world.h"

namespace deepslam::detect {
namespace {

using testing::Ge;
using testing::IsEmpty;
using testing::SizeIs;
using namespace testing_support;  // NOLINT

ClassTable Classes() {
  ClassTable table;
  table.classes.resize(3);
  table.classes[0].name = "chair";
  table.classes[0].detector_labels = {"chair"};
  table.classes[1].name = "cabinet";
  table.classes[1].min_size_m = 0.5;
  table.classes[1].max_size_m = 1.8;
  table.classes[1].min_height_m = 0.4;
  table.classes[1].max_height_m = 1.8;
  table.classes[2].name = "furniture";
  table.classes[2].traits.fallback = true;
  return table;
}

const Cuboid kCabinet = {0, {-0.4, -0.25, 0}, {0.4, 0.25, 0.6}};

struct View {
  BoxView boxes;
  Plane ground;
};

View Look(const std::vector<Cuboid>& world,
          const Eigen::Vector3d& eye,
          const Eigen::Vector3d& target) {
  const Pose3 world_from_camera = LookAt(eye, target);
  return {RenderBoxes(world, SmallCamera(), world_from_camera), FloorIn(world_from_camera)};
}

std::vector<Detection> Find(const View& view,
                            const std::vector<Detection>& covered = {},
                            const ClassTable& classes = Classes()) {
  return DetectClusters(view.boxes.frame, SmallCamera(), view.ground, covered, classes, {});
}

TEST(DetectClusters, FindsACabinetOnAnEmptyFloor) {
  const View view = Look({kCabinet}, {0.8, -2.0, 1.3}, {0, 0, 0.3});
  const auto found = Find(view);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].class_name, "cabinet");
  EXPECT_EQ(found[0].source, DetectionSource::kCluster);
  EXPECT_THAT(IntersectionOverUnion(found[0].box_px, DetectTruth(view.boxes, 0, "")->box_px),
              Ge(0.9));
  EXPECT_THAT(MaskIoU(found[0].mask, view.boxes, 0), Ge(0.9));
}

const Cuboid kWall = {-1, {-4, 0.25, 0}, {4, 0.35, 2.6}};
const Cuboid kSideWall = {-1, {0.4, -4, 0}, {0.5, 4, 2.6}};

TEST(DetectClusters, FindsWhatStandsAgainstAWallOrInACorner) {
  const Eigen::Vector3d eye(-0.5, -2.0, 1.4);
  const Eigen::Vector3d target(0, 0, 0.4);
  for (const std::vector<Cuboid>& world :
       {std::vector<Cuboid>{kCabinet, kWall}, std::vector<Cuboid>{kCabinet, kWall, kSideWall}}) {
    const View view = Look(world, eye, target);
    const auto found = Find(view);
    ASSERT_THAT(found, SizeIs(1));
    EXPECT_EQ(found[0].class_name, "cabinet");
    // What is nearer to the wall than depth is noisy goes with the wall.
    EXPECT_THAT(MaskIoU(found[0].mask, view.boxes, 0), Ge(0.75));
  }
}

TEST(DetectClusters, FindsATallCabinetAgainstAWall) {
  const View view =
      Look({{0, {-0.3, -0.15, 0}, {0.3, 0.25, 1.7}}, kWall}, {1.3, -2.5, 1.3}, {0, 0, 0.9});
  const auto found = Find(view);
  ASSERT_THAT(found, SizeIs(1)) << "its front is no wall, as there is one behind";
  EXPECT_THAT(MaskIoU(found[0].mask, view.boxes, 0), Ge(0.75));
}

TEST(DetectClusters, CallsFurnitureWhatFitsNoClass) {
  const View view = Look({{0, {-0.2, -0.2, 0}, {0.2, 0.2, 0.35}}}, {0.8, -1.6, 1.2}, {0, 0, 0.2});
  const auto found = Find(view);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].class_name, "furniture");
  ClassTable without = Classes();
  without.classes.resize(2);
  EXPECT_THAT(Find(view, {}, without), IsEmpty());
}

TEST(DetectClusters, LeavesOutWhatFitsNoClassOfATableWithoutAFallback) {
  ClassTable classes = Classes();
  classes.classes[2].traits.fallback = false;  // its sizes are a class's like any other's
  classes.classes[1].max_size_m = classes.classes[2].max_size_m = 0.6;
  EXPECT_THAT(Find(Look({kCabinet}, {0.8, -2.0, 1.3}, {0, 0, 0.3}), {}, classes), IsEmpty());
}

TEST(DetectClusters, LeavesToOthersWhatTheyHaveFound) {
  const View view = Look({kCabinet}, {0.8, -2.0, 1.3}, {0, 0, 0.3});
  EXPECT_THAT(Find(view, {*DetectTruth(view.boxes, 0, "chair")}), IsEmpty());
}

TEST(DetectClusters, FindsWhatStandsBeforeWhatOthersHaveFound) {
  const Cuboid low = {0, {-0.5, -0.3, 0}, {0.5, 0.3, 0.45}};
  const Cuboid sofa = {1, {-0.9, 0.6, 0}, {0.9, 1.4, 0.8}};
  const View view = Look({low, sofa}, {0.7, -2.2, 1.6}, {0, 0.3, 0.3});
  Detection around = *DetectTruth(view.boxes, 1, "sofa");
  const Box2 box = DetectTruth(view.boxes, 0, "")->box_px;
  around.box_px.v_max = box.v_min + 0.45 * box.height_px();
  const auto found = Find(view, {around});
  ASSERT_THAT(found, SizeIs(1)) << "the sofa's box covers half of it";
  EXPECT_THAT(MaskIoU(found[0].mask, view.boxes, 0), Ge(0.9));
}

TEST(DetectClusters, DoesNotTakeTheRoomForFurniture) {
  const Eigen::Vector3d eye(0.3, -2.2, 1.3);
  const Eigen::Vector3d target(0, 0, 0.5);
  EXPECT_THAT(Find(Look({}, eye, target)), IsEmpty()) << "a floor";
  EXPECT_THAT(Find(Look({{0, {-4, 0.5, 0}, {4, 0.6, 2.6}}}, eye, target)), IsEmpty()) << "a wall";
  EXPECT_THAT(Find(Look({{0, {-4, 0.2, 0}, {4, 0.8, 0.9}}}, eye, target)), IsEmpty())
      << "a counter from border to border";
  EXPECT_THAT(Find(Look({{0, {-0.3, 0.2, 0}, {0.3, 0.8, 2.6}}}, eye, target)), IsEmpty())
      << "a pillar";
  EXPECT_THAT(Find(Look({{0, {-0.4, -0.2, 0.5}, {0.4, 0.2, 0.9}}}, eye, target)), IsEmpty())
      << "a thing that does not stand";
}

TEST(DetectClusters, DoesNotTakeWhatRunsOnBehindSomethingElse) {
  // The cabinet's right end is hidden: it may be the end of a row.
  const View view =
      Look({kCabinet, {1, {0.15, -1.2, 0}, {0.35, -1.1, 1.1}}}, {0.2, -2.2, 1.2}, {0.1, 0, 0.3});
  for (const Detection& found : Find(view)) {
    EXPECT_LT(IntersectionOverUnion(found.box_px, DetectTruth(view.boxes, 0, "")->box_px), 0.5);
  }
}

TEST(DetectClusters, BearsImagesWithoutDepth) {
  View view = Look({kCabinet}, {0.8, -2.0, 1.3}, {0, 0, 0.3});
  view.boxes.frame.depth_m = DepthImage(320, 240);
  EXPECT_THAT(Find(view), IsEmpty());
  view.boxes.frame.depth_m = DepthImage();
  EXPECT_THAT(Find(view), IsEmpty());
  EXPECT_THAT(DetectClusters({}, PinholeCamera(), Plane(), {}, Classes(), {}), IsEmpty());
  // A camera of absurd focal length sees points far to the side.
  view = Look({kCabinet}, {0.8, -2.0, 1.3}, {0, 0, 0.3});
  PinholeCamera absurd = SmallCamera();
  absurd.fx = absurd.fy = 1e-6;
  (void)DetectClusters(view.boxes.frame, absurd, view.ground, {}, Classes(), {});
}

}  // namespace
}  // namespace deepslam::detect
