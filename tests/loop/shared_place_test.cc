#include "deepslam/loop/shared_place.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

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

TEST(SharedPlace, IntrudersStandInASurerOneOfTheirClass) {
  const ObjectMap map{{Chair(0, 0, 0.7), Chair(1, 0.1, 0.2), Chair(2, 0.6, 0.2)}, {}};
  const std::vector<Intruder> found = FindIntruders(map, {});
  ASSERT_EQ(found.size(), 1U);  // chair 2 stands beside
  EXPECT_EQ(found.front().id, ObjectId(1));
  EXPECT_EQ(found.front().host, ObjectId(0));
}

TEST(SharedPlace, TheSurestIsTheHostWhateverTheOrder) {
  for (const bool reversed : {false, true}) {
    ObjectMap map{{Chair(0, 0, 0.5), Chair(1, 0.1, 0.2), Chair(2, 0.2, 0.9)}, {}};
    if (reversed) std::reverse(map.objects.begin(), map.objects.end());
    const std::vector<Intruder> found = FindIntruders(map, {});
    ASSERT_EQ(found.size(), 1U);  // 0.5 is more than half of 0.9
    EXPECT_EQ(found.front().id, ObjectId(1));
    EXPECT_EQ(found.front().host, ObjectId(2));
  }
}

TEST(SharedPlace, EquallySureOnesAndOtherClassesStay) {
  EXPECT_TRUE(FindIntruders({{Chair(0, 0, 0.7), Chair(1, 0.1, 0.6)}, {}}, {}).empty());
  MapObject table = Chair(1, 0.1, 0.1);  // a chair pushed under it shares its place
  table.class_name = "table";
  EXPECT_TRUE(FindIntruders({{Chair(0, 0, 0.7), table}, {}}, {}).empty());
  LoopOptions off;
  off.merge_overlapping = false;
  EXPECT_TRUE(FindIntruders({{Chair(0, 0, 0.7), Chair(1, 0.1, 0.2)}, {}}, off).empty());
}

TEST(SharedPlace, NonsenseIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(FindIntruders({}, {}).empty());
  EXPECT_TRUE(FindIntruders({{Chair(0, nan, 0.7), Chair(1, 0, 0.2)}, {}}, {}).empty());
  EXPECT_TRUE(FindIntruders({{Chair(0, 0, nan), Chair(1, 0, 0.2)}, {}}, {}).empty());
}

}  // namespace
}  // namespace deepslam::loop
