#include "deepslam/instances/find_instances.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/instances/silhouettes.h"
#include "instances/sampled_world.h"
#include "support/box_world.h"

namespace deepslam::instances {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace testing_support;  // NOLINT

// Of masks against the truth: a voxel at the edges of things is theirs or their neighbour's.
constexpr double kMinMaskIou = 0.85;

const Eigen::Vector3d kMiddle(0, 0, 0.4);

std::vector<Cuboid> TwoCabinets(double gap_m) {
  return {{0, {-0.6, 0, 0}, {-gap_m / 2, 0.5, 0.8}}, {1, {gap_m / 2, 0.15, 0}, {0.6, 0.65, 0.5}}};
}

TEST(FindInstances, ThingsApartAreThingsWithoutAnyDetection) {
  const Found found = Find(TwoCabinets(0.3), {}, {}, Evidence::kNone);
  const std::vector<Instance> mapped = Mapped(found);
  ASSERT_THAT(mapped, SizeIs(2));
  for (const Instance& instance : mapped) {
    EXPECT_EQ(instance.class_name, "cabinet");
    EXPECT_FALSE(instance.is_named);
  }
}

TEST(FindInstances, AThingAgainstALowerOneIsAnother) {
  // They touch: what tells them apart is the concave edge between side and top.
  const std::vector<Instance> mapped = Mapped(Find(TwoCabinets(0), {}, {}, Evidence::kNone));
  EXPECT_THAT(mapped, SizeIs(2));
}

TEST(FindInstances, FlushThingsAreToldApartByMasks) {
  // A bed and a nightstand of its height: geometry sees one block.
  const std::vector<Cuboid> world = {{0, {-1, -0.7, 0}, {1, 0.7, 0.5}},
                                     {1, {-1, 0.7, 0}, {-0.5, 1.2, 0.5}}};
  const std::vector<Pose3> poses = Orbit(kMiddle, 3, 1.6, 0, 40, 9);
  const std::vector<Instance> mapped =
      Mapped(Find(world, poses, {{0, "bed"}, {1, "chair"}}, Evidence::kMasks));
  EXPECT_EQ(CountClass(mapped, "bed"), 1);
  for (const Instance& instance : mapped) {
    if (instance.class_name != "bed") continue;
    EXPECT_NEAR(instance.box_level.long_side_m(), 2, 0.12);
  }
}

TEST(FindInstances, PartsThatMasksHoldTogetherAreOneThingAcrossAGapInIt) {
  // A bed of which the frame between two mattresses is hidden.
  const std::vector<Cuboid> world = {{0, {-1, -0.75, 0}, {1, -0.05, 0.5}},
                                     {0, {-1, 0.05, 0}, {1, 0.75, 0.5}}};
  const std::vector<Pose3> poses = Orbit(kMiddle, 3, 1.6, 0, 20, 18);
  EXPECT_THAT(Mapped(Find(world, poses, {}, Evidence::kNone)), SizeIs(2)) << "nothing joins them";
  const std::vector<Instance> mapped = Mapped(Find(world, poses, {{0, "bed"}}, Evidence::kMasks));
  ASSERT_THAT(mapped, SizeIs(1));
  EXPECT_NEAR(mapped[0].box_level.short_side_m(), 1.5, 0.12);
}

std::vector<Cuboid> TableWithChairs() {
  std::vector<Cuboid> world = TableAt(0, 0, 0);
  Append(world, ChairAt(1, -0.3, -0.45, -1));
  Append(world, ChairAt(2, 0.3, -0.45, -1));
  Append(world, ChairAt(3, 0.0, 0.45, 1));
  return world;
}
const std::vector<Label> kTableWithChairs = {
    {0, "table"}, {1, "chair"}, {2, "chair"}, {3, "chair"}};

TEST(FindInstances, ChairsPushedUnderATableAreEachAThing) {
  for (const Evidence evidence : {Evidence::kBoxes, Evidence::kMasks}) {
    const std::vector<Instance> mapped = Mapped(
        Find(TableWithChairs(), Orbit(kMiddle, 2.4, 1.5, 0, 20, 18), kTableWithChairs, evidence));
    // Boxes, other than masks, may leave a strip of the table to a chair.
    EXPECT_EQ(std::ranges::count_if(mapped,
                                    [](const Instance& instance) {
                                      return instance.class_name == "chair" &&
                                             instance.box_level.top_m > 0.8;
                                    }),
              3);
    EXPECT_EQ(CountClass(mapped, "table"), 1);
  }
}

TEST(FindInstances, AClassIsAVoteOfAllViews) {
  const std::vector<Cuboid> world = TableAt(0, 0, 0);
  const SampledWorld sampled = Sample(world);
  const SurfaceElements elements(sampled.points, sampled.normals, kVoxelM);
  const InstanceOptions options;
  const std::vector<ElementPair> pairs = elements.PairsWithin(1.9 * kVoxelM);
  const Superpoints superpoints =
      MakeSuperpoints(elements, std::vector<char>(elements.size(), 0), pairs, options.superpoints);
  ViewVotes votes;
  const std::vector<Pose3> poses = Orbit(kMiddle, 2.4, 1.5, 0, 40, 9);
  for (std::size_t n = 0; n < poses.size(); ++n) {
    const BoxView view = RenderBoxes(world, SmallCamera(), poses[n]);
    const std::vector<Detection> detections =
        Detect(view, {{0, n % 3 == 0 ? "chair" : "table"}}, Evidence::kMasks);
    const VisibleElements visible =
        FindVisible(elements, ViewOf(view, poses[n], detections), options.votes);
    AddVotes(ClaimSuperpoints(superpoints, visible, detections, options.votes),
             detections,
             superpoints.count(),
             votes);
  }
  const Instances found =
      FindInstances(elements, superpoints, pairs, votes, {}, Classes(), options);
  ASSERT_FALSE(found.instances.empty());
  const auto largest = std::ranges::max_element(
      found.instances, {}, [](const Instance& i) { return i.elements.size(); });
  EXPECT_EQ(largest->class_name, "table");
  EXPECT_GT(largest->class_shares.at("table"), largest->class_shares.at("chair"));
}

TEST(FindInstances, ATopThatDetectionsTakeForASeatIsATable) {
  ClassTable classes = Classes();
  classes.classes[0].max_seat_height_m = 0.6;
  classes.classes[1].traits.support_plane = true;
  const auto name_of = [&](double side_m, double height_m) {
    const Eigen::Vector3d half(side_m / 2, side_m / 2, 0);
    const std::vector<Cuboid> world = {{0, -half, half + Eigen::Vector3d(0, 0, height_m)}};
    const Found found = Find(
        world, Orbit(kMiddle, 2.4, 1.5, 0, 40, 9), {{0, "chair"}}, Evidence::kMasks, {}, classes);
    EXPECT_THAT(found.instances.instances, SizeIs(1));
    EXPECT_TRUE(found.instances.instances.front().is_named);
    return found.instances.instances.front().class_name;
  };
  EXPECT_EQ(name_of(0.8, 0.75), "table") << "under a cloth";
  EXPECT_EQ(name_of(0.8, 0.45), "chair") << "a pouf";
  EXPECT_EQ(name_of(0.4, 0.75), "chair") << "a bar stool";
  classes.classes[0].max_seat_height_m = ObjectClass().max_seat_height_m;
  EXPECT_EQ(name_of(0.8, 0.75), "chair") << "of a class that may have any top";
}

TEST(FindInstances, WhatNobodyNamesAndHangsIsNoThingOfTheFloor) {
  // A wall cabinet and a cabinet of its size; no class but the fallback may hang.
  const std::vector<Cuboid> world = {{0, {-1, 0, 0}, {-0.2, 0.4, 0.6}},
                                     {1, {0.5, 0, 1.3}, {1.3, 0.4, 1.9}}};
  ClassTable classes = Classes();
  classes.classes.back().traits.supports = {.furniture = true, .wall = true};
  const SampledWorld sampled = Sample(world);
  const SurfaceElements elements(sampled.points, sampled.normals, kVoxelM);
  const std::vector<ElementPair> pairs = elements.PairsWithin(1.9 * kVoxelM);
  const Superpoints superpoints =
      MakeSuperpoints(elements, std::vector<char>(elements.size(), 0), pairs, {});
  const Instances found = FindInstances(elements, superpoints, pairs, {}, {}, classes, {});
  std::multiset<std::string> names;
  for (const Instance& instance : found.instances) {
    if (instance.rejection.empty()) names.insert(instance.class_name);
  }
  EXPECT_THAT(names, testing::ElementsAre("cabinet", "furniture"));
}

TEST(FindInstances, WhatIsDeeperThanAClassIsOfAnother) {
  const std::vector<Cuboid> world = {{0, {-1.2, 0, 0}, {-0.2, 0.3, 1.9}},
                                     {1, {0.4, 0, 0}, {1.4, 0.65, 1.9}}};
  ClassTable classes = Classes();
  ObjectClass shelf{"shelf", {}, {}, 0.5, 3.0, 0.5, 2.7, {}, {}};
  shelf.max_depth_m = 0.5;
  classes.classes.insert(classes.classes.begin(), shelf);
  const auto names = [&] {
    std::multiset<std::string> found;
    for (const Instance& instance : Mapped(Find(world, {}, {}, Evidence::kNone, {}, classes)))
      found.insert(instance.class_name);
    return found;
  };
  EXPECT_THAT(names(), testing::ElementsAre("cabinet", "shelf"));
  classes.classes.front().max_depth_m = ObjectClass().max_depth_m;
  EXPECT_THAT(names(), testing::ElementsAre("shelf", "shelf"));
}

// Of things that nobody names, over a floor that is seen wherever none of them stands.
std::vector<Instance> FoundOverFloor(const std::vector<Cuboid>& things, double table_m) {
  SampledWorld sampled = Sample(things);
  for (double x = -2; x < 2; x += kSampleM) {
    for (double y = -2; y < 2; y += kSampleM) {
      if (IsInside(things, {x, y, 0.01})) continue;
      sampled.points.emplace_back(x, y, 0);
      sampled.normals.emplace_back(0, 0, 1);
    }
  }
  const SurfaceElements elements(sampled.points, sampled.normals, kVoxelM);
  std::vector<char> is_floor(elements.size());
  std::ranges::transform(elements.points(), is_floor.begin(), [](const Eigen::Vector3f& p) {
    return p.z() < 0.03F ? 1 : 0;
  });
  ClassTable classes = Classes();
  classes.classes[1].traits.support_plane = true;
  classes.classes[1].min_size_m = table_m;
  const std::vector<ElementPair> pairs = elements.PairsWithin(1.9 * kVoxelM);
  const Superpoints superpoints = MakeSuperpoints(elements, is_floor, pairs, {});
  return FindInstances(elements, superpoints, pairs, {}, {}, classes, {}).instances;
}

// Their classes.
std::multiset<std::string> NamesOverFloor(const std::vector<Cuboid>& things, double table_m) {
  std::multiset<std::string> names;
  for (const Instance& instance : FoundOverFloor(things, table_m)) {
    if (instance.rejection.empty()) names.insert(instance.class_name);
  }
  return names;
}

// A top on legs at its corners.
std::vector<Cuboid> OnLegs(double length_m, double width_m, double height_m) {
  const double x = 0.5 * length_m;
  const double y = 0.5 * width_m;
  std::vector<Cuboid> world = {{0, {-x, -y, height_m - 0.04}, {x, y, height_m}}};
  for (const double leg_x : {-x, x - 0.06}) {
    for (const double leg_y : {-y, y - 0.06})
      world.push_back({0, {leg_x, leg_y, 0}, {leg_x + 0.06, leg_y + 0.06, height_m - 0.04}});
  }
  return world;
}

TEST(FindInstances, ATopOnLegsIsATableThoughNobodyNamesIt) {
  EXPECT_THAT(NamesOverFloor(OnLegs(1.2, 0.7, 0.5), 0.4), testing::ElementsAre("table"));
  EXPECT_THAT(NamesOverFloor({{0, {-0.6, -0.35, 0}, {0.6, 0.35, 0.5}}}, 0.4),
              testing::ElementsAre("cabinet"))
      << "of its size, closed";
  EXPECT_THAT(NamesOverFloor(OnLegs(0.5, 0.4, 0.5), 0.4), testing::ElementsAre("cabinet"))
      << "a nightstand on legs";
  EXPECT_THAT(NamesOverFloor({{0, {-0.6, -0.35, 0.66}, {0.6, 0.35, 0.7}}}, 0.4),
              testing::ElementsAre("table"))
      << "legs too thin for the surface";
  EXPECT_THAT(NamesOverFloor(OnLegs(1.2, 0.7, 0.5), 3), testing::ElementsAre("furniture"))
      << "no table is as small";
}

TEST(FindInstances, ATableKnowsItsTopWhateverStandsOnIt) {
  std::vector<Cuboid> table = OnLegs(1.2, 0.7, 0.5);
  table.push_back({0, {-0.5, -0.2, 0.48}, {-0.2, 0.2, 0.7}});
  const std::vector<Instance> found = FoundOverFloor(table, 0.4);
  const auto named = std::ranges::find(found, "table", &Instance::class_name);
  ASSERT_NE(named, found.end());
  ASSERT_TRUE(named->top_m);
  EXPECT_NEAR(*named->top_m, 0.5, 0.02);
  for (const Instance& cabinet : FoundOverFloor({{0, {-0.6, -0.35, 0}, {0.6, 0.35, 0.5}}}, 0.4))
    EXPECT_FALSE(cabinet.top_m);
}

// The side of a cuboid that faces along x alone, as of a row of things along a wall.
void AddFront(const Cuboid& box, SampledWorld& sampled) { SampleSide({}, box, 0, 1, sampled); }

TEST(FindInstances, AFrontBeforeAWallIsAsDeepAsTheWallLets) {
  // A wardrobe of which the front was seen, and the wall at its sides.
  SampledWorld sampled;
  AddFront({0, {0, 0, 0}, {0.6, 1, 2}}, sampled);
  const std::size_t num_of_front = sampled.points.size();
  AddFront({1, {-0.1, -1, 0}, {0, -0.1, 2.4}}, sampled);
  AddFront({1, {-0.1, 1.1, 0}, {0, 2, 2.4}}, sampled);
  const SurfaceElements elements(sampled.points, sampled.normals, kVoxelM);
  std::vector<char> is_structure(elements.size());
  std::ranges::transform(elements.points(), is_structure.begin(), [](const Eigen::Vector3f& p) {
    return p.x() < 0.1F ? 1 : 0;
  });
  const std::vector<ElementPair> pairs = elements.PairsWithin(1.9 * kVoxelM);
  const Superpoints superpoints = MakeSuperpoints(elements, is_structure, pairs, {});
  LayoutWall wall;  // along y, at x = 0
  wall.from_m = {0, 2};
  wall.to_m = {0, -1};
  wall.top_m = 2.4;
  const auto find = [&](std::span<const LayoutWall> walls) {
    return FindInstances(elements, superpoints, pairs, {}, walls, Classes(), {}).instances;
  };
  ASSERT_GT(num_of_front, 100U);
  const std::vector<Instance> before_wall = find(std::vector{wall});
  ASSERT_THAT(before_wall, SizeIs(1));
  EXPECT_THAT(before_wall[0].rejection, IsEmpty());
  EXPECT_NEAR(before_wall[0].box_level.short_side_m(), 0.6, 0.05);
  EXPECT_THAT(find({})[0].rejection, HasSubstr("deep")) << "a leaf or a screen";
}

TEST(FindInstances, APedestalIsOfItsBasin) {
  const std::vector<Cuboid> world = {{0, {-0.3, -0.25, 0.65}, {0.3, 0.25, 0.85}},
                                     {1, {-0.1, -0.1, 0}, {0.1, 0.1, 0.6}}};
  ClassTable classes = Classes();
  classes.classes.push_back({"sink", {"sink"}, {}, 0.3, 1.5, 0.1, 1.2, {}, {}});
  const std::vector<Pose3> poses = Orbit(kMiddle, 2.4, 1.5, 0, 40, 9);
  const std::vector<Instance> mapped =
      Mapped(Find(world, poses, {{0, "sink"}}, Evidence::kMasks, {}, classes));
  ASSERT_THAT(mapped, SizeIs(1));
  EXPECT_EQ(mapped[0].class_name, "sink");
  EXPECT_LT(mapped[0].box_level.bottom_m, 0.05);
  EXPECT_NEAR(mapped[0].box_level.top_m, 0.85, 0.03);
}

TEST(FindInstances, WhatHidesItsFootReachesDownToTheFloor) {
  // Of a bed before which things lie nothing below its mattress was seen.
  const std::vector<Cuboid> world = {{0, {-1, -0.7, 0.3}, {1, 0.7, 0.5}}};
  const std::vector<Pose3> poses = Orbit(kMiddle, 3, 1.6, 0, 40, 9);
  const std::vector<Instance> mapped = Mapped(Find(world, poses, {{0, "bed"}}, Evidence::kMasks));
  ASSERT_THAT(mapped, SizeIs(1));
  EXPECT_EQ(mapped[0].box_level.bottom_m, 0);
}

TEST(FindInstances, AShortThingIsNoBedHoweverHigh) {
  // A wardrobe's end that a detector takes for a bed: half a bed long only in height.
  const std::vector<Cuboid> world = {{0, {0, 0, 0}, {0.5, 0.4, 1.1}}};
  const std::vector<Pose3> poses = Orbit(kMiddle, 3, 1.6, 0, 40, 9);
  const std::vector<Instance> mapped = Mapped(Find(world, poses, {{0, "bed"}}, Evidence::kMasks));
  ASSERT_THAT(mapped, SizeIs(1));
  EXPECT_EQ(mapped[0].class_name, "cabinet");
}

TEST(FindInstances, WhatNobodyNamesAndIsThinSmallOrHighIsNotMappedAndSaysWhy) {
  const std::vector<Cuboid> world = {{0, {-1, 0, 0}, {1, 0.08, 1.8}},  // a door leaf
                                     {1, {3, 0, 0}, {3.2, 0.2, 0.2}},  // a shoe
                                     {2, {6, 0, 0}, {7, 0.5, 2.6}}};   // a pillar
  const Found found = Find(world, {}, {}, Evidence::kNone);
  EXPECT_THAT(Mapped(found), IsEmpty());
  std::string reasons;
  for (const Instance& instance : found.instances.instances) reasons += instance.rejection + '\n';
  EXPECT_THAT(reasons, HasSubstr("small"));
  EXPECT_THAT(reasons, HasSubstr("part of the room"));
}

TEST(FindInstances, StructureIsNoThing) {
  const SampledWorld sampled = Sample(TwoCabinets(0.3));
  const SurfaceElements elements(sampled.points, sampled.normals, kVoxelM);
  const std::vector<ElementPair> pairs = elements.PairsWithin(1.9 * kVoxelM);
  const Superpoints superpoints =
      MakeSuperpoints(elements, std::vector<char>(elements.size(), 1), pairs, {});
  EXPECT_EQ(superpoints.count(), 0);
  const Instances found = FindInstances(elements, superpoints, pairs, {}, {}, Classes(), {});
  EXPECT_THAT(found.instances, IsEmpty());
}

TEST(FindInstances, NothingIsFoundWhereNothingWasSeen) {
  EXPECT_THAT(Find({}, Orbit(kMiddle, 2, 1, 0, 90, 4), {}, Evidence::kMasks).instances.instances,
              IsEmpty());
}

TEST(FindInstances, MasksOfAnotherSizeClaimNothingOutsideThem) {
  const std::vector<Cuboid> world = TwoCabinets(0.3);
  const SampledWorld sampled = Sample(world);
  const SurfaceElements elements(sampled.points, sampled.normals, kVoxelM);
  const Superpoints superpoints = MakeSuperpoints(
      elements, std::vector<char>(elements.size(), 0), elements.PairsWithin(1.9 * kVoxelM), {});
  const Pose3 pose = LookAt({0, -3, 1}, kMiddle);
  const BoxView view = RenderBoxes(world, SmallCamera(), pose);
  Detection detection;
  detection.class_name = "chair";
  detection.box_px = {0, 0, 319, 239};
  detection.mask = Mask(2, 2, 1);
  const std::vector<Detection> detections = {detection};
  const VisibleElements visible = FindVisible(elements, ViewOf(view, pose, detections), {});
  ASSERT_THAT(visible.elements, testing::Not(IsEmpty()));
  for (const int claimed_by : ClaimSuperpoints(superpoints, visible, detections, {}).claimed_by)
    EXPECT_EQ(claimed_by, -1);
}

TEST(Silhouettes, AreThePixelsOfTheThingAndOverlapNowhere) {
  const std::vector<Cuboid> world = TableWithChairs();
  const std::vector<Pose3> poses = Orbit(kMiddle, 2.4, 1.5, 0, 20, 18);
  const Found found = Find(world, poses, kTableWithChairs, Evidence::kMasks);
  int num_checked = 0;
  const NearestElements nearest(found.elements);
  for (const Pose3& pose : {poses[2], poses[7], poses[13]}) {
    const BoxView view = RenderBoxes(world, SmallCamera(), pose);
    Mask taken(320, 240);
    SilhouetteOptions options;
    options.min_points = 200;
    for (const Silhouette& silhouette : FindSilhouettes({found.elements, nearest, found.instances},
                                                        {},
                                                        view.frame.depth_m,
                                                        SmallCamera(),
                                                        pose,
                                                        options)) {
      std::map<int, int> shown;
      for (std::size_t p = 0; p < taken.size(); ++p) {
        if (silhouette.mask.data()[p] == 0) continue;
        EXPECT_EQ(taken.data()[p], 0);
        taken.data()[p] = 1;
        ++shown[view.object.data()[p]];
      }
      const auto most = std::ranges::max_element(shown, {}, &std::pair<const int, int>::second);
      EXPECT_GT(MaskIoU(silhouette.mask, view, most->first), kMinMaskIou);
      ++num_checked;
    }
  }
  EXPECT_GE(num_checked, 6);
}

TEST(Silhouettes, OfAFrameWithoutDepthThereAreNone) {
  const Found found = Find(TwoCabinets(0.3), {}, {}, Evidence::kNone);
  const NearestElements nearest(found.elements);
  EXPECT_THAT(FindSilhouettes({found.elements, nearest, found.instances},
                              {},
                              DepthImage(320, 240),
                              SmallCamera(),
                              LookAt({0, -3, 1}, kMiddle),
                              {}),
              IsEmpty());
}

}  // namespace
}  // namespace deepslam::instances
