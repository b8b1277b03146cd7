#include "deepslam/loop/shared_place.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "deepslam/scene/measured_parts.h"

namespace deepslam::loop {
namespace {

MapObject Chair(int id, double x_m, double confidence) {
  MapObject chair;
  chair.id = ObjectId(id);
  chair.class_name = "chair";
  chair.world_from_object.translation_m.x() = x_m;
  chair.scale_m = 1;
  chair.confidence = confidence;
  return chair;
}

// Places alone.
std::vector<Duplicate> Duplicates(const ObjectMap& map, const LoopOptions& options = {}) {
  return FindDuplicates(SuspectDuplicates(map, options), map, {});
}

// A board of 1 m, upright along x, that begins at this corner.
std::vector<Eigen::Vector3f> Board(float x_m, float y_m, float width_m) {
  std::vector<Eigen::Vector3f> points;
  for (float a = 0; a < width_m; a += 0.02F) {
    for (float z = 0; z < 1; z += 0.02F) points.emplace_back(x_m + a, y_m, z);
  }
  return points;
}

TEST(SharedPlace, DuplicatesStandInASurerOneOfTheirClass) {
  const ObjectMap map{{Chair(0, 0, 0.7), Chair(1, 0.1, 0.2), Chair(2, 0.6, 0.2)}, {}};
  const std::vector<Duplicate> found = Duplicates(map);
  ASSERT_EQ(found.size(), 1U);  // chair 2 stands beside
  EXPECT_EQ(found.front().id, ObjectId(1));
  EXPECT_EQ(found.front().host, ObjectId(0));
}

TEST(SharedPlace, NobodyIntrudesFromAPartOfThePathThatNothingTies) {
  ObjectMap map{{Chair(0, 0, 0.7), Chair(1, 0.1, 0.2)}, {}};
  for (const int k : {0, 1}) {
    ViewRegistration view;
    view.frame = FrameIdx{k};
    map.objects[static_cast<std::size_t>(k)].views = {view};
  }
  Odometry odometry;
  for (const int k : {0, 1}) {
    TrackedFrame& frame = odometry.frames.emplace_back();
    frame.frame = frame.keyframe = FrameIdx{k};
    odometry.keyframes.push_back(FrameIdx{k});
  }
  const auto parts = [&odometry] { return PartsOfFrames(odometry, JoinsOf(odometry)); };
  EXPECT_EQ(SuspectDuplicates(map, {}, parts()).size(), 1U);
  odometry.frames[1].status = TrackingStatus::kLost;
  odometry.edges.push_back({FrameIdx{0}, FrameIdx{1}, {}, Matrix6d::Identity(), true});
  EXPECT_TRUE(SuspectDuplicates(map, {}, parts()).empty());
}

TEST(SharedPlace, TheSurestIsTheHostWhateverTheOrder) {
  for (const bool reversed : {false, true}) {
    ObjectMap map{{Chair(0, 0, 0.5), Chair(1, 0.1, 0.2), Chair(2, 0.2, 0.9)}, {}};
    if (reversed) std::reverse(map.objects.begin(), map.objects.end());
    const std::vector<Duplicate> found = Duplicates(map);
    ASSERT_EQ(found.size(), 1U);  // 0.5 is more than half of 0.9
    EXPECT_EQ(found.front().id, ObjectId(1));
    EXPECT_EQ(found.front().host, ObjectId(2));
  }
}

// 0.45 lies in 0.95's place and 0.2 in 0.45's, but 0.2 stands clear of 0.95.
TEST(SharedPlace, NothingStandsInWhatLeavesTheMap) {
  const ObjectMap map{{Chair(0, 0, 0.2), Chair(1, 0.2, 0.45), Chair(2, 0.4, 0.95)}, {}};
  const std::vector<Duplicate> found = Duplicates(map);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().id, ObjectId(1));
  EXPECT_EQ(found.front().host, ObjectId(2));
}

TEST(SharedPlace, EquallySureOnesAndOtherClassesStay) {
  EXPECT_TRUE(Duplicates({{Chair(0, 0, 0.7), Chair(1, 0.1, 0.6)}, {}}).empty());
  MapObject table = Chair(1, 0.1, 0.1);  // a chair pushed under it shares its place
  table.class_name = "table";
  EXPECT_TRUE(Duplicates({{Chair(0, 0, 0.7), table}, {}}).empty());
  LoopOptions off;
  off.merge_overlapping = false;
  EXPECT_TRUE(Duplicates({{Chair(0, 0, 0.7), Chair(1, 0.1, 0.2)}, {}}, off).empty());
}

TEST(SharedPlace, APieceOfASurerOneIsNoThingOfItsOwn) {
  MapObject shelf = Chair(0, 0.5, 0.9);
  shelf.class_name = "shelf";
  const ObjectMap map{{shelf, Chair(1, 1, 0.3)}, {}};
  const auto intrudes = [&](const std::vector<Eigen::Vector3f>& of_chair,
                            const ObjectMap& of_both) {
    LoopEvidence evidence;
    evidence[ObjectId(0)].model_points_world = Board(0, 0, 1);
    evidence[ObjectId(1)].depth_points_world = of_chair;
    return !FindDuplicates(SuspectDuplicates(of_both, {}), of_both, evidence).empty();
  };
  EXPECT_TRUE(intrudes(Board(0.5F, 0.03F, 0.5F), map));
  EXPECT_FALSE(intrudes(Board(0.7F, 0.03F, 0.5F), map)) << "two fifths of it stand beside";
  EXPECT_FALSE(intrudes(Board(0.5F, -0.15F, 0.5F), map)) << "stands before it";
  EXPECT_FALSE(intrudes({}, map));
  ObjectMap sure = map;
  sure.objects[1].confidence = 0.6;
  EXPECT_FALSE(intrudes(Board(0.5F, 0.03F, 0.5F), sure));
}

TEST(SharedPlace, NonsenseIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Duplicates({}).empty());
  EXPECT_TRUE(Duplicates({{Chair(0, nan, 0.7), Chair(1, 0, 0.2)}, {}}).empty());
  EXPECT_TRUE(Duplicates({{Chair(0, 0, nan), Chair(1, 0, 0.2)}, {}}).empty());
}

}  // namespace
}  // namespace deepslam::loop
