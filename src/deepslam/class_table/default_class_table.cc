#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/class_table/class_table_yaml.h"

namespace deepslam::class_table {
namespace {

constexpr Supports kFloor = {};
constexpr Supports kFloorOrFurniture = {.furniture = true};
constexpr Supports kFloorOrWall = {.wall = true};
constexpr Supports kFurniture = {.floor = false, .furniture = true};
constexpr Supports kFurnitureOrWall = {.floor = false, .furniture = true, .wall = true};
constexpr Supports kAnything = {.furniture = true, .wall = true};

using Strings = std::vector<std::string>;

// Sizes span what shops sell, with a tenth to spare for measuring.
std::vector<ObjectClass> Furniture() {
  constexpr ClassTraits kTable = {.support_plane = true, .yaw_free = true};
  constexpr ClassTraits kClosed = {.solid_inside = true};
  constexpr ClassTraits kClosedOnFloorOrWall = {.supports = kFloorOrWall, .solid_inside = true};
  constexpr ClassTraits kRest = {
      .supports = kAnything, .solid_inside = true, .yaw_free = true, .fallback = true};
  const Strings table_labels = {"dining table", "table", "desk"};
  return {
      {"chair", {"chair"}, {"chair"}, 0.45, 1.5, 0.4, 1.4, {230, 126, 34}, {}},
      {"table", table_labels, {"table", "desk"}, 0.4, 4.0, 0.3, 1.2, {52, 152, 219}, kTable},
      {"sofa", {"couch", "sofa"}, {"sofa"}, 0.7, 3.6, 0.5, 1.3, {155, 89, 182}, kClosed},
      {"bed", {"bed"}, {"bed"}, 1.2, 2.7, 0.25, 2.0, {231, 76, 60}, kClosed},
      {"cabinet", {}, {"cabinet"}, 0.3, 2.6, 0.3, 2.5, {39, 174, 96}, kClosedOnFloorOrWall},
      {"shelf", {}, {"shelf"}, 0.5, 3.0, 0.5, 2.7, {26, 188, 156}, kClosed},
      {"furniture",
       {},
       {"cabinet", "table", "shelf", "desk"},
       0.2,
       3.5,
       0.15,
       2.7,
       {149, 165, 166},
       kRest},
  };
}

// What furnishes a home besides, by COCO's names. There are no models of these: they are as they
// were measured.
std::vector<ObjectClass> HouseholdThings() {
  constexpr ClassTraits kFusedOnFloor = {.fused_only = true};
  constexpr ClassTraits kClosedOnFloor = {.solid_inside = true, .fused_only = true};
  constexpr ClassTraits kClosedAnywhere = {
      .supports = kFloorOrFurniture, .solid_inside = true, .fused_only = true};
  constexpr ClassTraits kScreen = {.supports = kFurnitureOrWall, .fused_only = true};
  constexpr ClassTraits kLaid = {.supports = kFurniture, .fused_only = true};
  constexpr ClassTraits kClosedOnTop = {
      .supports = kFurnitureOrWall, .solid_inside = true, .fused_only = true};
  constexpr ClassTraits kBasin = {.supports = kAnything, .built_in = true, .fused_only = true};
  constexpr ClassTraits kRoundAnywhere = {
      .supports = kFloorOrFurniture, .yaw_free = true, .fused_only = true};
  constexpr ClassTraits kClock = {.supports = kAnything, .solid_inside = true, .fused_only = true};
  return {
      {"tv", {"tv"}, {}, 0.4, 2.3, 0.25, 1.4, {44, 62, 80}, kScreen},
      {"laptop", {"laptop"}, {}, 0.25, 0.55, 0.02, 0.45, {93, 109, 126}, kLaid},
      {"refrigerator", {"refrigerator"}, {}, 0.5, 2.3, 0.5, 2.3, {174, 214, 241}, kClosedOnFloor},
      {"oven", {"oven"}, {}, 0.4, 1.4, 0.3, 1.4, {120, 40, 31}, kClosedAnywhere},
      {"microwave", {"microwave"}, {}, 0.3, 0.75, 0.2, 0.55, {176, 58, 46}, kClosedOnTop},
      {"toaster", {"toaster"}, {}, 0.2, 0.55, 0.12, 0.4, {236, 112, 99}, kClosedOnTop},
      {"sink", {"sink"}, {}, 0.25, 1.5, 0.1, 1.1, {127, 179, 213}, kBasin},
      {"toilet", {"toilet"}, {}, 0.4, 1.1, 0.3, 1.1, {214, 234, 248}, kClosedOnFloor},
      {"plant", {"potted plant"}, {}, 0.15, 2.7, 0.1, 2.7, {100, 160, 60}, kRoundAnywhere},
      {"bench", {"bench"}, {}, 0.5, 3.0, 0.3, 1.3, {186, 74, 0}, kFusedOnFloor},
      {"suitcase", {"suitcase"}, {}, 0.3, 1.1, 0.2, 1.1, {110, 44, 0}, kClosedAnywhere},
      {"bicycle", {"bicycle"}, {}, 0.8, 2.1, 0.5, 1.4, {241, 196, 15}, kFusedOnFloor},
      {"clock", {"clock"}, {}, 0.1, 2.4, 0.1, 2.4, {212, 172, 13}, kClock},
      {"vase", {"vase"}, {}, 0.1, 1.3, 0.1, 1.3, {187, 143, 206}, kRoundAnywhere},
      {"lamp", {"lamp"}, {}, 0.2, 2.3, 0.2, 2.3, {249, 231, 159}, kRoundAnywhere},
  };
}

// Rows of lower cabinets under one top, longer than a cabinet: their joints are too fine for depth.
// Tops are 0.85 to 0.95 m high.
std::vector<ObjectClass> FittedKitchens() {
  constexpr ClassTraits kClosed = {.solid_inside = true};
  return {{"counter", {}, {"cabinet"}, 1.2, 5.0, 0.7, 1.1, {22, 120, 80}, kClosed}};
}

// What stage `export` says of a class. Densities are masses of common products over the volume of
// their closed outside, which our shapes fill: a chair of 5 kg in 0.02 m3 of legs, seat and back, a
// sofa of 60 kg in 1 m3, a refrigerator of 60 kg in 0.7 m3. An id of 0: the set has no such class.
struct ExportColumns {
  std::string_view class_name;
  ClassLabel coco;
  ClassLabel nyu40;
  ClassLabel scannet200;
  ClassPhysics physics;
};

std::vector<ExportColumns> ColumnsOfExport() {
  constexpr bool kFixed = true;
  return {
      {"chair", {62, "chair"}, {5, "chair"}, {2, "chair"}, {250}},
      {"table", {67, "dining table"}, {7, "table"}, {4, "table"}, {300}},
      {"sofa", {63, "couch"}, {6, "sofa"}, {6, "couch"}, {60}},
      {"bed", {65, "bed"}, {4, "bed"}, {11, "bed"}, {60}},
      {"cabinet", {}, {3, "cabinet"}, {7, "cabinet"}, {150}},
      {"shelf", {}, {15, "shelves"}, {8, "shelf"}, {150}},
      {"furniture", {}, {39, "otherfurniture"}, {213, "furniture"}, {150}},
      {"tv", {72, "tv"}, {25, "television"}, {33, "tv"}, {250}},
      {"laptop", {73, "laptop"}, {40, "otherprop"}, {77, "laptop"}, {500}},
      {"refrigerator", {82, "refrigerator"}, {24, "refridgerator"}, {27, "refrigerator"}, {90}},
      {"oven", {79, "oven"}, {}, {84, "oven"}, {160, kFixed}},
      {"microwave", {78, "microwave"}, {40, "otherprop"}, {59, "microwave"}, {220}},
      {"toaster", {80, "toaster"}, {40, "otherprop"}, {148, "toaster"}, {150}},
      {"sink", {81, "sink"}, {34, "sink"}, {14, "sink"}, {250, kFixed}},
      {"toilet", {70, "toilet"}, {33, "toilet"}, {17, "toilet"}, {300, kFixed}},
      {"plant", {64, "potted plant"}, {40, "otherprop"}, {40, "plant"}, {100}},
      {"bench", {15, "bench"}, {}, {68, "bench"}, {250}},
      {"suitcase", {33, "suitcase"}, {}, {93, "suitcase"}, {100}},
      {"bicycle", {2, "bicycle"}, {40, "otherprop"}, {121, "bicycle"}, {250}},
      {"clock", {85, "clock"}, {40, "otherprop"}, {103, "clock"}, {200}},
      {"vase", {86, "vase"}, {40, "otherprop"}, {}, {400}},
      {"lamp", {}, {35, "lamp"}, {28, "lamp"}, {100}},
      {"counter", {}, {12, "counter"}, {35, "counter"}, {150, kFixed}},
  };
}

// Folders are 0.32 m deep and what stands on boards seldom more; what is deeper has doors, or is a
// wardrobe. With some room for measuring.
constexpr double kDeepestShelf_m = 0.5;
// Seats are 0.4 to 0.52 m high, those of bar stools higher but as small as stools are; tops that
// one sits at begin at 0.65 m.
constexpr double kHighestSeat_m = 0.6;

std::optional<ClassLabel> Known(const ClassLabel& label) {
  return label.id > 0 ? std::optional(label) : std::nullopt;
}

void AddColumnsOfExport(std::vector<ObjectClass>& classes) {
  for (const ExportColumns& columns : ColumnsOfExport()) {
    for (ObjectClass& c : classes) {
      if (c.name != columns.class_name) continue;
      c.labels_elsewhere = {Known(columns.coco), Known(columns.nyu40), Known(columns.scannet200)};
      c.physics = columns.physics;
    }
  }
}

}  // namespace

ClassTable DefaultClassTable() {
  ClassTable table;
  for (const std::vector<ObjectClass>& rows : {Furniture(), HouseholdThings(), FittedKitchens()})
    table.classes.insert(table.classes.end(), rows.begin(), rows.end());
  std::ranges::find(table.classes, "shelf", &ObjectClass::name)->max_depth_m = kDeepestShelf_m;
  std::ranges::find(table.classes, "chair", &ObjectClass::name)->max_seat_height_m = kHighestSeat_m;
  AddColumnsOfExport(table.classes);
  return table;
}

}  // namespace deepslam::class_table
