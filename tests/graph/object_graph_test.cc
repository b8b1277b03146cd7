#include "deepslam/graph/object_graph.h"

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "deepslam/geometry/upright.h"
#include "deepslam/graph/g2o.h"
#include "deepslam/graph/gravity_world.h"
#include "graph/expect_truth.h"
#include "graph/synthetic_graph.h"
#include "support/pose_matchers.h"

namespace deepslam::graph {
namespace {

using ::deepslam::testing_support::PoseNear;
using testing_support::ExpectTruth;
using testing_support::MakeWorld;
using testing_support::Noise;
using testing_support::TrajectoryError;
using testing_support::World;

OptimizedMap Optimize(const World& world, const GraphOptions& options = {}) {
  Result<OptimizedMap> result = OptimizeGraph(
      world.odometry, world.ground, world.map, world.loops, options, {world.feet, {}});
  EXPECT_TRUE(result.ok());
  return *std::move(result);
}

double Energy(const OptimizedMap& map, bool after) {
  double sum = 0;
  for (const EnergyTerm& term : map.summary.terms) sum += after ? term.after : term.before;
  return sum;
}

const Noise kDrift{0.004, 0.003, 0.02, 0.02};

double ErrorBefore(const World& world) {
  // The tracking world is the first camera.
  const Pose3 gravity = world.world_from_camera.front();
  double sum = 0;
  for (std::size_t k = 0; k < world.odometry.frames.size(); ++k) {
    sum += (gravity * world.odometry.frames[k].world_from_camera.translation_m -
            world.world_from_camera[k].translation_m)
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(world.odometry.frames.size()));
}

TEST(OptimizeGraph, ResidualIsZeroAtTheTruth) {
  const World world = MakeWorld(60, 5, 2, {});
  const OptimizedMap map = Optimize(world);
  EXPECT_LT(Energy(map, false), 1e-12);
  EXPECT_TRUE(map.summary.converged) << map.summary.message;
  EXPECT_EQ(map.summary.ground_observed, 1.0);
  ExpectTruth(map, world);
}

TEST(OptimizeGraph, ADriftedLoopComesHome) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const World world = MakeWorld(80, 5, 2, kDrift, seed);
    const OptimizedMap map = Optimize(world);
    EXPECT_TRUE(map.summary.converged) << map.summary.message;
    EXPECT_LT(Energy(map, true), Energy(map, false));
    EXPECT_LT(TrajectoryError(map.frames, world), 0.5 * ErrorBefore(world)) << "seed " << seed;
  }
}

// Four walls round the walk, as keyframes that look at them see them: every third keyframe at most.
WallViews WallsAround(const World& world) {
  WallViews walls;
  const Pose3 tracking_from_world = world.world_from_camera.front().Inverse();
  for (const auto& [normal, d_m] : {std::pair(Eigen::Vector3d(1, 0, 0), 5.0),
                                    std::pair(Eigen::Vector3d(-1, 0, 0), 5.0),
                                    std::pair(Eigen::Vector3d(0, 1, 0), 2.0),
                                    std::pair(Eigen::Vector3d(0, -1, 0), 8.0)}) {
    const Plane wall{normal, d_m};
    for (std::size_t k = 0; k < world.world_from_camera.size(); ++k) {
      const Pose3& camera = world.world_from_camera[k];
      const bool is_seen = (camera.rotation * Eigen::Vector3d::UnitZ()).dot(normal) < -0.7;
      if (!is_seen) continue;
      WallView view;
      view.keyframe = FrameIdx{static_cast<int>(k)};
      view.wall = static_cast<int>(walls.planes.size());
      view.plane_camera = Transformed(camera.Inverse(), wall);
      view.information = 1e6 * Eigen::Matrix3d::Identity();
      walls.views.push_back(view);
    }
    walls.planes.push_back(Transformed(tracking_from_world, wall));
  }
  return walls;
}

// Of several walks together: what single views are good for is half a degree.
TEST(OptimizeGraph, WallsHoldThePathWhereTheyAreAskedTo) {
  GraphOptions options;
  double without_m = 0;
  double with_m = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const World world = MakeWorld(80, 0, 1, kDrift, seed);
    const WallViews walls = WallsAround(world);
    ASSERT_GT(walls.views.size(), 20U);
    for (const bool use_walls : {false, true}) {
      options.use_walls = use_walls;
      const Result<OptimizedMap> map =
          OptimizeGraph(world.odometry, world.ground, world.map, world.loops, options, {{}, walls});
      ASSERT_TRUE(map.ok());
      (use_walls ? with_m : without_m) += TrajectoryError(map->frames, world);
      EXPECT_EQ(map->summary.terms.back().name == "r_pw", use_walls);
    }
  }
  EXPECT_LT(with_m, 0.5 * without_m) << without_m;
}

// Bad views are left out and counted; a wall that one keyframe saw says nothing.
TEST(OptimizeGraph, WallsThatSayNothingChangeNothing) {
  const World world = MakeWorld(30, 0, 1, kDrift);
  GraphOptions options;
  const OptimizedMap without = Optimize(world, options);
  options.use_walls = true;
  WallViews walls;
  walls.planes = {Plane{Eigen::Vector3d::UnitX(), 3}, Plane{Eigen::Vector3d::Zero(), 1}};
  WallView once;
  once.keyframe = FrameIdx{3};
  once.plane_camera = walls.planes[0];
  WallView nowhere = once;
  nowhere.keyframe = FrameIdx{500};
  WallView of_none = once;
  of_none.wall = 7;
  WallView not_finite = once;
  not_finite.plane_camera.d_m = std::numeric_limits<double>::quiet_NaN();
  walls.views = {once, nowhere, of_none, not_finite};
  const Result<OptimizedMap> map =
      OptimizeGraph(world.odometry, world.ground, world.map, world.loops, options, {{}, walls});
  ASSERT_TRUE(map.ok());
  EXPECT_THAT(map->summary.message, testing::HasSubstr("3 unusable edges"));
  for (std::size_t k = 0; k < map->frames.size(); ++k) {
    EXPECT_THAT(map->frames[k].world_from_camera,
                PoseNear(without.frames[k].world_from_camera, 1e-9, 1e-9));
  }
}

TEST(OptimizeGraph, ErrorVanishesWithTheNoise) {
  double previous = std::numeric_limits<double>::infinity();
  for (const double share : {1.0, 0.1, 0.01}) {
    const World world = MakeWorld(60,
                                  5,
                                  2,
                                  {share * kDrift.translation_m,
                                   share * kDrift.rotation_rad,
                                   share * kDrift.object_m,
                                   share * kDrift.object_rad});
    const double error = TrajectoryError(Optimize(world).frames, world);
    EXPECT_LT(error, 0.3 * previous);
    previous = error;
  }
  EXPECT_LT(previous, 1e-3);
}

TEST(OptimizeGraph, BadRegistrationsDoNotBendTheMap) {
  World world = MakeWorld(80, 5, 2, kDrift);
  const double clean = TrajectoryError(Optimize(world).frames, world);
  for (MapObject& object : world.map.objects) {
    for (std::size_t k = 2; k < object.views.size(); k += 5) {
      // Turned back to front and a chair's width off: the usual way for a registration to fail.
      const Pose3 wrong{Eigen::Quaterniond(Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitZ())),
                        Eigen::Vector3d(0.6, 0.3, 0.1)};
      object.views[k].camera_from_object = object.views[k].camera_from_object * wrong;
    }
  }
  EXPECT_LT(TrajectoryError(Optimize(world).frames, world), clean + 0.02);
  GraphOptions paper;
  paper.object_loss = "none";
  EXPECT_GT(TrajectoryError(Optimize(world, paper).frames, world), clean + 0.05);
}

// Tracking slid along a wall and is sure of it; what was re-registered stands in its place.
TEST(OptimizeGraph, AReregisteredPairHasThatEdgeAlone) {
  World world = MakeWorld(60, 5, 1, {0.001, 0.001, 0, 0});
  world.map.objects.clear();
  constexpr std::size_t kSlid = 30;
  RelativePose& slid = world.odometry.edges[kSlid];
  const RelativePose right = slid;
  slid.i_from_j.translation_m.x() += 0.4;
  slid.information = 1e3 * slid.information.Full();
  const Pose3 moved = world.odometry.at(slid.i).world_from_camera * slid.i_from_j *
                      world.odometry.at(slid.j).world_from_camera.Inverse();
  for (auto k = static_cast<std::size_t>(slid.j.value); k < world.odometry.frames.size(); ++k) {
    Pose3& pose = world.odometry.frames[k].world_from_camera;
    pose = moved * pose;
  }
  EXPECT_GT(TrajectoryError(Optimize(world).frames, world), 0.1);
  world.loops.edges = {right};
  const OptimizedMap map = Optimize(world);
  EXPECT_LT(TrajectoryError(map.frames, world), 0.03);
}

TEST(OptimizeGraph, AWrongLoopEdgeIsOverruledAndATrueOneCloses) {
  World world = MakeWorld(120, 5, 1, {0.01, 0.006, 0, 0});
  world.map.objects.clear();
  GraphOptions options;
  const double open = TrajectoryError(Optimize(world, options).frames, world);
  const auto truth = [&](int i, int j) {
    return world.world_from_camera[static_cast<std::size_t>(i)].Inverse() *
           world.world_from_camera[static_cast<std::size_t>(j)];
  };
  const Matrix6d information = testing_support::Information(0.03, 0.035);
  for (const auto& [i, j] : {std::pair{0, 119}, std::pair{1, 118}, std::pair{2, 117}}) {
    world.loops.edges.push_back({FrameIdx{i}, FrameIdx{j}, truth(i, j), information, false});
  }
  const double closed = TrajectoryError(Optimize(world, options).frames, world);
  EXPECT_LT(closed, 0.6 * open);
  world.loops.edges.push_back({FrameIdx{10}, FrameIdx{70}, Pose3{}, information, false});
  EXPECT_LT(TrajectoryError(Optimize(world, options).frames, world), 1.3 * closed + 0.02);
  options.loop_loss = "none";
  EXPECT_GT(TrajectoryError(Optimize(world, options).frames, world), 2 * closed + 0.05);
}

TEST(OptimizeGraph, ObjectsAreUprightOnTheGround) {
  World world = MakeWorld(40, 4, 1, {0.001, 0.001, 0.01, 0.03});
  const OptimizedMap map = Optimize(world);
  EXPECT_EQ(map.ground_world, Plane{});
  for (const MapObject& object : map.map.objects) {
    EXPECT_GT((object.world_from_object.rotation * Eigen::Vector3d::UnitZ()).z(), 0.9995);
    EXPECT_EQ(object.note.find("does not stand"), std::string::npos);
  }
  // One that hangs on the wall is left there and says so.
  world.feet[ObjectId{2}].bottom_m = 0.3;
  const OptimizedMap hanging = Optimize(world);
  EXPECT_NEAR(hanging.map.objects[2].world_from_object.translation_m.z(), 0.45, 0.05);
  EXPECT_NE(hanging.map.objects[2].note.find("does not stand"), std::string::npos);
}

// What rests on furniture or hangs on a wall need not be plumb on it.
TEST(OptimizeGraph, ThingsOffTheFloorAreNotBoundToTheGround) {
  World world = MakeWorld(40, 4, 1, {0.001, 0.001, 0.01, 0.03});
  const auto tilt_and_note = [&](const Supports& supports, double bottom_m) {
    world.feet[ObjectId{2}] = {bottom_m, supports};
    const OptimizedMap map = Optimize(world);
    const MapObject& object = map.map.objects[2];
    return std::pair((object.world_from_object.rotation * Eigen::Vector3d::UnitZ()).z(),
                     object.note.find("does not stand") != std::string::npos);
  };
  const Supports floor;
  const Supports either = {.furniture = true};
  const Supports wall = {.floor = false, .wall = true};
  const auto bound = tilt_and_note(floor, -0.45);
  EXPECT_GT(bound.first, 0.9995);
  EXPECT_EQ(tilt_and_note(either, -0.45), bound) << "it stands on the floor";
  const auto hanging = tilt_and_note(wall, -0.45);
  EXPECT_LT(hanging.first, bound.first) << "it leans as its views say";
  EXPECT_EQ(tilt_and_note(either, 0.3), hanging) << "its foot is too high for the floor";
  EXPECT_FALSE(hanging.second);
  EXPECT_TRUE(tilt_and_note(floor, 0.3).second);
}

// A leaning camera walks 100 m and sees the floor all the way: tracking alone climbs by metres.
TEST(OptimizeGraph, TheGroundKeepsAHundredMetresLevel) {
  Random random(21);
  World world;
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  Pose3 tracked;
  for (int k = 0; k <= 200; ++k) {
    Pose3 truth = testing_support::LookAlong({0.5 * k, 0, 1.4}, 0.2 * std::sin(0.1 * k), 0.5);
    truth.rotation = (truth.rotation * roll).normalized();
    if (k > 0) {
      const Pose3 measured = world.world_from_camera.back().Inverse() * truth *
                             testing_support::Disturbance(random, 0.001, 0.005);
      tracked = tracked * measured;
      world.odometry.edges.push_back({FrameIdx{k - 1},
                                      FrameIdx{k},
                                      measured,
                                      testing_support::Information(0.001, 0.005),
                                      false});
    }
    world.world_from_camera.push_back(truth);
    world.odometry.keyframes.push_back(FrameIdx{k});
    world.odometry.frames.push_back(
        {FrameIdx{k}, 0.1 * k, tracked, TrackingStatus::kTracked, FrameIdx{k}, 0.002, 0.9});
    const Eigen::Vector3d deviation(0.002, 0.002, 0.005);
    world.ground.observations.push_back({FrameIdx{k},
                                         Transformed(truth.Inverse(), Plane{}),
                                         deviation.cwiseAbs2().cwiseInverse().asDiagonal(),
                                         10000});
  }
  world.ground.plane_world = world.ground.observations.front().plane_camera;
  const Plane floor = *world.ground.plane_world;
  EXPECT_GT(std::abs(floor.SignedDistance(tracked.translation_m) - 1.4), 0.5);
  const OptimizedMap map = Optimize(world);
  for (std::size_t k = 0; k < map.frames.size(); ++k) {
    const Pose3& camera = map.frames[k].world_from_camera;
    EXPECT_NEAR(camera.translation_m.z(), 1.4, 0.02) << k;
    const Eigen::Vector3d up_camera = camera.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d true_up =
        world.world_from_camera[k].rotation.conjugate() * Eigen::Vector3d::UnitZ();
    EXPECT_LT((up_camera - true_up).norm(), 0.01) << k;
  }
}

TEST(OptimizeGraph, AFreeYawDoesNotDisturb) {
  World world = MakeWorld(60, 5, 2, {0.002, 0.002, 0.01, 0.01});
  Random random(5);
  for (MapObject& object : world.map.objects) {
    for (ViewRegistration& view : object.views) {
      view.yaw_free = true;
      const Pose3 any{Eigen::Quaterniond(
                          Eigen::AngleAxisd(random.Uniform(-3.1, 3.1), Eigen::Vector3d::UnitZ())),
                      Eigen::Vector3d::Zero()};
      view.camera_from_object = view.camera_from_object * any;
    }
  }
  const OptimizedMap map = Optimize(world);
  EXPECT_LT(TrajectoryError(map.frames, world), 0.05);
  for (std::size_t k = 0; k < map.map.objects.size(); ++k) {
    EXPECT_LT((map.map.objects[k].world_from_object.translation_m -
               world.world_from_object[k].translation_m)
                  .norm(),
              0.06);
  }
}

TEST(OptimizeGraph, FramesBetweenKeyframesFollow) {
  World world = MakeWorld(81, 4, 2, kDrift);
  // Every fourth frame is a keyframe; edges and views of the others go.
  Odometry& odometry = world.odometry;
  odometry.edges.clear();
  odometry.keyframes.clear();
  for (int k = 0; k < 81; ++k)
    odometry.frames[static_cast<std::size_t>(k)].keyframe = FrameIdx{k - k % 4};
  for (int k = 0; k < 81; k += 4) {
    odometry.keyframes.push_back(FrameIdx{k});
    if (k == 0) continue;
    odometry.edges.push_back({FrameIdx{k - 4},
                              FrameIdx{k},
                              odometry.at(FrameIdx{k - 4}).world_from_camera.Inverse() *
                                  odometry.at(FrameIdx{k}).world_from_camera,
                              testing_support::Information(0.008, 0.006),
                              false});
  }
  for (const bool interpolate : {true, false}) {
    GraphOptions options;
    options.interpolate_frames = interpolate;
    const OptimizedMap map = Optimize(world, options);
    ASSERT_EQ(map.frames.size(), 81u);
    EXPECT_LT(TrajectoryError(map.frames, world), 0.6 * ErrorBefore(world));
    double worst_jump_m = 0;
    for (std::size_t k = 1; k < 81; ++k) {
      const Pose3 tracked =
          odometry.frames[k - 1].world_from_camera.Inverse() * odometry.frames[k].world_from_camera;
      const Pose3 now =
          map.frames[k - 1].world_from_camera.Inverse() * map.frames[k].world_from_camera;
      worst_jump_m = std::max(worst_jump_m, (tracked.Inverse() * now).translation_m.norm());
      if (!interpolate && k % 4 != 0) {
        EXPECT_THAT(now, PoseNear(tracked, 1e-9, 1e-6));
      }
    }
    EXPECT_LT(worst_jump_m, 0.03);
  }
}

TEST(OptimizeGraph, ObjectsWithoutUsableViewsKeepTheirPlaceBesideTheirKeyframe) {
  World world = MakeWorld(80, 5, 2, kDrift);
  MapObject& object = world.map.objects[3];
  for (ViewRegistration& view : object.views) view.ok = false;
  object.views[5].inlier_share = 0.95;
  const Pose3 before = world.odometry.at(object.views[5].frame).world_from_camera.Inverse() *
                       object.world_from_object;
  const OptimizedMap map = Optimize(world);
  const Pose3 after = map.frames[static_cast<std::size_t>(object.views[5].frame.value)]
                          .world_from_camera.Inverse() *
                      map.map.objects[3].world_from_object;
  EXPECT_THAT(after, PoseNear(before, 1e-9, 1e-6));
}

TEST(OptimizeGraph, BytesDoNotDependOnTheNumberOfThreads) {
  const World world = MakeWorld(100, 6, 2, kDrift);
  for (const int max_direct_keyframes : {200, 0}) {
    GraphOptions options;
    options.max_direct_keyframes = max_direct_keyframes;
    std::string first;
    for (const int threads : {1, 2, 2}) {
      const ThreadLimit limit(threads);
      const OptimizedMap map = Optimize(world, options);
      const std::string text = *GraphToG2o(
          world.odometry, world.ground, world.map, world.loops, {}, {world.feet, {}}, &map);
      if (first.empty()) first = text;
      EXPECT_TRUE(text == first);
    }
  }
}

TEST(OptimizeGraph, ConjugateGradientsFindWhatAFactorisationFinds) {
  GraphOptions direct;
  direct.max_direct_keyframes = 1000;
  GraphOptions gradients;
  gradients.max_direct_keyframes = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    World world = MakeWorld(180, 6, 3, kDrift, seed);
    testing_support::AddMeasured({60, {5, 10}, false}, kDrift, seed, world);
    const OptimizedMap a = Optimize(world, direct);
    const OptimizedMap b = Optimize(world, gradients);
    EXPECT_TRUE(b.summary.converged) << b.summary.message;
    EXPECT_NEAR(Energy(b, true), Energy(a, true), 1e-5 * Energy(a, true));
    ASSERT_EQ(b.frames.size(), a.frames.size());
    for (std::size_t k = 0; k < a.frames.size(); ++k) {
      EXPECT_THAT(b.frames[k].world_from_camera,
                  PoseNear(a.frames[k].world_from_camera, 1e-4, 0.005))
          << k;
    }
    for (std::size_t k = 0; k < a.map.objects.size(); ++k) {
      EXPECT_THAT(b.map.objects[k].world_from_object,
                  PoseNear(a.map.objects[k].world_from_object, 1e-4, 0.005));
    }
  }
}

TEST(OptimizeGraph, SmallAndEmptyGraphs) {
  const OptimizedMap nothing = Optimize({});
  EXPECT_TRUE(nothing.summary.converged);
  EXPECT_FALSE(nothing.has_ground);

  World single = MakeWorld(1, 0, 1, {});
  EXPECT_THAT(Optimize(single).frames[0].world_from_camera,
              PoseNear(single.world_from_camera[0], 1e-9, 1e-6));
  single.ground = {};
  const OptimizedMap upright = Optimize(single);
  EXPECT_FALSE(upright.has_ground);
  EXPECT_LT((upright.frames[0].world_from_camera.rotation * -Eigen::Vector3d::UnitY() -
             Eigen::Vector3d::UnitZ())
                .norm(),
            1e-9);

  single.ground.upright = QuarterTurn::kClockwise;
  const OptimizedMap turned = Optimize(single);
  EXPECT_FALSE(turned.has_ground);
  EXPECT_EQ(turned.upright, single.ground.upright);
  EXPECT_LT((turned.frames[0].world_from_camera.rotation * -Eigen::Vector3d::UnitX() -
             Eigen::Vector3d::UnitZ())
                .norm(),
            1e-9)
      << "the left edge becomes the upper one";

  World no_objects = MakeWorld(30, 0, 1, kDrift);
  EXPECT_TRUE(Optimize(no_objects).summary.converged);
  World no_ground = MakeWorld(30, 3, 1, kDrift);
  no_ground.ground = {};
  const OptimizedMap map = Optimize(no_ground);
  EXPECT_TRUE(map.summary.converged);
  EXPECT_EQ(map.summary.ground_observed, 0.0);
}

TEST(OptimizeGraph, BadEdgesAreLeftOutAndCounted) {
  World world = MakeWorld(40, 3, 1, kDrift);
  const double clean = TrajectoryError(Optimize(world).frames, world);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  world.odometry.edges.push_back(
      {FrameIdx{3}, FrameIdx{400}, Pose3{}, Matrix6d::Identity(), false});
  world.odometry.edges.push_back(
      {FrameIdx{3}, FrameIdx{9}, Pose3{}, Matrix6d::Constant(nan), false});
  world.odometry.edges.push_back({FrameIdx{3},
                                  FrameIdx{9},
                                  {Eigen::Quaterniond::Identity(), Eigen::Vector3d(nan, 0, 0)},
                                  Matrix6d::Identity(),
                                  false});
  world.ground.observations.push_back(
      {FrameIdx{2}, {Eigen::Vector3d::Zero(), 1}, Eigen::Matrix3d::Identity(), 5});
  ViewRegistration view = world.map.objects[0].views[0];
  view.frame = FrameIdx{-1};
  world.map.objects[0].views.push_back(view);
  view.frame = FrameIdx{1};
  view.information.setZero();
  world.map.objects[0].views.push_back(view);
  const OptimizedMap map = Optimize(world);
  EXPECT_NE(map.summary.message.find("6 unusable edges"), std::string::npos) << map.summary.message;
  EXPECT_NEAR(TrajectoryError(map.frames, world), clean, 1e-6);
}

TEST(OptimizeGraph, LooseKeyframesAreTied) {
  World world = MakeWorld(40, 0, 1, {});
  world.ground = {};
  world.odometry.edges.erase(world.odometry.edges.begin() + 17);
  const OptimizedMap map = Optimize(world);
  EXPECT_TRUE(map.summary.converged);
  EXPECT_NE(map.summary.message.find("1 keyframes"), std::string::npos) << map.summary.message;
}

TEST(OptimizeGraph, RefusesATrajectoryThatIsNone) {
  World world = MakeWorld(10, 0, 1, {});
  std::swap(world.odometry.keyframes[2], world.odometry.keyframes[3]);
  EXPECT_FALSE(OptimizeGraph(world.odometry, world.ground, world.map, {}, {}).ok());
  world = MakeWorld(10, 0, 1, {});
  world.odometry.frames[4].frame = FrameIdx{7};
  EXPECT_FALSE(OptimizeGraph(world.odometry, world.ground, world.map, {}, {}).ok());
  world = MakeWorld(10, 0, 1, {});
  world.odometry.frames[4].world_from_camera.translation_m.x() =
      std::numeric_limits<double>::infinity();
  const Result<OptimizedMap> result =
      OptimizeGraph(world.odometry, world.ground, world.map, {}, {});
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("entry 4"), std::string::npos);
}

TEST(OptimizeGraph, AThousandKeyframesConverge) {
  const World world = MakeWorld(1000, 50, 4, kDrift);
  const OptimizedMap map = Optimize(world);
  EXPECT_TRUE(map.summary.converged) << map.summary.message;
  EXPECT_LT(TrajectoryError(map.frames, world), 0.5 * ErrorBefore(world));
}

TEST(GraphToG2o, FileHoldsTheGraphAndItsEnergy) {
  const World world = MakeWorld(40, 4, 1, kDrift);
  const OptimizedMap map = Optimize(world);
  const auto text =
      GraphToG2o(world.odometry, world.ground, world.map, world.loops, {}, {world.feet, {}}, &map);
  ASSERT_TRUE(text.ok());
  const Result<G2oGraph> read = ParseG2o(*text);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->vertices.size(), 44u);
  EXPECT_EQ(read->edges.size(), 39u + 40u);
  EXPECT_TRUE(read->vertices.contains(kObjectVertexOffset + 3));
  EXPECT_EQ(read->plane_edges.size(), 40u);
  EXPECT_EQ(read->upright.size(), 4u);
  // Rotations are small, so half-angle and rotation-vector energies agree.
  EXPECT_NEAR(Chi2(*read) / (map.summary.terms[0].after + map.summary.terms[1].after), 1.0, 1e-2);
}

TEST(GravityFromTracking, LooksAlongXAndStandsAboveTheOrigin) {
  const Pose3 world_from_camera = testing_support::LookAlong({2, 3, 1.6}, 1.1, 0.4);
  const Pose3 tracking_from_world = V2t((Vector6d() << 1, 2, 3, 0.3, -0.5, 0.9).finished());
  const Pose3 camera = tracking_from_world * world_from_camera;
  const Pose3 gravity = GravityFromTracking(camera, Transformed(tracking_from_world, Plane{}));
  EXPECT_THAT(gravity * camera,
              PoseNear(testing_support::LookAlong({0, 0, 1.6}, 0, 0.4), 1e-9, 1e-6));
}

TEST(GravityFromTracking, StraightDownTheImagesUpperEdgeIsForward) {
  for (const double sign : {1.0, -1.0}) {
    const double down_rad = sign * (0.5 * std::numbers::pi - 0.01);
    const Pose3 camera = testing_support::LookAlong({0, 0, 1.6}, 0.8, down_rad);
    const Pose3 gravity = GravityFromTracking(camera, Plane{});
    EXPECT_THAT(gravity * camera,
                PoseNear(testing_support::LookAlong({0, 0, 1.6}, 0, down_rad), 1e-9, 1e-6));
  }
}

// Held in any of four ways, told which: the world is that of the camera held upright.
TEST(GravityFromTracking, WithoutAGroundStandsAsThePicturesDo) {
  const Pose3 camera = V2t((Vector6d() << 1, 2, 3, 0.3, -0.5, 0.9).finished());
  const Pose3 upright = GravityFromTracking(camera, std::nullopt);
  for (const QuarterTurn held :
       {QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise}) {
    Eigen::Matrix3d upright_from_held;
    for (int k = 0; k < 3; ++k)
      upright_from_held.col(k) = Turned(Eigen::Vector3d(Eigen::Vector3d::Unit(k)), Inverse(held));
    const Pose3 lying = {camera.rotation * Eigen::Quaterniond(upright_from_held),
                         camera.translation_m};
    EXPECT_THAT(GravityFromTracking(lying, std::nullopt, Inverse(held)),
                PoseNear(upright, 1e-9, 1e-6));
  }
}

}  // namespace
}  // namespace deepslam::graph
