#include "deepslam/observe/object_views.h"

#include <set>

#include <gmock/gmock.h>

#include "support/box_world.h"

namespace deepslam::observe {
namespace {

using testing::SizeIs;
using namespace testing_support;  // NOLINT

struct World {
  BoxWorldSource source;
  std::vector<Segment> segments;
  ObjectTrack track;
};

// One box, seen from everywhere; the track has all its detections.
World Make(int count, double step_deg) {
  World world{
      {{{0, {-0.3, -0.2, 0}, {0.3, 0.2, 0.5}}}, Orbit({0, 0, 0.3}, 2.0, 1.2, 0, step_deg, count)},
      {},
      {}};
  world.track.id = {4};
  for (int f = 0; f < count; ++f) {
    const BoxView view = world.source.View({f});
    const auto detection = DetectTruth(view, 0, "cabinet");
    Segment segment;
    segment.detection = {100 + f};
    segment.frame = {f};
    segment.score = 0.8;
    segment.box_px = detection->box_px;
    Mask mask(320, 240);
    for (int v = 0; v < 240; ++v) {
      for (int u = 0; u < 320; ++u) {
        if (view.object(u, v) != 0) continue;
        mask(u, v) = 1;
        ++segment.num_points;
        segment.extent_camera.Extend(SmallCamera().Unproject(u, v, view.frame.depth_m(u, v)));
      }
    }
    segment.mask = mask;
    segment.usable = true;
    world.segments.push_back(std::move(segment));
    world.track.members.push_back({{100 + f}, {f}, 1, 0.0, "vote"});
  }
  return world;
}

std::map<ObjectId, std::vector<ObjectView>> Collect(const World& world,
                                                    const Ground& ground,
                                                    const ViewOptions& options = {}) {
  SilentProgress progress;
  const std::vector<ObjectTrack> tracks = {world.track};
  auto result = CollectObjectViews(
      world.source, world.source.TrueOdometry(), ground, world.segments, tracks, options, progress);
  EXPECT_TRUE(result.ok());
  return *std::move(result);
}

TEST(CollectObjectViews, CropsShowTheSamePointsAsTheWholeImage) {
  const World world = Make(3, 30);
  const auto views = Collect(world, Ground());
  ASSERT_THAT(views.at({4}), SizeIs(3));
  for (const ObjectView& view : views.at({4})) {
    const BoxView whole = world.source.View(view.frame);
    int num_object = 0;
    for (int v = 0; v < view.camera.height; ++v) {
      for (int u = 0; u < view.camera.width; ++u) {
        ASSERT_EQ(view.depth_crop_m(u, v), whole.frame.depth_m(u + view.u0, v + view.v0));
        ASSERT_EQ(view.colour_crop(u, v), whole.frame.colour(u + view.u0, v + view.v0));
        num_object += view.mask_crop(u, v);
        // The crop's camera sees the pixel where the whole camera does.
        const Eigen::Vector3d a = view.camera.Unproject(u, v, 1.0);
        const Eigen::Vector3d b = SmallCamera().Unproject(u + view.u0, v + view.v0, 1.0);
        ASSERT_LT((a - b).norm(), 1e-12);
      }
    }
    const auto& segment = world.segments[static_cast<std::size_t>(view.frame.value)];
    EXPECT_EQ(num_object, segment.num_points) << "the crop must hold the whole object";
    EXPECT_GT(view.camera.width, segment.box_px.width_px() + 4) << "and space around it";
    EXPECT_EQ(view.detection, segment.detection);
  }
}

TEST(CollectObjectViews, TellsWhatTheUserSaysSetsThePicturesUpright) {
  const World world = Make(3, 30);
  for (const QuarterTurn turn : {QuarterTurn::kNone, QuarterTurn::kHalf}) {
    Ground ground;
    ground.upright = turn;
    const auto views = Collect(world, ground);
    ASSERT_THAT(views.at({4}), SizeIs(3));
    for (const ObjectView& view : views.at({4})) EXPECT_EQ(view.upright, turn);
  }
}

TEST(CutObjectViews, WithoutColourGivesTheSameDepthAndObject) {
  const World world = Make(5, 30);
  const std::vector<ObjectTrack> tracks = {world.track};
  const Odometry odometry = world.source.TrueOdometry();
  const ViewPlan plan = PlanObjectViews(odometry, world.segments, tracks, {});
  SilentProgress progress;
  const auto cut = [&](ViewContent content) {
    return *CutObjectViews(world.source, odometry, Ground(), plan, content, progress);
  };
  const std::vector<ObjectView> whole = cut(ViewContent::kColourAndDepth).at({4});
  const std::vector<ObjectView> depth = cut(ViewContent::kDepth).at({4});
  ASSERT_EQ(whole.size(), 5U);
  ASSERT_EQ(depth.size(), whole.size());
  std::size_t num_bytes = 0;
  for (std::size_t n = 0; n < whole.size(); ++n) {
    EXPECT_EQ(depth[n].frame, whole[n].frame);
    EXPECT_EQ(depth[n].depth_crop_m, whole[n].depth_crop_m);
    EXPECT_EQ(depth[n].mask_crop, whole[n].mask_crop);
    EXPECT_TRUE(depth[n].colour_crop.empty());
    EXPECT_FALSE(whole[n].colour_crop.empty());
    num_bytes += whole[n].colour_crop.size() * (sizeof(Rgb8) + sizeof(float) + 1);
  }
  EXPECT_EQ(NumBytes(plan.at({4}), SmallCamera()), num_bytes);
}

TEST(CollectObjectViews, SpreadsTheViewsItChooses) {
  const World world = Make(36, 10);
  ViewOptions options;
  options.max_views = 6;
  options.spread_deg = 40;
  const auto views = Collect(world, Ground(), options);
  ASSERT_THAT(views.at({4}), SizeIs(6));
  int before = -36;
  for (const ObjectView& view : views.at({4})) {
    EXPECT_GE(view.frame.value - before, 2) << "two views from one side";
    before = view.frame.value;
  }
  // No quarter of the circle goes without a view.
  std::set<int> quarters;
  for (const ObjectView& view : views.at({4})) quarters.insert(view.frame.value / 9);
  EXPECT_THAT(quarters, SizeIs(4));
}

TEST(CollectObjectViews, PrefersViewsThatKeepTheMargin) {
  World world = Make(2, 1);
  world.segments[0].touches_border = true;
  ViewOptions options;
  options.max_views = 1;
  const auto views = Collect(world, Ground(), options);
  ASSERT_THAT(views.at({4}), SizeIs(1));
  EXPECT_EQ(views.at({4})[0].frame, FrameIdx{1});
}

TEST(CollectObjectViews, TakesTheGroundOfTheFrameElseOfTheWorld) {
  const World world = Make(2, 20);
  EXPECT_FALSE(Collect(world, Ground()).at({4})[0].ground_camera.has_value());
  Ground ground;
  ground.plane_world = Plane{Eigen::Vector3d::UnitZ(), 0};
  GroundObservation observed;
  observed.keyframe = {1};
  observed.plane_camera = Plane{Eigen::Vector3d::UnitX(), 7};
  ground.observations.push_back(observed);
  const auto views = Collect(world, ground);
  const ObjectView& carried = views.at({4})[0];
  ASSERT_TRUE(carried.ground_camera.has_value());
  EXPECT_NEAR(carried.ground_camera->d_m, 1.2, 1e-9) << "height of the camera, m";
  EXPECT_EQ(*views.at({4})[1].ground_camera, observed.plane_camera);
}

TEST(CollectObjectViews, LeavesOutWhatCannotBeRead) {
  World world = Make(4, 10);
  world.source.broken = {0};
  world.segments[1].mask = Mask(2, 2);
  world.segments[2].frame = {999};
  world.track.members.push_back({{12345}, {3}, 0, 0, "vote"});
  const auto views = Collect(world, Ground());
  ASSERT_THAT(views.at({4}), SizeIs(1));
  EXPECT_EQ(views.at({4})[0].frame, FrameIdx{3});
}

}  // namespace
}  // namespace deepslam::observe
