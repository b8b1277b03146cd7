#include "deepslam/instances/join_instances.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "deepslam/geometry/level_rectangle.h"
#include "deepslam/instances/class_sizes.h"

namespace deepslam::instances {
namespace {

constexpr double kMinSharedVolume = 0.5;  // of the smaller box
// Of what both outlines cover: a thing on another, or a wall cabinet above a counter, is smaller
// than what it stands on or above.
constexpr double kMinOutlineIou = 0.6;
// What nothing names does not stand in its like: two that begin and end alike, share more than this
// of the smaller and fill one rectangle between them are parts of one thing.
constexpr double kMinSharedEnd = 0.2;
constexpr double kMinFilledHull = 0.8;  // two fronts of 0.85 m that differ by 3 deg fill 0.84
constexpr double kMaxGapM = 0.45;  // between the boards of a rack or the planks of a console table
constexpr double kBoardDepthM = 0.1;  // pictures are flatter, racks for anything but spices deeper
// A chair's back stands on the edge of its seat or leans out over it.
constexpr double kEdgeM = 0.05;
constexpr double kMinSharedOutline = 0.5;  // of the smaller outline
// Between a seat and what is seen of a back, and between a pot and the leaves on a stem that is
// thinner than a voxel of the surface.
constexpr double kMaxGapOfNamedM = 0.3;
constexpr double kFlatM = 0.02;  // boxes are no thinner, so that a board has a volume
// Legs of tables are no wider than this, of what is seen of them, 8 cm more
// than the widest that segmentation by frames takes for one (segment/top_carriers.h).
constexpr double kSlimM = 0.2;
// Trestles, sledges and side panels are wider, and as thin as legs of beams; the whole of them lies
// under the top.
constexpr double kThinM = 0.12;
constexpr double kShareUnderTop = 0.9;  // of their outline, voxels at its edge excepted
// Their upper ends hide behind aprons and tops. Chairs that are pushed under a table end lower with
// their seats, and higher with their backs.
constexpr double kHiddenEndM = 0.2;
constexpr double kAboveTopM = 0.03;  // noise

LevelRectangle ThickOutlineOf(const UprightBox& box) {
  return {box.centre_m, box.yaw_rad, std::max(box.length_m, kFlatM), std::max(box.width_m, kFlatM)};
}

// What begins below this stands on the floor, and what begins above floats: voxels at the floor are
// the floor's.
constexpr double kOnFloorM = 0.25;
constexpr double kFloatsM = 0.3;      // beds begin lower, basins at 0.6 m
constexpr double kFootGapM = 0.15;    // between a foot's upper end and what it carries, either way
constexpr double kFootShare = 0.8;    // of the foot's outline, under the thing
constexpr double kHiddenSeatM = 0.3;  // half of a seat, and as far as backs lean out over it

// Negative: the width of the gap between them.
double SharedHeight(const UprightBox& a, const UprightBox& b) {
  return std::min(a.top_m, b.top_m) - std::max(a.bottom_m, b.bottom_m);
}

double Volume(const UprightBox& box) {
  return ThickOutlineOf(box).area_m2() * std::max(box.height_m(), kFlatM);
}

// Of a part's outline, over or under another outline that is larger by kEdgeM on all sides.
double ShareOver(LevelRectangle outline, const LevelRectangle& part) {
  outline.length_m += 2 * kEdgeM;
  outline.width_m += 2 * kEdgeM;
  return SharedArea(outline, part) / part.area_m2();
}

// The one with the smaller outline lies over or under the other one.
bool LiesOver(const UprightBox& a, const UprightBox& b) {
  LevelRectangle larger = ThickOutlineOf(a);
  LevelRectangle smaller = ThickOutlineOf(b);
  if (larger.area_m2() < smaller.area_m2()) std::swap(larger, smaller);
  return ShareOver(larger, smaller) > kMinSharedOutline;
}

bool Carries(const Instance& leg, const Instance& table) {
  const UprightBox& own = leg.box_level;
  const UprightBox& top = table.box_level;
  const bool is_slim = own.long_side_m() <= kSlimM;
  if (!table.has_support_plane || !table.is_named || !table.rejection.empty() ||
      !(is_slim || own.short_side_m() <= kThinM) || own.top_m > top.top_m + kAboveTopM ||
      own.top_m < top.top_m - kHiddenEndM)
    return false;
  return SharedArea(ThickOutlineOf(own), ThickOutlineOf(top)) >
         (is_slim ? kMinSharedOutline : kShareUnderTop) * ThickOutlineOf(own).area_m2();
}

// Plants and vases: alike from all sides, and nothing is put on them.
bool IsRound(const ClassTraits& traits) { return traits.yaw_free && !traits.support_plane; }

// Whether a class may stand on such a foot: a thing that nothing names, or, under a plant, what
// detections call a vase. On unnamed furniture plants stand as on a table.
bool MayStandOn(const ClassTraits& traits, const Instance& foot, const ClassTable& classes) {
  if (!traits.supports.floor || traits.support_plane) return false;
  return foot.is_named ? IsRound(traits) && IsRound(classes.TraitsOf(foot.class_name))
                       : !traits.yaw_free;
}

// On the floor, and the thing begins above where it ends.
bool EndsBelow(const Instance& foot, const Instance& thing) {
  const UprightBox& own = foot.box_level;
  const UprightBox& above = thing.box_level;
  const double max_gap_m = foot.is_named ? kMaxGapOfNamedM : kFootGapM;
  return own.bottom_m <= kOnFloorM && above.bottom_m >= kFloatsM &&
         std::abs(own.top_m - above.bottom_m) <= max_gap_m;
}

// A pot of which the plant has a part: within its height, below its upper half.
bool IsPotWithin(const Instance& foot, const Instance& thing) {
  const UprightBox& own = foot.box_level;
  const UprightBox& whole = thing.box_level;
  return foot.is_named && own.bottom_m >= whole.bottom_m - kEdgeM &&
         own.top_m <= 0.5 * (whole.bottom_m + whole.top_m);
}

bool IsFootOf(const Instance& foot, const Instance& thing, const ClassTable& classes) {
  const ObjectClass* object_class = classes.Find(thing.class_name);
  if (!thing.is_named || !thing.rejection.empty() || object_class == nullptr ||
      !MayStandOn(object_class->traits, foot, classes))
    return false;
  if (thing.box_level.top_m > object_class->max_height_m ||
      !(EndsBelow(foot, thing) || IsPotWithin(foot, thing)))
    return false;
  return ShareOver(ThickOutlineOf(thing.box_level), ThickOutlineOf(foot.box_level)) > kFootShare;
}

// Before a thin back that detections name, or a rail of it, which hides a part of the seat.
bool IsSeatOf(const Instance& seat, const Instance& back, const ClassTable& classes) {
  const ObjectClass* object_class = classes.Find(back.class_name);
  if (!back.is_named || seat.is_named || !seat.rejection.empty() || object_class == nullptr)
    return false;
  const ClassTraits& traits = object_class->traits;
  const UprightBox& own = seat.box_level;
  const UprightBox& above = back.box_level;
  if (!traits.supports.floor || traits.support_plane || traits.yaw_free ||
      own.bottom_m > kOnFloorM || above.short_side_m() > kBoardDepthM)
    return false;
  UprightBox both = own;
  both.top_m = above.top_m;
  const double gap_m = above.bottom_m - own.top_m;
  if (gap_m < -kEdgeM || gap_m > kMaxGapOfNamedM || !MayBe(*object_class, both)) return false;
  const LevelRectangle rail = ThickOutlineOf(above);
  return SharedArea(OutlineOf(own, kHiddenSeatM), rail) > kFootShare * rail.area_m2();
}

// A named part of a closed thing, shorter than any whole of its class, beside a whole one: between
// them lies what gave no depth, as on dark covers.
bool IsRestOf(const Instance& rest, const Instance& thing, const ClassTable& classes) {
  const ObjectClass* object_class = classes.Find(thing.class_name);
  if (!rest.is_named || !thing.is_named || rest.class_name != thing.class_name ||
      !thing.rejection.empty() || object_class == nullptr || !object_class->traits.solid_inside)
    return false;
  const UprightBox& part = rest.box_level;
  const UprightBox& whole = thing.box_level;
  if (std::max(part.long_side_m(), part.height_m()) >= object_class->min_size_m ||
      whole.long_side_m() < object_class->min_size_m || SharedHeight(part, whole) <= 0 ||
      SharedArea(OutlineOf(whole, kMaxGapOfNamedM), ThickOutlineOf(part)) <= 0)
    return false;
  const LevelRectangle both = HullAlong(ThickOutlineOf(whole), ThickOutlineOf(part));
  return std::max(both.length_m, both.width_m) <= object_class->max_size_m;
}

bool AreBoards(const Instance& a, const Instance& b) {
  const UprightBox& box_a = a.box_level;
  const UprightBox& box_b = b.box_level;
  if (a.is_named || b.is_named || SharedHeight(box_a, box_b) <= -kMaxGapM ||
      std::min(box_a.short_side_m(), box_b.short_side_m()) < kBoardDepthM)
    return false;
  const double shared_m2 = SharedArea(ThickOutlineOf(box_a), ThickOutlineOf(box_b));
  const double all_m2 =
      ThickOutlineOf(box_a).area_m2() + ThickOutlineOf(box_b).area_m2() - shared_m2;
  return shared_m2 > kMinOutlineIou * all_m2;
}

// Two that nothing names, overlapping ends of one closed thing, as the doors of a cabinet with what
// was seen of the open part between them.
bool AreEnds(const Instance& a, const Instance& b) {
  const UprightBox& box_a = a.box_level;
  const UprightBox& box_b = b.box_level;
  if (a.is_named || b.is_named || std::abs(box_a.top_m - box_b.top_m) > kEdgeM ||
      std::abs(box_a.bottom_m - box_b.bottom_m) > kOnFloorM)
    return false;
  LevelRectangle larger = OutlineOf(box_a, kFlatM);
  LevelRectangle smaller = OutlineOf(box_b, kFlatM);
  if (larger.area_m2() < smaller.area_m2()) std::swap(larger, smaller);
  const double shared_m2 = SharedArea(larger, smaller);
  const double filled_m2 = larger.area_m2() + smaller.area_m2() - shared_m2;
  return shared_m2 > kMinSharedEnd * smaller.area_m2() &&
         filled_m2 > kMinFilledHull * HullAlong(larger, smaller).area_m2();
}

bool AreOneThing(const Instance& a, const Instance& b) {
  if (Carries(a, b) || Carries(b, a) || AreBoards(a, b)) return true;
  const bool may_be_alike = a.class_name == b.class_name || (!a.is_named && !b.is_named);
  if (!may_be_alike || !a.rejection.empty() || !b.rejection.empty()) return false;
  const UprightBox& box_a = a.box_level;
  const UprightBox& box_b = b.box_level;
  const double shared_m2 = SharedArea(ThickOutlineOf(box_a), ThickOutlineOf(box_b));
  const double height_m = SharedHeight(box_a, box_b);
  if (height_m * shared_m2 > kMinSharedVolume * std::min(Volume(box_a), Volume(box_b))) return true;
  if (AreEnds(a, b)) return true;
  return a.is_named && b.is_named && height_m > -kMaxGapOfNamedM && LiesOver(box_a, box_b);
}

// Of each instance the position of the first one that it belongs to; -1: of none.
template <typename BelongsTo>
std::vector<int> OwnersOf(std::span<const Instance> instances, const BelongsTo& belongs_to) {
  std::vector<int> owners;
  for (const Instance& part : instances) {
    const auto owner = std::ranges::find_if(
        instances, [&](const Instance& other) { return belongs_to(part, other); });
    owners.push_back(owner == instances.end() ? -1 : static_cast<int>(owner - instances.begin()));
  }
  return owners;
}

}  // namespace

std::vector<int> WholesOf(std::span<const Instance> instances) {
  std::vector<int> whole_of(instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i) {
    whole_of[i] = static_cast<int>(i);
    for (std::size_t k = 0; k < i; ++k) {
      if (!AreOneThing(instances[k], instances[i])) continue;
      whole_of[i] = whole_of[k];
      break;
    }
  }
  return whole_of;
}

std::vector<int> CarriedByFeet(std::span<const Instance> instances, const ClassTable& classes) {
  return OwnersOf(instances, [&](const Instance& foot, const Instance& thing) {
    return IsFootOf(foot, thing, classes) || IsSeatOf(foot, thing, classes);
  });
}

std::vector<int> RestsOf(std::span<const Instance> instances, const ClassTable& classes) {
  return OwnersOf(instances, [&](const Instance& rest, const Instance& thing) {
    return IsRestOf(rest, thing, classes);
  });
}

}  // namespace deepslam::instances
