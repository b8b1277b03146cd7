// Openings in walls of rooms that cameras look around in.
#include "deepslam/layout/wall_openings.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"
#include "deepslam/layout/estimate_layout.h"
#include "layout/box_rooms.h"

namespace deepslam::layout {
namespace {

std::vector<Cuboid> Room() {
  std::vector<Cuboid> world;
  AddRoomWalls(-2, -1.5, 2, 1.5, world);
  AddCeiling(-2.2, -1.7, 2.2, 1.7, world);
  return world;
}

std::vector<Pose3> Views() {
  std::vector<Pose3> poses;
  LookAround(0.3, 0.2, poses);
  LookAround(-0.6, -0.3, poses);
  return poses;
}

std::vector<LayoutOpening> OpeningsOf(const std::vector<Cuboid>& world, double turned_rad = 0) {
  return EstimateLayout(SurfaceOf(world, Views(), turned_rad), LayoutOptions()).openings;
}

// A casing of 10 cm around a leaf of 0.9 x 2.0 m in the wall at y = 1.5.
void AddCasing(double from_m, double relief_m, std::vector<Cuboid>& world) {
  const double face_m = 1.5 - relief_m;
  AddBox({from_m - 0.1, face_m, 0}, {from_m, 1.6, 2.1}, world);
  AddBox({from_m + 0.9, face_m, 0}, {from_m + 1.0, 1.6, 2.1}, world);
  AddBox({from_m, face_m, 2.0}, {from_m + 0.9, 1.6, 2.1}, world);
}

TEST(FindOpenings, AClosedDoorIsToldByItsCasing) {
  for (const double turned : {0.0, 0.4}) {
    std::vector<Cuboid> world = Room();
    AddCasing(-0.3, 0.02, world);
    const std::vector<LayoutOpening> openings = OpeningsOf(world, turned);
    ASSERT_EQ(openings.size(), 1U) << turned;
    EXPECT_EQ(openings[0].kind, OpeningKind::kDoor);
    EXPECT_NEAR((openings[0].to_m - openings[0].from_m).norm(), 0.9, 0.11);
    EXPECT_NEAR(openings[0].top_m, 2.0, 0.11);
    EXPECT_NEAR(openings[0].bottom_m, 0, 0.03);
    const Eigen::Vector2d middle = 0.5 * (openings[0].from_m + openings[0].to_m);
    EXPECT_LT((middle - Eigen::Rotation2Dd(turned) * Eigen::Vector2d(0.15, 1.5)).norm(), 0.08);
  }
}

TEST(FindOpenings, PicturesShelvesAndPanelsAreNoDoors) {
  std::vector<Cuboid> world = Room();
  AddBox({-1.0, 1.47, 1.2}, {-0.4, 1.6, 1.9}, world);  // a picture
  AddBox({0.5, 1.47, 0}, {1.4, 1.6, 2.05}, world);     // a panel without a frame
  AddBox({-1.97, -1, 0}, {-1.9, 0.5, 0.1}, world);     // skirting
  AddBox({1.7, -0.5, 0}, {2.0, 0.3, 1.9}, world);      // a shelf against a wall
  for (const LayoutOpening& opening : OpeningsOf(world)) {
    EXPECT_NE(opening.kind, OpeningKind::kDoor)
        << opening.from_m.transpose() << " to " << opening.to_m.transpose();
  }
}

// A casing of which a side is missing is none.
TEST(FindOpenings, ACasingHasThreeSides) {
  std::vector<Cuboid> whole = Room();
  AddCasing(-0.3, 0.02, whole);
  const std::size_t num_walls = Room().size();
  for (std::size_t missing = num_walls; missing < whole.size(); ++missing) {
    std::vector<Cuboid> world = whole;
    world.erase(world.begin() + static_cast<std::ptrdiff_t>(missing));
    EXPECT_TRUE(OpeningsOf(world).empty()) << missing - num_walls;
  }
}

// A window whose blind was measured 6 cm behind the wall's face.
TEST(FindOpenings, AWindowIsToldByWhatIsSetBackInIt) {
  std::vector<Cuboid> world;
  AddWall({true, 1.5, -2.2, 2.2, 0.2, {{-0.6, 0.6, 0.9, 2.1}}}, world);
  AddWall({true, -1.5, -2.2, 2.2, -0.2, {}}, world);
  AddWall({false, -2, -1.7, 1.7, -0.2, {}}, world);
  AddWall({false, 2, -1.7, 1.7, 0.2, {}}, world);
  AddCeiling(-2.2, -1.7, 2.2, 1.7, world);
  AddBox({-0.7, 1.56, 0.8}, {0.7, 1.6, 2.2}, world);
  const std::vector<LayoutOpening> openings = OpeningsOf(world);
  ASSERT_EQ(openings.size(), 1U);
  EXPECT_EQ(openings[0].kind, OpeningKind::kWindow);
  EXPECT_NEAR((openings[0].to_m - openings[0].from_m).norm(), 1.2, 0.15);
  EXPECT_NEAR(openings[0].bottom_m, 0.9, 0.1);
  EXPECT_NEAR(openings[0].top_m, 2.1, 0.1);
}

// Cells of a face, for what cameras of boxes do not show: places without depth.
class Face {
 public:
  Face() {
    profile.num_slots = 80;
    profile.num_rows = 50;
    profile.cells.assign(80 * 50, kSolid | kFront);
    profile.offset_m.assign(80 * 50, 0);
    profile.is_wall.assign(80, 1);
    face = {0, 4, 0, 2.5, true};
  }
  void Set(int first_slot, int end_slot, int first_row, int end_row, std::uint8_t cell) {
    for (int slot = first_slot; slot < end_slot; ++slot) {
      for (int row = first_row; row < end_row; ++row) At(slot, row) = cell;
    }
  }
  void Move(int first_slot, int end_slot, int first_row, int end_row, float by_m) {
    for (int slot = first_slot; slot < end_slot; ++slot) {
      for (int row = first_row; row < end_row; ++row)
        profile.offset_m[static_cast<std::size_t>(slot * 50 + row)] += by_m;
    }
  }
  std::uint8_t& At(int slot, int row) {
    return profile.cells[static_cast<std::size_t>(slot * 50 + row)];
  }

  WallProfile profile;
  WallFace face;
};

// A closed leaf 5 cm deep, 0.9 x 2 m, of which a low cabinet hides the foot but for its first
// third.
TEST(FindOpenings, FurnitureHidesTheFootOfADoor) {
  Face face;
  face.Move(20, 38, 0, 40, -0.05F);
  face.Set(26, 60, 0, 9, kThing | kFront);
  const std::vector<FaceOpening> doors = FindOpenings(face.profile, face.face);
  ASSERT_EQ(doors.size(), 1U);
  EXPECT_EQ(doors[0].kind, OpeningKind::kDoor);
  EXPECT_NEAR(doors[0].from_m, 1.0, 1e-9);
  EXPECT_NEAR(doors[0].to_m, 1.9, 1e-9);
  EXPECT_NEAR(doors[0].bottom_m, 0, 1e-9);
  // The same of an open door.
  Face open;
  open.Set(20, 38, 0, 40, kOpen | kFront | kBehind);
  open.Set(26, 60, 0, 9, kThing | kFront);
  const std::vector<FaceOpening> gaps = FindOpenings(open.profile, open.face);
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].kind, OpeningKind::kDoor);
  EXPECT_NEAR(gaps[0].bottom_m, 0, 1e-9);
}

// Two doors of which nothing was measured above the wall between them are two.
TEST(FindOpenings, DoorsBesideEachOtherAreNotOne) {
  Face face;
  face.Set(10, 26, 0, 41, kOpen | kFront | kBehind);
  face.Set(46, 62, 0, 41, kOpen | kFront | kBehind);
  face.Set(10, 62, 38, 41, kBlind | kFront);
  const std::vector<FaceOpening> doors = FindOpenings(face.profile, face.face);
  ASSERT_EQ(doors.size(), 2U);
  for (const FaceOpening& door : doors) {
    EXPECT_EQ(door.kind, OpeningKind::kDoor);
    EXPECT_NEAR(door.to_m - door.from_m, 0.8, 1e-9);
  }
}

// A window over a strip of wall over a bed, behind which nothing was measured; one cell joins both.
TEST(FindOpenings, AWindowOverABedIsNoDoor) {
  Face face;
  face.Set(20, 44, 18, 42, kBlind | kFront);
  face.Set(20, 44, 0, 11, kBlind | kThing);
  face.Set(30, 31, 11, 18, kBlind | kFront);
  const std::vector<FaceOpening> openings = FindOpenings(face.profile, face.face);
  ASSERT_EQ(openings.size(), 1U);
  EXPECT_EQ(openings[0].kind, OpeningKind::kWindow);
  EXPECT_NEAR(openings[0].bottom_m, 0.9, 1e-9);
}

// Of a window the wall below is not seen behind a desk, or seen in a part: it is no door.
TEST(FindOpenings, AWindowBehindADeskIsNoDoor) {
  for (const int first_hidden : {20, 30}) {
    Face face;
    face.Move(20, 38, 16, 40, -0.05F);
    face.Set(first_hidden, 60, 0, 16, kThing | kFront);
    const std::vector<FaceOpening> openings = FindOpenings(face.profile, face.face);
    for (const FaceOpening& opening : openings) EXPECT_EQ(opening.kind, OpeningKind::kWindow);
  }
}

TEST(FindOpenings, AGapWithoutDepthIsAWindowUnlessAThingStandsThere) {
  Face glass;
  glass.Set(20, 44, 18, 42, kBlind);
  const std::vector<FaceOpening> windows = FindOpenings(glass.profile, glass.face);
  ASSERT_EQ(windows.size(), 1U);
  EXPECT_EQ(windows[0].kind, OpeningKind::kWindow);
  EXPECT_NEAR(windows[0].from_m, 1.0, 1e-9);
  EXPECT_NEAR(windows[0].to_m, 2.2, 1e-9);
  Face shelf = glass;
  shelf.Set(20, 44, 18, 42, kBlind);
  // Its boards, before the wall.
  for (const int row : {17, 25, 33, 42}) {
    for (int slot = 19; slot < 45; ++slot) shelf.At(slot, row) |= kThing;
  }
  EXPECT_TRUE(FindOpenings(shelf.profile, shelf.face).empty());
}

// Nothing was looked at above a gap down to the floor: between two jambs as far apart as a leaf is
// wide it is taken for a door and called doubtful; wider ones, and those that end at the ceiling,
// are passages.
TEST(FindOpenings, WithoutAnUpperEdgeTheWidthTellsADoor) {
  const auto told = [](int end_slot, double top_m, bool ceiling_seen) {
    Face face;
    face.Set(0, 80, 42, 50, 0);
    face.Set(20, end_slot, 0, 42, kOpen | kFront | kBehind);
    face.face.top_m = top_m;
    face.face.ceiling_seen = ceiling_seen;
    const std::vector<FaceOpening> openings = FindOpenings(face.profile, face.face);
    EXPECT_EQ(openings.size(), 1U);
    return openings.empty() ? FaceOpening() : openings[0];
  };
  Face whole;
  whole.Set(20, 38, 0, 42, kOpen | kFront | kBehind);
  const std::vector<FaceOpening> seen = FindOpenings(whole.profile, whole.face);
  ASSERT_EQ(seen.size(), 1U);
  const FaceOpening door = told(38, 2.5, false);
  EXPECT_EQ(door.kind, OpeningKind::kDoor);
  EXPECT_LE(door.confidence, 0.5);
  EXPECT_LT(door.confidence, seen[0].confidence);
  EXPECT_FALSE(door.note.empty());
  EXPECT_EQ(told(46, 2.5, false).kind, OpeningKind::kPassage);
  EXPECT_EQ(told(38, 2.1, true).kind, OpeningKind::kPassage);
}

// A dark wardrobe in the corner of a room: of it depth shows a side board alone.
TEST(FindOpenings, ADarkWardrobeIsNoDoor) {
  Face door;
  door.Set(60, 78, 0, 40, kBlind | kFront);
  ASSERT_EQ(FindOpenings(door.profile, door.face).size(), 1U);
  Face wardrobe = door;
  for (int row = 0; row < 40; ++row) wardrobe.At(60, row) |= kThing;
  EXPECT_TRUE(FindOpenings(wardrobe.profile, wardrobe.face).empty());
  // The board is that of a shelf beside a door.
  Face shelf = wardrobe;
  for (const int row : {8, 16, 24, 32, 39}) {
    for (int slot = 50; slot < 60; ++slot) shelf.At(slot, row) |= kThing;
  }
  EXPECT_EQ(FindOpenings(shelf.profile, shelf.face).size(), 1U);
}

// Places behind a dark table reach up beside the sill, and hang together with the window.
TEST(FindOpenings, AWindowIsToldApartFromWhatIsBehindFurniture) {
  Face face;
  face.Set(16, 40, 18, 42, kBlind | kFront);
  face.Set(30, 60, 0, 12, kBlind);
  face.Set(32, 40, 12, 18, kBlind);
  const std::vector<FaceOpening> windows = FindOpenings(face.profile, face.face);
  ASSERT_EQ(windows.size(), 1U);
  EXPECT_EQ(windows[0].kind, OpeningKind::kWindow);
  EXPECT_NEAR(windows[0].from_m, 0.8, 1e-9);
  EXPECT_NEAR(windows[0].to_m, 2.0, 1e-9);
  EXPECT_NEAR(windows[0].bottom_m, 0.9, 1e-9);
}

// Depth is missing where a corner of a room meets the upper border of what was looked at.
TEST(FindOpenings, WhatEndsInACornerAndInNothingIsAWindowOnlyOfItsSize) {
  const auto num_told = [](int first_slot, int first_row, int end_row) {
    Face face;
    face.Set(0, 80, 44, 50, 0);
    face.Set(first_slot, 80, first_row, end_row, kBlind | kFront);
    return FindOpenings(face.profile, face.face).size();
  };
  EXPECT_EQ(num_told(40, 34, 44), 0U) << "a strip";
  EXPECT_EQ(num_told(71, 20, 44), 0U) << "narrow";
  EXPECT_EQ(num_told(54, 18, 44), 1U);
  EXPECT_EQ(num_told(40, 34, 43), 0U);
}

TEST(FindOpenings, SashesOfOneHeightAreOneWindow) {
  Face face;
  face.Set(10, 28, 18, 42, kBlind);
  face.Set(30, 48, 18, 42, kBlind);
  face.Set(60, 72, 24, 36, kBlind);  // one of another height
  const std::vector<FaceOpening> windows = FindOpenings(face.profile, face.face);
  ASSERT_EQ(windows.size(), 2U);
  EXPECT_NEAR(windows[0].from_m, 0.5, 1e-9);
  EXPECT_NEAR(windows[0].to_m, 2.4, 1e-9);
  EXPECT_NEAR(windows[1].from_m, 3.0, 1e-9);
}

// Noise as a depth camera's: no casings in it, and one of 3 cm is still seen.
TEST(FindOpenings, CasingsAreToldFromNoise) {
  Random random(7);
  int num_told = 0;
  for (int n = 0; n < 20; ++n) {
    Face face;
    for (float& offset_m : face.profile.offset_m)
      offset_m = static_cast<float>(0.01 * random.Normal());
    EXPECT_TRUE(FindOpenings(face.profile, face.face).empty()) << n;
    face.Move(28, 30, 0, 42, 0.03F);
    face.Move(48, 50, 0, 42, 0.03F);
    face.Move(30, 48, 40, 42, 0.03F);
    const std::vector<FaceOpening> doors = FindOpenings(face.profile, face.face);
    num_told += doors.size() == 1 && doors[0].kind == OpeningKind::kDoor ? 1 : 0;
  }
  EXPECT_GE(num_told, 18);
}

TEST(FindOpenings, OfAFaceOfNothingFindsNothing) {
  EXPECT_TRUE(FindOpenings(WallProfile(), WallFace()).empty());
  Face unseen;
  unseen.Set(0, 80, 0, 50, 0);
  EXPECT_TRUE(FindOpenings(unseen.profile, unseen.face).empty());
}

}  // namespace
}  // namespace deepslam::layout
