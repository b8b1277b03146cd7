#include "deepslam/segment/segment_objects.h"

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <utility>

#include <gmock/gmock.h>

#include "deepslam/geometry/upright.h"
#include "support/box_world.h"

namespace deepslam::segment {
namespace {

using testing::Ge;
using testing::Le;
using namespace testing_support;  // NOLINT

// Pixels at edges are mixed: a silhouette one pixel off all round a thing of 100 px still has this
// overlap.
constexpr double kGoodIoU = 0.9;

std::vector<Detection> Truth(const BoxView& view, const std::vector<std::string>& classes) {
  std::vector<Detection> detections;
  for (std::size_t i = 0; i < classes.size(); ++i) {
    auto detection = DetectTruth(view, static_cast<int>(i), classes[i]);
    if (!detection) continue;
    detection->id = {static_cast<int>(i)};
    detections.push_back(*detection);
  }
  return detections;
}

struct Scene {
  std::vector<Cuboid> world;
  Pose3 world_from_camera;
  BoxView view;
  Plane ground;
};

Scene Make(std::vector<Cuboid> world, const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  Scene scene;
  scene.world = std::move(world);
  scene.world_from_camera = LookAt(eye, target);
  scene.view = RenderBoxes(scene.world, SmallCamera(), scene.world_from_camera);
  scene.ground = FloorIn(scene.world_from_camera);
  return scene;
}

SegmentOptions ForSmallImages() {
  SegmentOptions options;
  options.min_points = 100;  // a quarter of the default, as are the images
  return options;
}

ClassTable Classes() {
  ClassTable table;
  table.classes.resize(2);
  table.classes[0].name = "table";
  table.classes[0].traits.support_plane = true;
  table.classes[1].name = "chair";
  return table;
}

std::vector<Segment> SegmentsOf(const Scene& scene,
                                const std::vector<std::string>& names,
                                const ClassTable& classes = Classes()) {
  const PinholeCamera camera = SmallCamera();
  const std::vector<Detection> detections = Truth(scene.view, names);
  return SegmentFrame(
      {scene.view.frame, camera, scene.ground, detections}, classes, ForSmallImages());
}

TEST(SegmentFrame, FindsTheSilhouetteOfABoxOnTheFloorBeforeAWall) {
  const Scene scene =
      Make({{0, {-0.4, -0.3, 0}, {0.4, 0.3, 0.6}}, {-1, {-3, 0.9, 0}, {3, 1.0, 2.5}}},
           {0.8, -2.2, 1.4},
           {0, 0, 0.3});
  const auto segments = SegmentsOf(scene, {"cabinet"});
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_TRUE(segments[0].usable) << segments[0].reason;
  EXPECT_THAT(MaskIoU(segments[0].mask, scene.view, 0), Ge(kGoodIoU));
  EXPECT_FALSE(segments[0].touches_border);
  // The box's true extent in depth bounds that of the segment.
  EXPECT_THAT(segments[0].extent_camera.Size().norm(), Le(0.8 + 0.6 + 0.6));
}

// The frame of a chair's back, and a wall one and a half metres behind it.
std::vector<Cuboid> BackBeforeAWall() {
  return {{0, {-0.25, -0.02, 0}, {-0.21, 0.02, 0.9}},
          {0, {0.21, -0.02, 0}, {0.25, 0.02, 0.9}},
          {0, {-0.21, -0.02, 0.75}, {0.21, 0.02, 0.9}},
          {-1, {-3, 1.5, 0}, {3, 1.6, 2.5}}};
}

// As a dark thing appears, which sends no light back.
void TakeDepthOf(int id, BoxView& view) {
  for (int v = 0; v < view.object.height(); ++v) {
    for (int u = 0; u < view.object.width(); ++u) {
      if (view.object(u, v) == id) view.frame.depth_m(u, v) = 0;
    }
  }
}

TEST(SegmentFrame, TheWallSeenThroughADarkChairIsNotTheChair) {
  Scene scene = Make(BackBeforeAWall(), {0.2, -2.0, 1.0}, {0, 0, 0.6});
  TakeDepthOf(0, scene.view);
  const auto segments = SegmentsOf(scene, {"chair"});
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_FALSE(segments[0].usable);
  EXPECT_THAT(segments[0].reason, testing::HasSubstr("wall behind"));
}

// What is found in the picture turned by `held`, told what sets it upright.
std::vector<Segment> SegmentsHeld(const Scene& scene,
                                  const std::vector<std::string>& classes,
                                  QuarterTurn held) {
  Frame frame;
  frame.depth_m = Turned(scene.view.frame.depth_m, held);
  std::vector<Detection> detections = Truth(scene.view, classes);
  for (Detection& detection : detections)
    detection.box_px = Turned(detection.box_px, 320, 240, held);
  const PinholeCamera camera = Turned(SmallCamera(), held);
  return SegmentFrame({frame, camera, Turned(scene.ground, held), detections, Inverse(held)},
                      Classes(),
                      ForSmallImages());
}

constexpr std::array kTurns = {
    QuarterTurn::kNone, QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise};

// Also where the wall ends to the left or to the right of the chair: above and one side are enough.
TEST(SegmentFrame, TheWallIsNotTheChairHoweverThePictureIsHeld) {
  std::vector<Cuboid> world = BackBeforeAWall();
  for (const auto& [from, to] :
       {std::pair(-3.0, 3.0), std::pair(-3.0, 0.3), std::pair(-0.6, 3.0)}) {
    world.back().min_m.x() = from;
    world.back().max_m.x() = to;
    Scene scene = Make(world, {0.2, -2.0, 1.0}, {0, 0, 0.6});
    TakeDepthOf(0, scene.view);
    for (const QuarterTurn held : kTurns) {
      const auto segments = SegmentsHeld(scene, {"chair"}, held);
      ASSERT_EQ(segments.size(), 1U);
      EXPECT_THAT(segments[0].reason, testing::HasSubstr("wall behind"))
          << from << " to " << to << ", turn " << static_cast<int>(held);
    }
  }
}

// A front with others beside it and below it in one plane, and none above. Turned, one of those is
// above it in the picture.
TEST(SegmentFrame, ThingsInARowAreUsableHoweverThePictureIsHeld) {
  const Scene row = Make({{-1, {-1.2, 0, 0}, {-0.22, 0.02, 0.8}},
                          {0, {-0.2, 0, 0.25}, {0.2, 0.02, 0.8}},
                          {-1, {0.22, 0, 0}, {1.2, 0.02, 0.8}},
                          {-1, {-0.2, 0, 0}, {0.2, 0.02, 0.23}},
                          {-1, {-3, 1.5, 0}, {3, 1.6, 2.5}}},
                         {0.1, -2.6, 1.2},
                         {0, 0, 0.4});
  for (const QuarterTurn held : kTurns) {
    const auto segments = SegmentsHeld(row, {"cabinet"}, held);
    ASSERT_EQ(segments.size(), 1U);
    EXPECT_TRUE(segments[0].usable) << segments[0].reason << ", turn " << static_cast<int>(held);
  }
}

TEST(SegmentFrame, ThingsBeforeAWallAreUsableAndThoseInARowAreToo) {
  const Scene back =
      Make({{0, {-0.3, -0.02, 0}, {0.3, 0.02, 0.9}}, {-1, {-3, 1.5, 0}, {3, 1.6, 2.5}}},
           {0.2, -2.0, 1.0},
           {0, 0, 0.6});
  const auto alone = SegmentsOf(back, {"chair"});
  ASSERT_EQ(alone.size(), 1U);
  EXPECT_TRUE(alone[0].usable) << alone[0].reason;
  // Fronts in one plane, which goes on beside the middle one but not above it.
  const Scene row = Make({{0, {-1.2, 0, 0}, {-0.42, 0.4, 0.8}},
                          {1, {-0.38, 0, 0}, {0.38, 0.4, 0.8}},
                          {2, {0.42, 0, 0}, {1.2, 0.4, 0.8}},
                          {-1, {-3, 1.5, 0}, {3, 1.6, 2.5}}},
                         {0.1, -2.6, 1.2},
                         {0, 0, 0.4});
  for (const Segment& segment : SegmentsOf(row, {"cabinet", "cabinet", "cabinet"}))
    EXPECT_THAT(segment.reason, testing::Not(testing::HasSubstr("wall")));
}

TEST(SegmentFrame, PartsTableAndChairsWhoseBoxesOverlap) {
  std::vector<Cuboid> world = TableAt(0, 0, 0);
  Append(world, ChairAt(1, -0.2, -0.65, -1));  // between camera and table
  Append(world, ChairAt(2, 0.3, 0.7, 1));      // behind the table
  const Scene scene = Make(std::move(world), {0.5, -2.6, 1.5}, {0, 0, 0.5});
  const auto segments = SegmentsOf(scene, {"table", "chair", "chair"});
  ASSERT_EQ(segments.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const Segment& segment = segments[static_cast<std::size_t>(i)];
    EXPECT_TRUE(segment.usable) << i << ": " << segment.reason;
    EXPECT_THAT(MaskIoU(segment.mask, scene.view, i), Ge(0.8)) << segment.class_name << " " << i;
  }
  std::vector<Mask> masks;
  for (const Segment& segment : segments) masks.push_back(segment.mask.Unpacked());
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      int owners = 0;
      for (const Mask& mask : masks) owners += mask(u, v);
      ASSERT_LE(owners, 1) << "pixel " << u << ", " << v << " belongs to two segments";
    }
  }
}

TEST(SegmentFrame, KeepsWhatStandsOnATableOutOfTheTable) {
  std::vector<Cuboid> world = TableAt(0, 0, 0);
  world.push_back({1, {-0.15, -0.1, 0.74}, {0.15, 0.15, 0.95}});
  const Scene scene = Make(std::move(world), {0.4, -2.4, 1.6}, {0, 0, 0.5});
  const auto segments = SegmentsOf(scene, {"table"});
  const Mask mask = segments[0].mask.Unpacked();
  int inside = 0;
  int total = 0;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (scene.view.object(u, v) != 1) continue;
      ++total;
      inside += mask(u, v);
    }
  }
  ASSERT_GT(total, 100);
  EXPECT_THAT(static_cast<double>(inside) / total, Le(0.1));
}

// The class's trait counts, not its name.
TEST(SegmentFrame, GivesATopToEveryClassThatHasASupportPlane) {
  std::vector<Cuboid> world = TableAt(0, 0, 0);
  // A box on the table, which belongs to what has no top of its own.
  world.push_back({1, {-0.15, -0.15, 0.74}, {0.15, 0.15, 0.90}});
  const Scene scene = Make(std::move(world), {0.5, -2.6, 1.5}, {0, 0, 0.5});
  const auto table = SegmentsOf(scene, {"table"});
  ClassTable renamed = Classes();
  renamed.classes[0].name = "altar";
  const auto altar = SegmentsOf(scene, {"altar"}, renamed);
  EXPECT_EQ(altar[0].mask, table[0].mask);
  const auto without = SegmentsOf(scene, {"table"}, renamed);
  EXPECT_NE(without[0].mask, table[0].mask);
}

// Dark, shiny and glass tops return depth near their edges only; the seat before the table returns
// all of its own and has more level pixels than is left of the top.
TEST(SegmentFrame, FindsATableByTheRimOfItsTop) {
  std::vector<Cuboid> world = TableAt(0, 0, 0);
  Append(world, ChairAt(1, -0.2, -0.65, -1));
  Append(world, ChairAt(2, 0.3, 0.7, 1));
  Scene scene = Make(std::move(world), {0.5, -2.6, 1.5}, {0, 0, 0.5});
  constexpr double kRim_m = 0.03;
  constexpr double kTop_m = 0.74;  // as TableAt has it
  int removed = 0;
  Eigen::Array2d reach = Eigen::Array2d::Zero();
  for (const Cuboid& part : scene.world) {
    if (part.object == 0) reach = reach.max(part.max_m.head<2>().array());
  }
  DepthImage& depth_m = scene.view.frame.depth_m;
  for (int v = 0; v < depth_m.height(); ++v) {
    for (int u = 0; u < depth_m.width(); ++u) {
      if (scene.view.object(u, v) != 0) continue;
      const Eigen::Vector3d p =
          scene.world_from_camera * SmallCamera().Unproject(u, v, depth_m(u, v));
      const Eigen::Array2d to_edge = reach - p.head<2>().array().abs();
      if (p.z() < kTop_m - 0.01 || to_edge.minCoeff() < kRim_m) continue;
      depth_m(u, v) = 0;
      ++removed;
    }
  }
  ASSERT_GT(removed, 1000);
  const auto segments = SegmentsOf(scene, {"table", "chair", "chair"});
  ASSERT_EQ(segments.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const Mask mask = segments[static_cast<std::size_t>(i)].mask.Unpacked();
    int measured = 0;
    int right = 0;
    int of_object = 0;
    for (int v = 0; v < depth_m.height(); ++v) {
      for (int u = 0; u < depth_m.width(); ++u) {
        if (!(depth_m(u, v) > 0)) continue;
        const bool is_object = scene.view.object(u, v) == i;
        const bool in_mask = mask(u, v) != 0;
        of_object += is_object ? 1 : 0;
        measured += in_mask ? 1 : 0;
        right += in_mask && is_object ? 1 : 0;
      }
    }
    EXPECT_GT(right, 0.8 * measured) << "what segment " << i << " holds is its own";
    EXPECT_GT(right, 0.7 * of_object) << "and most of what is left of it";
  }
}

// Share of what object 0 shows between two heights (metres) that the mask holds.
double KeptShare(const Scene& scene, const PixelMask& pixels, double low_m, double high_m) {
  const Mask mask = pixels.Unpacked();
  int seen = 0;
  int kept = 0;
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) {
      if (scene.view.object(u, v) != 0) continue;
      const double depth_m = scene.view.frame.depth_m(u, v);
      const double height_m = scene.ground.SignedDistance(SmallCamera().Unproject(u, v, depth_m));
      if (height_m < low_m || height_m > high_m) continue;
      ++seen;
      kept += mask(u, v);
    }
  }
  EXPECT_GT(seen, 100);
  return static_cast<double>(kept) / std::max(1, seen);
}

TEST(SegmentFrame, KeepsThinLegs) {
  const Scene scene = Make(ChairAt(0, 0, 0, 1), {0.9, -1.6, 1.1}, {0, 0, 0.4});
  const auto segments = SegmentsOf(scene, {"chair"});
  EXPECT_THAT(KeptShare(scene, segments[0].mask, 0.1, 0.4), Ge(0.8));
}

TEST(SegmentFrame, KeepsLegsOfTablesThatNoiseCutsIntoPieces) {
  Scene scene = Make(TableAt(0, 0, 0), {1.1, -1.9, 1.2}, {0, 0, 0.4});
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, 0.008F);
  for (float& depth_m : scene.view.frame.depth_m) depth_m += depth_m > 0 ? noise(random) : 0.0F;
  const auto segments = SegmentsOf(scene, {"table"});
  EXPECT_THAT(KeptShare(scene, segments[0].mask, 0.1, 0.6), Ge(0.8));
}

TEST(SegmentFrame, CutsByAnInstanceMask) {
  const Scene scene = Make({{0, {-0.4, -0.3, 0}, {0.4, 0.3, 0.6}}}, {0.8, -2.2, 1.4}, {0, 0, 0.3});
  auto detections = Truth(scene.view, {"cabinet"});
  Mask left(320, 240);
  const Box2 box = detections[0].box_px;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 0.5 * (box.u_min + box.u_max); ++u) left(u, v) = 1;
  }
  detections[0].mask = left;
  SegmentOptions options = ForSmallImages();
  options.min_piece_share = 0.3;  // the mask cuts surfaces in half
  const PinholeCamera camera = SmallCamera();
  const auto segments =
      SegmentFrame({scene.view.frame, camera, scene.ground, detections}, Classes(), options);
  ASSERT_TRUE(segments[0].usable) << segments[0].reason;
  const Mask mask = segments[0].mask.Unpacked();
  for (int v = 0; v < 240; ++v) {
    for (int u = static_cast<int>(0.5 * (box.u_min + box.u_max) + options.mask_dilation_px) + 1;
         u < 320;
         ++u) {
      ASSERT_EQ(mask(u, v), 0) << u << ", " << v;
    }
  }
}

TEST(SegmentFrame, WorksWithoutAGround) {
  const Scene scene =
      Make({{0, {-0.4, -0.3, 0.5}, {0.4, 0.3, 1.1}}}, {0.8, -2.2, 1.4}, {0, 0, 0.8});
  const PinholeCamera camera = SmallCamera();
  const std::vector<Detection> detections = Truth(scene.view, {"table"});
  const auto segments = SegmentFrame(
      {scene.view.frame, camera, std::nullopt, detections}, Classes(), ForSmallImages());
  EXPECT_TRUE(segments[0].usable);
  EXPECT_THAT(MaskIoU(segments[0].mask, scene.view, 0), Ge(kGoodIoU));
}

TEST(SegmentFrame, MarksBoxesAtTheImageBorder) {
  const Scene scene =
      Make({{0, {-0.4, -0.3, 0}, {0.4, 0.3, 0.6}}}, {0.8, -2.2, 1.4}, {1.0, 0, 0.3});
  const auto segments = SegmentsOf(scene, {"cabinet"});
  EXPECT_TRUE(segments[0].touches_border);
}

TEST(SegmentFrame, GivesReasonsForWhatItCannotUse) {
  const Scene scene = Make({{0, {-0.4, -0.3, 0}, {0.4, 0.3, 0.6}}}, {0.8, -2.2, 1.4}, {0, 0, 0.3});
  Frame frame = scene.view.frame;
  frame.depth_m = DepthImage(320, 240);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto detections = Truth(scene.view, {"cabinet"});
  detections.resize(4, detections[0]);
  detections[1].box_px = {nan, nan, nan, nan};
  detections[2].box_px = {-1e30, -1e30, -1e29, -1e29};
  detections[3].mask = Mask(7, 5, 1);
  const PinholeCamera camera = SmallCamera();
  const auto segments = SegmentFrame({frame, camera, scene.ground, detections}, Classes(), {});
  ASSERT_EQ(segments.size(), 4U);
  for (const Segment& segment : segments) {
    EXPECT_FALSE(segment.usable);
    EXPECT_FALSE(segment.reason.empty());
    EXPECT_EQ(segment.num_points, 0);
  }
}

TEST(SegmentFrame, BearsEmptyImagesAndNoDetections) {
  const Frame empty;
  const PinholeCamera camera = SmallCamera();
  EXPECT_TRUE(SegmentFrame({empty, camera, std::nullopt, {}}, Classes(), {}).empty());
  const std::vector<Detection> one(1);
  const PinholeCamera no_camera;
  const auto segments = SegmentFrame({empty, no_camera, std::nullopt, one}, Classes(), {});
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_FALSE(segments[0].usable);
}

}  // namespace
}  // namespace deepslam::segment
