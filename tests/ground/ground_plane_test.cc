#include "deepslam/ground/ground_plane.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <Eigen/Cholesky>

#include "alignment/box_world.h"
#include "deepslam/core/parallel.h"
#include "deepslam/core/random.h"
#include "deepslam/dataset/memory_frame_source.h"

namespace deepslam::ground {
namespace {

using dataset::MemoryFrameSource;
using testing_support::BoxWorld;
using testing_support::kSmallCamera;
using testing_support::LookAt;
using testing_support::RenderFrame;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
// Depth noise of about 1 cm at these distances over some thousand pixels.
constexpr double kToleranceM = 0.01;
constexpr double kToleranceDeg = 0.5;

// Every frame a keyframe with its true pose, in the tracking world of the first.
struct TrueCapture {
  std::vector<Frame> frames;
  Odometry odometry;
  Pose3 world_from_first;  // world: z up, floor z = 0
};

TrueCapture Capture(const BoxWorld& world, const std::vector<Pose3>& poses, double noise = 1.0) {
  TrueCapture capture;
  capture.world_from_first = poses.front();
  for (std::size_t k = 0; k < poses.size(); ++k) {
    capture.frames.push_back(RenderFrame(world, poses[k], noise, k));
    TrackedFrame frame;
    frame.frame = FrameIdx{static_cast<std::int32_t>(k)};
    frame.keyframe = frame.frame;
    frame.world_from_camera = poses.front().Inverse() * poses[k];
    capture.odometry.frames.push_back(frame);
    capture.odometry.keyframes.push_back(frame.frame);
  }
  return capture;
}

Ground Estimate(const TrueCapture& capture, const GroundOptions& options = {}) {
  const MemoryFrameSource source(kSmallCamera, capture.frames);
  SilentProgress progress;
  Result<Ground> ground = EstimateGround(source, capture.odometry, options, progress);
  EXPECT_TRUE(ground.ok());
  return std::move(ground).value();
}

void ExpectFloor(const TrueCapture& capture,
                 const Ground& ground,
                 double tolerance_m = kToleranceM,
                 double tolerance_deg = kToleranceDeg) {
  ASSERT_TRUE(ground.plane_world.has_value());
  const Plane plane = Transformed(capture.world_from_first, *ground.plane_world);
  EXPECT_LT(std::acos(std::min(1.0, plane.normal.z())) * kDegPerRad, tolerance_deg);
  // Height of the plane under the first camera.
  EXPECT_NEAR(plane.SignedDistance(capture.world_from_first.translation_m),
              capture.world_from_first.translation_m.z(),
              tolerance_m);
  for (const GroundObservation& seen : ground.observations) {
    const Pose3 world_from_camera =
        capture.world_from_first * capture.odometry.at(seen.keyframe).world_from_camera;
    EXPECT_NEAR(seen.plane_camera.d_m, world_from_camera.translation_m.z(), 2 * tolerance_m);
    EXPECT_EQ(seen.information.llt().info(), Eigen::Success);
    EXPECT_GT(seen.num_inliers, 0);
  }
}

std::vector<Pose3> Pan(const Eigen::Vector3d& eye,
                       double target_height,
                       double roll_rad = 0,
                       int num_frames = 8) {
  std::vector<Pose3> poses;
  for (int k = 0; k < num_frames; ++k) {
    const double angle = -0.4 + 0.1 * k;
    poses.push_back(LookAt(
        eye,
        eye + Eigen::Vector3d(2 * std::cos(angle), 2 * std::sin(angle), target_height - eye.z()),
        roll_rad));
  }
  return poses;
}

TEST(EstimateGround, FindsTheFloorOfAFurnishedRoom) {
  const TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3));
  const Ground ground = Estimate(capture);
  ExpectFloor(capture, ground);
  EXPECT_EQ(ground.observations.size(), capture.frames.size());
}

TEST(EstimateGround, TakesATiltedCamera) {
  const TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.2, 0.35));
  ExpectFloor(capture, Estimate(capture));
}

// Looking about in the middle of the room, through `range_deg`.
std::vector<Pose3> LookAbout(double target_height, double roll_rad, double range_deg) {
  constexpr int kFrames = 10;
  std::vector<Pose3> poses;
  for (int k = 0; k < kFrames; ++k) {
    const double angle = range_deg / kDegPerRad * k / kFrames;
    const Eigen::Vector3d eye(0.1 * k - 1, -0.2, 1.4);
    poses.push_back(
        LookAt(eye,
               {eye.x() + 2 * std::cos(angle), eye.y() + 2 * std::sin(angle), target_height},
               roll_rad));
  }
  return poses;
}

class HeldCamera : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] static double RollRad() { return GetParam() / kDegPerRad; }
};

TEST_P(HeldCamera, FindsTheFloorHoweverItIsHeld) {
  const TrueCapture capture = Capture(BoxWorld::Furnished(), LookAbout(0.3, RollRad(), 200));
  const Ground ground = Estimate(capture);
  ExpectFloor(capture, ground);
  EXPECT_EQ(ground.observations.size(), capture.frames.size());
}

// In a passage the walls are beside the camera all the way, as near as a floor.
TEST_P(HeldCamera, FindsTheFloorOfAPassage) {
  BoxWorld passage;
  passage.room = {{-6, -0.9, 0}, {6, 0.9, 2.4}};
  passage.boxes = {{{1, -0.9, 0}, {1.6, -0.5, 0.8}}, {{-2, 0.4, 0}, {-1.2, 0.9, 0.5}}};
  std::vector<Pose3> poses;
  for (int k = 0; k < 10; ++k)
    poses.push_back(LookAt({-4 + 0.5 * k, 0.1, 1.4}, {0.5 * k, 0, 0.2}, RollRad()));
  for (int k = 0; k < 4; ++k)
    poses.push_back(LookAt({1.5, 0, 1.4}, {1.5 + k - 2.0, 0.5 * k, 0.2}, RollRad()));
  const TrueCapture capture = Capture(passage, poses);
  ExpectFloor(capture, Estimate(capture), 0.02);
}

TEST_P(HeldCamera, TakesNoWallForTheFloorWhereNoFloorIsInView) {
  BoxWorld high;
  high.room = {{-2, -2, -4}, {2, 2, 7}};
  for (const double range_deg : {120.0, 300.0}) {
    const TrueCapture capture = Capture(high, LookAbout(1.5, RollRad(), range_deg));
    EXPECT_FALSE(Estimate(capture).plane_world.has_value()) << range_deg;
  }
}

TEST_P(HeldCamera, IsWhatTheUserSays) {
  // Too little is seen from too few sides to tell.
  const TrueCapture capture = Capture(BoxWorld::Furnished(), LookAbout(0.3, RollRad(), 30));
  GroundOptions options;
  const int quarters = (GetParam() + 405) / 90 % 4;
  options.upright_deg = std::to_string(quarters * 90);
  const Ground ground = Estimate(capture, options);
  ExpectFloor(capture, ground);
  EXPECT_EQ(ground.upright, static_cast<QuarterTurn>(quarters)) << "for where there is no floor";
  EXPECT_FALSE(Estimate(capture).upright.has_value());
}

INSTANTIATE_TEST_SUITE_P(Rolls, HeldCamera, testing::Values(0, 90, 180, -90, 75, -110));

TEST(EstimateGround, ATableTopDoesNotPoseAsTheFloor) {
  BoxWorld world;
  world.boxes = {{{-1.4, -1.2, 0.70}, {0.9, 1.2, 0.74}}};
  // Most frames see nothing but the top and walls above it; the last ones look past it to the
  // floor.
  std::vector<Pose3> poses;
  for (int k = 0; k < 9; ++k) poses.push_back(LookAt({-1.5, 0.05 * k - 0.2, 1.5}, {-0.3, 0, 0.74}));
  for (int k = 0; k < 3; ++k)
    poses.push_back(LookAt({-1.5 + 0.3 * k, 1.0, 1.5}, {0.6 + 0.3 * k, 1.8, 0.0}));
  const TrueCapture capture = Capture(world, poses);
  ExpectFloor(capture, Estimate(capture), 0.02, 1.0);
}

TEST(EstimateGround, CarriesAFloorThatIsSeenLateBackToTheStart) {
  std::vector<Pose3> poses = Pan({-1.7, 0, 1.4}, 1.9, 0, 5);  // walls only
  const std::vector<Pose3> down = Pan({-1.7, 0, 1.4}, 0.2, 0, 4);
  poses.insert(poses.end(), down.begin(), down.end());
  const TrueCapture capture = Capture(BoxWorld{}, poses);
  const Ground ground = Estimate(capture);
  ExpectFloor(capture, ground);
  EXPECT_GE(ground.observations.front().keyframe, FrameIdx{4});
}

// A table in the room; views of it without floor, of walls alone, and past it to the floor.
struct TableRoom {
  BoxWorld world;

  explicit TableRoom(double height_m) {
    world.boxes = {{{-1.4, -1.2, height_m - 0.04}, {0.9, 1.2, height_m}}};
  }

  static Pose3 Floor(int k) {
    const double along = 0.02 * (k % 20);
    return LookAt({-1.5 + along, 1.0, 1.5}, {0.6 + along, 1.8, 0.0});
  }
  [[nodiscard]] Pose3 Top(int k) const {
    const double top_m = world.boxes[0].max.z();
    return LookAt({-0.6, 0.02 * (k % 20) - 0.2, top_m + 0.6}, {0.2, 0, top_m});
  }
  static Pose3 Walls(int k) { return LookAt({-1.5, 0.02 * (k % 20) - 0.2, 1.5}, {2, 0, 1.9}); }
};

// Minutes of keyframes without floor, the table in every third of them, between two views of it.
struct LongWay {
  static constexpr int kWithFloor = 20;
  static constexpr int kWithout = 300;
  std::vector<Pose3> poses;

  explicit LongWay(const TableRoom& room) {
    for (int k = 0; k < kWithFloor; ++k) poses.push_back(TableRoom::Floor(k));
    for (int k = 0; k < kWithout; ++k)
      poses.push_back(k % 3 == 0 ? room.Top(k) : TableRoom::Walls(k));
    for (int k = 0; k < kWithFloor; ++k)
      poses.push_back(k % 3 == 1 ? room.Top(k) : TableRoom::Floor(k));
  }

  [[nodiscard]] bool SeesFloor(FrameIdx frame) const {
    const int behind = frame.value - kWithFloor - kWithout;
    return frame.value < kWithFloor || (behind >= 0 && behind % 3 != 1);
  }
};

// A random walk towards `end`, which it does not exceed.
std::vector<double> Walk(double end, std::size_t count, Random& random) {
  std::vector<double> values(count, 0.0);
  const double step = std::abs(end) / std::sqrt(static_cast<double>(count));
  for (std::size_t k = 1; k < count; ++k) values[k] = values[k - 1] + step * random.Normal();
  const double correction = (end - values.back()) / static_cast<double>(count - 1);
  double largest = std::abs(end);
  for (std::size_t k = 0; k < count; ++k) {
    values[k] += correction * static_cast<double>(k);
    largest = std::max(largest, std::abs(values[k]));
  }
  for (double& value : values) value *= largest > 0 ? std::abs(end) / largest : 0;
  return values;
}

// The same capture as tracked, with these errors of height and tilt.
TrueCapture Drifted(TrueCapture capture,
                    const std::vector<double>& heights_m,
                    const std::vector<double>& tilts_deg) {
  const Pose3 first_from_world = capture.world_from_first.Inverse();
  for (std::size_t k = 0; k < heights_m.size(); ++k) {
    Pose3& tracked = capture.odometry.frames[k].world_from_camera;
    Pose3 in_room = capture.world_from_first * tracked;
    const Eigen::AngleAxisd tilt(tilts_deg[k] / kDegPerRad, Eigen::Vector3d::UnitX());
    in_room.rotation = (tilt * in_room.rotation).normalized();
    in_room.translation_m.z() += heights_m[k];
    tracked = first_from_world * in_room;
  }
  return capture;
}

TrueCapture Drifted(TrueCapture capture, double height_m, double tilt_deg, std::uint64_t seed) {
  Random random(seed, "drift", 0);
  const std::size_t count = capture.odometry.frames.size();
  const std::vector<double> heights_m = Walk(height_m, count, random);
  return Drifted(std::move(capture), heights_m, Walk(tilt_deg, count, random));
}

class AfterALongWay : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(AfterALongWay, TheFloorIsFoundAgainAndNotTheTable) {
  const auto [height_m, tilt_deg] = GetParam();
  const TableRoom room(0.74);
  const LongWay way(room);
  const TrueCapture truth = Capture(room.world, way.poses);
  for (const std::uint64_t seed : {1, 2}) {
    const Ground ground = Estimate(Drifted(truth, height_m, tilt_deg, seed));
    int num_behind = 0;
    for (const GroundObservation& seen : ground.observations) {
      EXPECT_TRUE(way.SeesFloor(seen.keyframe)) << "keyframe " << seen.keyframe;
      EXPECT_NEAR(seen.plane_camera.d_m, 1.5, 0.03) << "keyframe " << seen.keyframe;
      num_behind += seen.keyframe.value >= LongWay::kWithFloor ? 1 : 0;
    }
    EXPECT_EQ(num_behind, 13) << "of the floor behind the long way, seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Drift,
                         AfterALongWay,
                         testing::Values(std::pair(0.0, 0.0),
                                         std::pair(0.29, 3.0),
                                         std::pair(-0.29, -3.0),
                                         std::pair(0.15, -4.0)));

TEST(EstimateGround, ALowTableIsNotTheFloorThoughNothingElseIsInViewForLong) {
  const TableRoom room(0.42);
  const LongWay way(room);
  const Ground ground = Estimate(Drifted(Capture(room.world, way.poses), -0.08, 1.0, 1));
  EXPECT_GE(ground.observations.size(), 30U);
  for (const GroundObservation& seen : ground.observations)
    EXPECT_NEAR(seen.plane_camera.d_m, 1.5, 0.03) << "keyframe " << seen.keyframe;
}

// The search starts from the lowest floor, so that drift alone carries the plane away from tables;
// having followed the floor up by 28 cm and lost it again it is 14 cm below a table.
TEST(EstimateGround, ALowTableWithFloorBesideItIsNotTheFloorWhereDriftHasReachedIt) {
  const TableRoom room(0.42);
  std::vector<Pose3> poses;
  std::vector<double> heights_m;
  std::vector<bool> is_floor;
  const auto add = [&](const Pose3& pose, double height_m, bool floor) {
    poses.push_back(pose);
    heights_m.push_back(height_m);
    is_floor.push_back(floor);
  };
  const auto table_and_floor = [&] {
    for (int k = 0; k < 18; ++k) add(k % 3 == 1 ? TableRoom::Floor(k) : room.Top(k), 0, k % 3 == 1);
  };
  table_and_floor();
  for (int k = 0; k < 150; ++k) add(TableRoom::Walls(k), 0.28 * k / 150, false);
  for (int k = 0; k < 10; ++k) add(TableRoom::Floor(k), 0.28, true);
  for (int k = 0; k < 150; ++k) add(TableRoom::Walls(k), 0.28 - 0.28 * k / 150, false);
  table_and_floor();
  const TrueCapture truth = Capture(room.world, poses);
  const Ground ground =
      Estimate(Drifted(truth, heights_m, std::vector<double>(heights_m.size(), 0.0)));
  EXPECT_EQ(ground.observations.size(), 22U);
  for (const GroundObservation& seen : ground.observations) {
    EXPECT_TRUE(is_floor[static_cast<std::size_t>(seen.keyframe.value)]) << seen.keyframe;
    EXPECT_NEAR(seen.plane_camera.d_m, 1.5, 0.03) << seen.keyframe;
  }
}

class Warnings final : public Progress {
 public:
  std::vector<std::string> texts;
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view message) override { texts.emplace_back(message); }
  [[nodiscard]] bool StopRequested() const override { return false; }
};

std::vector<std::string> WarningsOf(const TrueCapture& capture) {
  const MemoryFrameSource source(kSmallCamera, capture.frames);
  Warnings warnings;
  EXPECT_TRUE(EstimateGround(source, capture.odometry, {}, warnings).ok());
  return warnings.texts;
}

TEST_P(HeldCamera, NothingIsSaidOfGroundsThatWereNotTaken) {
  EXPECT_THAT(WarningsOf(Capture(BoxWorld::Furnished(), LookAbout(0.3, RollRad(), 200))),
              testing::IsEmpty());
}

TEST(EstimateGround, SaysSoWhereATableTopIsAllThereIs) {
  const TableRoom room(0.74);
  std::vector<Pose3> poses;
  for (int k = 0; k < 12; ++k) poses.push_back(room.Top(k));
  EXPECT_THAT(WarningsOf(Capture(room.world, poses)),
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("0.60 m below the camera"),
                                                  testing::HasSubstr("overrides.yaml"))));
  for (int k = 0; k < 6; ++k) poses.push_back(TableRoom::Floor(k));
  EXPECT_THAT(WarningsOf(Capture(room.world, poses)), testing::IsEmpty());
}

TEST(EstimateGround, SmallPatchesOfFloorTellThatATableTopIsNone) {
  // The table ends before the wall: a strip of floor is seen beyond its edge.
  BoxWorld world;
  world.boxes = {{{-1.4, -2.0, 0.70}, {0.62, 2.0, 0.74}}};
  std::vector<Pose3> poses;
  for (int k = 0; k < 10; ++k)
    poses.push_back(LookAt({-0.6, 0.04 * k - 0.2, 1.5}, {1.3, 0.02 * k, 0.74}));
  const TrueCapture capture = Capture(world, poses);
  ExpectFloor(capture, Estimate(capture), 0.04, 1.0);
  EXPECT_THAT(WarningsOf(capture), testing::ElementsAre(testing::HasSubstr("little floor")));
}

// The second capture begins at the last pose of the first, as tracking has it: lost there, and
// joined by a composed edge.
TrueCapture Joined(TrueCapture first, const TrueCapture& second) {
  const FrameIdx last = first.odometry.keyframes.back();
  const Pose3 start = first.odometry.frames.back().world_from_camera;
  const auto add_edge = [&](FrameIdx i, FrameIdx j, bool composed) {
    RelativePose edge;
    edge.i = i;
    edge.j = j;
    edge.composed = composed;
    first.odometry.edges.push_back(edge);
  };
  for (std::int32_t k = 1; k <= last.value; ++k) add_edge(FrameIdx{k - 1}, FrameIdx{k}, false);
  for (TrackedFrame frame : second.odometry.frames) {
    const bool is_start = frame.frame.value == 0;
    frame.frame.value += last.value + 1;
    frame.keyframe = frame.frame;
    frame.world_from_camera = start * frame.world_from_camera;
    if (is_start) frame.status = TrackingStatus::kLost;
    add_edge(FrameIdx{frame.frame.value - 1}, frame.frame, is_start);
    first.odometry.frames.push_back(frame);
    first.odometry.keyframes.push_back(frame.frame);
  }
  first.frames.insert(first.frames.end(), second.frames.begin(), second.frames.end());
  return first;
}

TEST(EstimateGround, IsNotCarriedAcrossAJoinThatNobodyMeasured) {
  const TrueCapture high = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.5}, 0.3, 0, 6));
  // Another height and inclination, of which the join knows nothing.
  const TrueCapture low = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.1}, 0.7, 0, 6));
  const TrueCapture both = Joined(high, low);
  const Ground ground = Estimate(both);
  ASSERT_EQ(ground.observations.size(), 12U);
  for (const GroundObservation& seen : ground.observations)
    EXPECT_NEAR(seen.plane_camera.d_m, seen.keyframe.value < 6 ? 1.5 : 1.1, 0.02);
  ASSERT_EQ(ground.apart.size(), 1U);
  EXPECT_EQ(ground.apart[0].first, FrameIdx{6});
  EXPECT_EQ(ground.apart[0].end, FrameIdx{12});
  // Frames that did not see it themselves have their own part's.
  Ground unseen = ground;
  unseen.observations.clear();
  for (const std::int32_t k : {2, 8}) {
    const auto plane =
        GroundInCamera(unseen, FrameIdx{k}, both.odometry.at(FrameIdx{k}).world_from_camera);
    ASSERT_TRUE(plane.has_value());
    EXPECT_NEAR(plane->d_m, k < 6 ? 1.5 : 1.1, 0.02);
  }
}

TEST(EstimateGround, APartThatSawNoFloorHasNone) {
  const TrueCapture high = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.5}, 0.3, 0, 6));
  const TrueCapture walls = Capture(BoxWorld{}, Pan({-1.7, 0, 1.4}, 1.9, 0, 5));
  const TrueCapture both = Joined(high, walls);
  const Ground ground = Estimate(both);
  EXPECT_EQ(ground.observations.size(), 6U);
  const auto in_camera = [&](int k) {
    return GroundInCamera(ground, FrameIdx{k}, both.odometry.at(FrameIdx{k}).world_from_camera);
  };
  EXPECT_TRUE(in_camera(3).has_value());
  EXPECT_FALSE(in_camera(8).has_value());
  // A measurement across the join carries it over.
  TrueCapture measured = both;
  measured.odometry.edges[5].composed = false;
  EXPECT_TRUE(Estimate(measured).apart.empty());
}

TEST(EstimateGround, NearerAndFullerViewsKnowMore) {
  const TrueCapture capture = Capture(
      BoxWorld{}, {LookAt({-1.7, 0, 1.2}, {-0.5, 0, 0}), LookAt({-1.7, 0, 1.2}, {2, 0, 1.1})});
  const Ground ground = Estimate(capture);
  ASSERT_EQ(ground.observations.size(), 2U);
  EXPECT_GT(ground.observations[0].information(2, 2), ground.observations[1].information(2, 2));
}

TEST(EstimateGround, NoGroundIsNoError) {
  // A wall, no depth at all, and a capture without keyframes.
  const TrueCapture wall = Capture(BoxWorld::Wall(), {Pose3{}, Pose3{}});
  EXPECT_FALSE(Estimate(wall).plane_world.has_value());
  TrueCapture dark = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3, 0, 2));
  for (Frame& frame : dark.frames) std::ranges::fill(frame.depth_m, 0.0F);
  EXPECT_FALSE(Estimate(dark).plane_world.has_value());
  TrueCapture unread = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3, 0, 2));
  for (Frame& frame : unread.frames) frame = Frame{};
  EXPECT_FALSE(Estimate(unread).plane_world.has_value());
  EXPECT_FALSE(Estimate(TrueCapture{}).plane_world.has_value());
}

TEST(EstimateGround, OneBadFrameDoesNotHarmTheOthers) {
  TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3));
  capture.frames[2] = Frame{};
  for (float& z : capture.frames[4].depth_m) z = std::nanf("");
  const Ground ground = Estimate(capture);
  ExpectFloor(capture, ground);
  EXPECT_EQ(ground.observations.size(), capture.frames.size() - 2);
}

TEST(EstimateGround, IsByteEqualForAnyNumberOfThreads) {
  const TrueCapture capture = Capture(BoxWorld::Furnished(), Pan({-1.7, 0, 1.4}, 0.3));
  const auto estimate = [&](int num_threads) {
    const ThreadLimit limit(num_threads);
    return Estimate(capture);
  };
  const Ground one = estimate(1);
  const Ground two = estimate(2);
  EXPECT_EQ(*one.plane_world, *two.plane_world);
  ASSERT_EQ(one.observations.size(), two.observations.size());
  for (std::size_t k = 0; k < one.observations.size(); ++k) {
    EXPECT_EQ(one.observations[k].plane_camera, two.observations[k].plane_camera);
    EXPECT_EQ(one.observations[k].information, two.observations[k].information);
  }
}

}  // namespace
}  // namespace deepslam::ground
