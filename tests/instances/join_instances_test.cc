#include "deepslam/instances/join_instances.h"

#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace deepslam::instances {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Place {
  double x_m, y_m, bottom_m, top_m;
};

Instance Thing(const std::string& class_name, bool is_named, Place place, Eigen::Vector2d size_m) {
  Instance instance;
  instance.class_name = class_name;
  instance.is_named = is_named;
  instance.box_level = {
      {place.x_m, place.y_m}, 0, size_m.x(), size_m.y(), place.bottom_m, place.top_m};
  return instance;
}

TEST(WholesOf, PartsOfOneClassInOnePlaceAreOneThing) {
  EXPECT_THAT(WholesOf(std::vector{Thing("toilet", true, {0, 0, 0, 0.5}, {0.4, 0.7}),
                                   Thing("toilet", true, {0, 0.1, 0.1, 0.6}, {0.4, 0.5})}),
              ElementsAre(0, 0));
  // Nobody names them, and the one stands in the other.
  EXPECT_THAT(WholesOf(std::vector{Thing("cabinet", false, {0, 0, 0, 0.8}, {1.2, 0.6}),
                                   Thing("furniture", false, {0.3, 0, 0.1, 0.6}, {0.4, 0.5})}),
              ElementsAre(0, 0));
  // Two chairs side by side, and a chair under a table.
  EXPECT_THAT(WholesOf(std::vector{Thing("chair", true, {0, 0, 0, 0.9}, {0.5, 0.5}),
                                   Thing("chair", true, {0.4, 0, 0, 0.9}, {0.5, 0.5}),
                                   Thing("table", true, {0.2, 0, 0, 0.9}, {1.5, 0.8})}),
              ElementsAre(0, 1, 2));
}

TEST(WholesOf, ABackOnTheEdgeOfASeatIsOfThatChair) {
  const Instance seat = Thing("chair", true, {0, 0, 0, 0.48}, {0.45, 0.45});
  const Instance back = Thing("chair", true, {0, 0.24, 0.5, 0.9}, {0.42, 0.05});
  EXPECT_THAT(WholesOf(std::vector{seat, back}), ElementsAre(0, 0));
  // The back of another chair behind it is not; nor is what hangs over it.
  const Instance behind = Thing("chair", true, {0, 0.45, 0.5, 0.9}, {0.42, 0.05});
  const Instance above = Thing("chair", true, {0, 0.2, 1.2, 1.6}, {0.42, 0.05});
  EXPECT_THAT(WholesOf(std::vector{seat, behind, above}), ElementsAre(0, 1, 2));
}

// The stem between them is thinner than a voxel, so that nothing of it is on the surface.
TEST(WholesOf, APotAndTheLeavesOverItAreOnePlant) {
  const Instance pot = Thing("plant", true, {0, 0, 0, 0.31}, {0.25, 0.25});
  const Instance leaves = Thing("plant", true, {0.05, 0, 0.57, 1.15}, {0.6, 0.5});
  EXPECT_THAT(WholesOf(std::vector{pot, leaves}), ElementsAre(0, 0));
  EXPECT_THAT(WholesOf(std::vector{leaves, pot}), ElementsAre(0, 0));
  const Instance beside = Thing("plant", true, {0.5, 0, 0.57, 1.15}, {0.6, 0.5});
  const Instance hanging = Thing("plant", true, {0.05, 0, 0.9, 1.5}, {0.6, 0.5});
  EXPECT_THAT(WholesOf(std::vector{pot, beside, hanging}), ElementsAre(0, 1, 2));
}

TEST(WholesOf, LegsAreOfTheTopThatTheyCarry) {
  Instance table = Thing("table", true, {0, 0, 0, 0.75}, {1.6, 0.9});
  table.has_support_plane = true;
  Instance leg = Thing("cabinet", false, {0.7, 0.35, 0.1, 0.68}, {0.1, 0.08});
  leg.rejection = "small";
  EXPECT_THAT(WholesOf(std::vector{table, leg}), ElementsAre(0, 0));
  EXPECT_THAT(WholesOf(std::vector{leg, table}), ElementsAre(0, 0));
  // A trestle is wide and thin, whatever detections call it.
  const Instance trestle = Thing("chair", true, {0.6, 0, 0.05, 0.62}, {0.1, 0.5});
  EXPECT_THAT(WholesOf(std::vector{table, trestle}), ElementsAre(0, 0));
  const Instance screen_at_the_end = Thing("cabinet", false, {0.78, 0, 0.05, 0.62}, {0.1, 0.5});
  EXPECT_THAT(WholesOf(std::vector{table, screen_at_the_end}), ElementsAre(0, 1));
  // What ends well below the top, rises above it, is wide or stands beside it is another thing.
  const Instance post_of_a_seat = Thing("chair", true, {0.7, 0.35, 0, 0.45}, {0.1, 0.08});
  const Instance back = Thing("chair", true, {0.7, 0.35, 0.4, 0.9}, {0.05, 0.18});
  const Instance drawers = Thing("cabinet", false, {0.5, 0.2, 0, 0.7}, {0.4, 0.5});
  const Instance beside = Thing("cabinet", false, {0.95, 0.35, 0.1, 0.68}, {0.1, 0.08});
  for (const Instance& other : {post_of_a_seat, back, drawers, beside})
    EXPECT_THAT(WholesOf(std::vector{table, other}), ElementsAre(0, 1));
}

TEST(WholesOf, BoardsAboveOneAnotherAreARack) {
  const Instance low = Thing("cabinet", false, {0, 0, 0.1, 0.3}, {0.9, 0.3});
  const Instance high = Thing("cabinet", false, {0.02, 0, 0.6, 0.9}, {0.88, 0.28});
  EXPECT_THAT(WholesOf(std::vector{low, high}), ElementsAre(0, 0));
  // Each alone may be too little to be a thing.
  Instance board = high;
  board.rejection = "only 0.28 m deep";
  EXPECT_THAT(WholesOf(std::vector{low, board}), ElementsAre(0, 0));
  EXPECT_THAT(WholesOf(std::vector{board, board}), ElementsAre(0, 0));
  // Pictures above one another hang on a wall.
  Instance picture = Thing("cabinet", false, {0, 0, 0.8, 1.2}, {0.5, 0.03});
  picture.rejection = "only 0.03 m deep";
  Instance above = Thing("cabinet", false, {0, 0, 1.3, 1.7}, {0.5, 0.03});
  above.rejection = "only 0.03 m deep";
  EXPECT_THAT(WholesOf(std::vector{picture, above}), ElementsAre(0, 1));
  // Its size may call the upper one something else.
  Instance other = high;
  other.class_name = "furniture";
  EXPECT_THAT(WholesOf(std::vector{low, other}), ElementsAre(0, 0));
  // A box on a cabinet is another thing, and so is a wall cabinet that hangs over a counter.
  EXPECT_THAT(WholesOf(std::vector{low, Thing("cabinet", false, {0, 0, 0.32, 0.5}, {0.4, 0.3})}),
              ElementsAre(0, 1));
  EXPECT_THAT(WholesOf(std::vector{low, Thing("cabinet", false, {0, 0, 1.3, 1.9}, {0.9, 0.3})}),
              ElementsAre(0, 1));
  // What detectors name is told apart by them.
  Instance named = high;
  named.is_named = true;
  EXPECT_THAT(WholesOf(std::vector{low, named}), ElementsAre(0, 1));
}

TEST(WholesOf, OverlappingEndsOfOneRowAreOneThing) {
  const Instance left = Thing("cabinet", false, {0, 0, 0, 0.52}, {0.85, 0.16});
  const Instance right = Thing("furniture", false, {0.55, 0.01, 0.05, 0.53}, {0.85, 0.15});
  EXPECT_THAT(WholesOf(std::vector{left, right}), ElementsAre(0, 0));
  EXPECT_THAT(WholesOf(std::vector{right, left}), ElementsAre(0, 0));
  // Beside one another, of another height, before one another, round a corner: two things each.
  EXPECT_THAT(
      WholesOf(std::vector{left, Thing("cabinet", false, {0.83, 0, 0, 0.52}, {0.85, 0.16})}),
      ElementsAre(0, 1));
  EXPECT_THAT(WholesOf(std::vector{left, Thing("cabinet", false, {0.55, 0, 0, 0.7}, {0.85, 0.16})}),
              ElementsAre(0, 1));
  EXPECT_THAT(
      WholesOf(std::vector{left, Thing("cabinet", false, {0.55, 0.1, 0, 0.52}, {0.85, 0.16})}),
      ElementsAre(0, 1));
  EXPECT_THAT(WholesOf(std::vector{Thing("cabinet", false, {0, 0, 0, 0.9}, {2.4, 0.6}),
                                   Thing("cabinet", false, {0.9, 0.7, 0, 0.9}, {0.6, 2.0})}),
              ElementsAre(0, 1));
  // Chairs pushed together are named.
  EXPECT_THAT(WholesOf(std::vector{Thing("chair", true, {0, 0, 0, 0.9}, {0.5, 0.5}),
                                   Thing("chair", true, {0.35, 0, 0, 0.9}, {0.5, 0.5})}),
              ElementsAre(0, 1));
}

TEST(WholesOf, SeveralPartsHaveTheFirstForTheirWhole) {
  const auto part = [](double bottom_m) {
    return Thing("cabinet", false, {0, 0, bottom_m, bottom_m + 0.1}, {0.9, 0.3});
  };
  EXPECT_THAT(WholesOf(std::vector{part(0.1), part(0.5), part(0.9)}), ElementsAre(0, 0, 0));
}

TEST(WholesOf, WhatIsRejectedIsNobodysPart) {
  Instance small = Thing("chair", true, {0, 0, 0, 0.4}, {0.5, 0.5});
  const Instance chair = small;
  small.rejection = "small";
  EXPECT_THAT(WholesOf(std::vector{chair, small, chair}), ElementsAre(0, 1, 0));
  EXPECT_THAT(WholesOf({}), IsEmpty());
  // Boxes without any extent are no reason to divide by nothing.
  const Instance point = Thing("chair", true, {0, 0, 0, 0}, {0, 0});
  EXPECT_THAT(WholesOf(std::vector{point, point}), ElementsAre(0, 0));
}

ClassTable Stands() {
  ClassTable table;
  table.classes = {
      {"sink", {"sink"}, {}, 0.25, 1.5, 0.1, 1.1, {}, {.supports = {.wall = true}}},
      {"plant", {"potted plant"}, {}, 0.1, 2, 0.1, 2, {}, {.yaw_free = true}},
      {"vase", {"vase"}, {}, 0.1, 1, 0.1, 1, {}, {.yaw_free = true}},
      {"table", {"table"}, {}, 0.4, 4, 0.3, 1.2, {}, {.support_plane = true, .yaw_free = true}},
      {"tv", {"tv"}, {}, 0.4, 2, 0.2, 1.4, {}, {.supports = {.floor = false}}}};
  return table;
}

TEST(RestsOf, WhatIsShorterThanAnySofaIsOfTheOneBesideIt) {
  ClassTable classes = Stands();
  classes.classes.push_back(
      {"sofa", {"couch"}, {}, 0.7, 3.6, 0.5, 1.3, {}, {.solid_inside = true}});
  classes.classes.push_back({"chair", {"chair"}, {}, 0.45, 1.5, 0.4, 1.4, {}, {}});
  const Instance sofa = Thing("sofa", true, {0, 0, 0, 0.83}, {1.58, 0.9});
  const Instance arm = Thing("sofa", true, {1.0, 0.2, 0, 0.5}, {0.08, 0.36});
  EXPECT_THAT(RestsOf(std::vector{sofa, arm}, classes), ElementsAre(-1, 0));
  EXPECT_THAT(RestsOf(std::vector{arm, sofa}, classes), ElementsAre(1, -1));
  // Far off, of another class, a sofa of its own, unnamed, beside a sofa of full length.
  const auto none = ElementsAre(-1, -1);
  EXPECT_THAT(
      RestsOf(std::vector{sofa, Thing("sofa", true, {1.4, 0, 0, 0.5}, {0.08, 0.36})}, classes),
      none);
  EXPECT_THAT(
      RestsOf(std::vector{sofa, Thing("chair", true, {1, 0, 0, 0.5}, {0.08, 0.36})}, classes),
      none);
  EXPECT_THAT(
      RestsOf(std::vector{sofa, Thing("sofa", true, {1.3, 0, 0, 0.8}, {0.8, 0.8})}, classes), none);
  EXPECT_THAT(
      RestsOf(std::vector{sofa, Thing("sofa", false, {1, 0, 0, 0.5}, {0.08, 0.36})}, classes),
      none);
  EXPECT_THAT(RestsOf(std::vector{Thing("sofa", true, {0, 0, 0, 0.83}, {3.5, 0.9}),
                                  Thing("sofa", true, {1.95, 0, 0, 0.5}, {0.08, 0.36})},
                      classes),
              none);
  // Backs of chairs beside one another are of two chairs.
  EXPECT_THAT(RestsOf(std::vector{Thing("chair", true, {0, 0, 0, 0.9}, {0.5, 0.5}),
                                  Thing("chair", true, {0.5, 0, 0.5, 0.9}, {0.05, 0.4})},
                      classes),
              none);
}

TEST(CarriedByFeet, APedestalIsOfTheBasinOnIt) {
  const Instance basin = Thing("sink", true, {0, 0, 0.65, 0.9}, {0.46, 0.56});
  const Instance pedestal = Thing("cabinet", false, {0.02, 0, 0.06, 0.72}, {0.35, 0.3});
  EXPECT_THAT(CarriedByFeet(std::vector{basin, pedestal}, Stands()), ElementsAre(-1, 0));
  EXPECT_THAT(CarriedByFeet(std::vector{pedestal, basin}, Stands()), ElementsAre(1, -1));
}

TEST(CarriedByFeet, WhatIsWiderOrEndsElsewhereIsNone) {
  const Instance basin = Thing("sink", true, {0, 0, 0.75, 0.9}, {0.46, 0.46});
  const Instance row = Thing("cabinet", false, {0.4, 0, 0, 0.88}, {1.8, 0.6});
  const Instance bin = Thing("cabinet", false, {0, 0, 0, 0.4}, {0.3, 0.3});
  const Instance beside = Thing("cabinet", false, {0.4, 0, 0, 0.7}, {0.3, 0.3});
  const Instance hung = Thing("cabinet", false, {0, 0, 0.4, 0.7}, {0.3, 0.3});
  const Instance named = Thing("tv", true, {0, 0, 0, 0.7}, {0.3, 0.3});
  EXPECT_THAT(CarriedByFeet(std::vector{basin, row, bin, beside, hung, named}, Stands()),
              ElementsAre(-1, -1, -1, -1, -1, -1));
}

TEST(CarriedByFeet, WhatMayStandOnFurnitureKeepsItApart) {
  const Instance below = Thing("cabinet", false, {0, 0, 0, 0.5}, {0.3, 0.3});
  for (const char* name : {"plant", "table", "tv", "no class"}) {
    const Instance above = Thing(name, true, {0, 0, 0.5, 0.9}, {0.5, 0.5});
    EXPECT_THAT(CarriedByFeet(std::vector{above, below}, Stands()), ElementsAre(-1, -1)) << name;
  }
}

TEST(CarriedByFeet, AVaseOfWhichThePlantHasAPartIsItsPot) {
  const Instance plant = Thing("plant", true, {0, 0, 0.05, 0.86}, {0.5, 0.56});
  const Instance vase = Thing("vase", true, {0.05, 0, 0.02, 0.31}, {0.3, 0.27});
  EXPECT_THAT(CarriedByFeet(std::vector{plant, vase}, Stands()), ElementsAre(-1, 0));
  const Instance up_in_it = Thing("vase", true, {0.05, 0, 0.5, 0.8}, {0.3, 0.27});
  const Instance beside = Thing("vase", true, {0.4, 0, 0.02, 0.31}, {0.3, 0.27});
  EXPECT_THAT(CarriedByFeet(std::vector{plant, up_in_it, beside}, Stands()),
              ElementsAre(-1, -1, -1));
}

TEST(CarriedByFeet, ASeatGoesWithTheBackThatDetectionsName) {
  ClassTable classes = Stands();
  classes.classes.push_back({"chair", {"chair"}, {}, 0.45, 1.5, 0.4, 1.4, {}, {}});
  const Instance seat = Thing("cabinet", false, {0, 0, 0.02, 0.46}, {0.28, 0.44});
  Instance rail = Thing("chair", true, {-0.26, 0.05, 0.72, 0.82}, {0.04, 0.31});
  rail.rejection = "small";
  EXPECT_THAT(CarriedByFeet(std::vector{rail, seat}, classes), ElementsAre(-1, 0));
  // Too far off, at the seat's height, or of a chair as a whole, beside which it stands.
  const Instance off = Thing("chair", true, {-0.6, 0, 0.72, 0.82}, {0.04, 0.31});
  const Instance low = Thing("chair", true, {-0.26, 0, 0.3, 0.46}, {0.04, 0.31});
  const Instance whole = Thing("chair", true, {-0.3, 0, 0.44, 0.82}, {0.3, 0.31});
  const Instance leaf = Thing("plant", true, {-0.26, 0.05, 0.72, 0.82}, {0.04, 0.31});
  for (const Instance& other : {off, low, whole, leaf})
    EXPECT_THAT(CarriedByFeet(std::vector{other, seat}, classes), ElementsAre(-1, -1));
  const Instance dresser = Thing("cabinet", false, {0, 0, 0.02, 0.8}, {0.5, 1.6});
  EXPECT_THAT(CarriedByFeet(std::vector{rail, dresser}, classes), ElementsAre(-1, -1));
}

TEST(CarriedByFeet, AVaseUnderAPlantIsItsPot) {
  const Instance leaves = Thing("plant", true, {0, 0, 0.46, 1.14}, {0.6, 0.6});
  const Instance vase = Thing("vase", true, {0.05, 0, 0, 0.32}, {0.26, 0.3});
  EXPECT_THAT(CarriedByFeet(std::vector{leaves, vase}, Stands()), ElementsAre(-1, 0));
  // On a table, beside it, under a basin, or a table under it.
  const Instance on_table = Thing("vase", true, {0.05, 0, 0.3, 0.46}, {0.26, 0.3});
  const Instance beside = Thing("vase", true, {0.5, 0, 0, 0.32}, {0.26, 0.3});
  const Instance table = Thing("table", true, {0, 0, 0, 0.45}, {0.5, 0.5});
  EXPECT_THAT(CarriedByFeet(std::vector{leaves, on_table, beside, table}, Stands()),
              ElementsAre(-1, -1, -1, -1));
  const Instance basin = Thing("sink", true, {0, 0, 0.46, 0.9}, {0.6, 0.6});
  EXPECT_THAT(CarriedByFeet(std::vector{basin, vase}, Stands()), ElementsAre(-1, -1));
}

TEST(CarriedByFeet, NothingBecomesHigherThanItsClass) {
  const Instance basin = Thing("sink", true, {0, 0, 1.0, 1.2}, {0.46, 0.56});
  const Instance below = Thing("cabinet", false, {0, 0, 0, 1.0}, {0.3, 0.3});
  EXPECT_THAT(CarriedByFeet(std::vector{basin, below}, Stands()), ElementsAre(-1, -1));
}

}  // namespace
}  // namespace deepslam::instances
