#include "deepslam/scene/object_class.h"

#include <gtest/gtest.h>

namespace deepslam {
namespace {

ClassTable Table() {
  ClassTable table;
  table.classes.resize(2);
  table.classes[0].name = "table";
  table.classes[0].detector_labels = {"dining table", "desk"};
  table.classes[0].traits.support_plane = true;
  table.classes[1].name = "thing";
  return table;
}

TEST(ClassTable, FindsByNameAndByLabel) {
  const ClassTable table = Table();
  EXPECT_EQ(table.Find("table"), &table.classes[0]);
  EXPECT_EQ(table.Find("desk"), nullptr) << "a label is no name";
  EXPECT_EQ(table.FindByLabel("desk"), &table.classes[0]);
  EXPECT_EQ(table.FindByLabel("table"), nullptr) << "a name is no label";
}

TEST(ClassTable, ANameThatItDoesNotHaveHasTheUsualTraits) {
  const ClassTable table = Table();
  EXPECT_TRUE(table.TraitsOf("table").support_plane);
  EXPECT_EQ(table.TraitsOf("furniture"), ClassTraits());
  EXPECT_EQ(ClassTable().TraitsOf("table"), ClassTraits()) << "names say nothing by themselves";
}

TEST(Supports, AThingRestsWhereItsClassMay) {
  constexpr double kGap_m = 0.25;
  const Supports floor;
  const Supports furniture = {.floor = false, .furniture = true};
  const Supports wall = {.floor = false, .wall = true};
  const Supports either = {.furniture = true};
  for (const double foot_m : {0.0, 0.7, 2.0}) {
    EXPECT_FALSE(floor.RestsElsewhere(foot_m, kGap_m)) << foot_m;
    EXPECT_TRUE(furniture.RestsElsewhere(foot_m, kGap_m)) << foot_m;
    EXPECT_TRUE(wall.RestsElsewhere(foot_m, kGap_m)) << foot_m;
    EXPECT_EQ(either.RestsElsewhere(foot_m, kGap_m), foot_m > kGap_m) << foot_m;
  }
}

TEST(ClassTable, HasAFallbackWhereAClassIsOne) {
  ClassTable table = Table();
  EXPECT_EQ(table.Fallback(), nullptr);
  table.classes[1].traits.fallback = true;
  EXPECT_EQ(table.Fallback(), &table.classes[1]);
}

}  // namespace
}  // namespace deepslam
