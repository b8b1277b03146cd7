#include "deepslam/instances/find_instances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/instances/built_in.h"
#include "deepslam/instances/carried.h"
#include "deepslam/instances/class_sizes.h"
#include "deepslam/instances/join_instances.h"
#include "deepslam/instances/open_below.h"
#include "deepslam/instances/reach_back.h"
#include "deepslam/instances/support_height.h"

namespace deepslam::instances {
namespace {

// Things that hide what they stand on begin where they were seen first: one that begins below this
// and is longer than it is high reaches down to the floor.
constexpr double kHiddenBaseM = 0.45;
// What detections name may be seen in part: the back of a chair that stands under a table is 0.2 m
// high. Of the least side and surface that are asked of other things.
constexpr double kNamedSideShare = 0.6;
// Detections that call a top on legs a table in this share of the views, weighted by their scores,
// tell that it is one: two of the least score that is kept in thirty views.
constexpr double kHintShare = 0.02;

struct Context {
  const SurfaceElements& elements;
  const Superpoints& superpoints;
  const ViewVotes& votes;
  std::span<const LayoutWall> walls;
  const ClassTable& classes;
  const InstanceOptions& options;
};

std::vector<Instance> Gather(const Superpoints& superpoints,
                             const std::vector<int>& thing_of_superpoint) {
  int num_things = 0;
  for (const int thing : thing_of_superpoint) num_things = std::max(num_things, thing + 1);
  std::vector<Instance> instances(static_cast<std::size_t>(num_things));
  for (std::size_t i = 0; i < superpoints.of_element.size(); ++i) {
    const int superpoint = superpoints.of_element[i];
    if (superpoint < 0) continue;
    const int thing = thing_of_superpoint[static_cast<std::size_t>(superpoint)];
    instances[static_cast<std::size_t>(thing)].elements.push_back(static_cast<int>(i));
  }
  return instances;
}

// Votes of the superpoints, weighted by their size.
void CountClasses(const Superpoints& superpoints,
                  const std::vector<int>& thing_of_superpoint,
                  const ViewVotes& votes,
                  std::vector<Instance>& instances) {
  std::vector<double> num_views(instances.size(), 0);
  for (std::size_t s = 0; s < votes.classes.size(); ++s) {
    const auto thing = static_cast<std::size_t>(thing_of_superpoint[s]);
    const double weight = superpoints.num_elements[s];
    num_views[thing] += weight * votes.num_views[s];
    for (const auto& [name, score] : votes.classes[s])
      instances[thing].class_shares[name] += weight * score;
  }
  for (std::size_t thing = 0; thing < instances.size(); ++thing) {
    for (auto& [name, share] : instances[thing].class_shares)
      share /= std::max(1.0, num_views[thing]);
  }
}

// 0 in the middle of the range, 1 at its ends.
double Eccentricity(double value, double low, double high) {
  return high > low ? std::abs(value - 0.5 * (low + high)) / (0.5 * (high - low)) : 2.0;
}

// The class whose sizes hold the box, the most central one, of those without detector labels or,
// for a top on legs, of those with a support plane; where none does the one that takes what fits no
// other. What begins high above the floor is of a class that may rest on something else.
std::string ClassBySize(const UprightBox& box, bool is_open_below, const ClassTable& classes) {
  const double longest_m = std::max(box.long_side_m(), box.height_m());
  const ObjectClass* best = classes.Fallback();
  double least = 1;
  for (const ObjectClass& c : classes.classes) {
    const bool is_asked = is_open_below ? c.traits.support_plane : c.detector_labels.empty();
    if (!is_asked || c.traits.fallback) continue;
    const Supports& supports = c.traits.supports;
    if (box.bottom_m > kMaxHiddenBase_m && !supports.furniture && !supports.wall) continue;
    if (box.short_side_m() > c.max_depth_m) continue;
    const double eccentricity = std::max(Eccentricity(longest_m, c.min_size_m, c.max_size_m),
                                         Eccentricity(box.top_m, c.min_height_m, c.max_height_m));
    if (eccentricity > least) continue;
    least = eccentricity;
    best = &c;
  }
  return best != nullptr ? best->name : std::string();
}

// A top on legs: the floor was seen through it, or some detection calls it one.
bool IsOpenBelow(const Context& context, const Instance& instance) {
  if (!IsTopOnLegs(instance.elements, instance.box_level, context.elements)) return false;
  const auto calls_it_one = [&](const std::pair<const std::string, double>& votes) {
    return votes.second >= kHintShare && context.classes.TraitsOf(votes.first).support_plane;
  };
  return std::ranges::any_of(instance.class_shares, calls_it_one) ||
         IsFloorSeenIn(instance.box_level, context.elements, context.superpoints);
}

// The class that most detections name, of those whose things are like this one; nothing where none
// does. A top that detections take for a seat is one of a table.
std::string ClassByVotes(const Context& context, const Instance& instance) {
  const ClassTable& classes = context.classes;
  std::string best;
  double most = context.options.min_class_share;
  for (const auto& [name, share] : instance.class_shares) {
    const ObjectClass* object_class = classes.Find(name);
    if (share < most || object_class == nullptr || !MayBe(*object_class, instance.box_level))
      continue;
    if (!best.empty() && share <= most) continue;
    most = share;
    const bool is_top = LevelFaceHeight(instance.elements, instance.box_level, context.elements) >
                        object_class->max_seat_height_m;
    best = is_top ? ClassBySize(instance.box_level, true, classes) : name;
  }
  return best;
}

void Name(const Context& context, Instance& instance) {
  const ClassTable& classes = context.classes;
  instance.class_name = ClassByVotes(context, instance);
  instance.is_named = !instance.class_name.empty();
  if (!instance.is_named) {
    const bool is_open_below = IsOpenBelow(context, instance);
    instance.class_name = ClassBySize(instance.box_level, is_open_below, classes);
  }
  instance.has_support_plane = classes.TraitsOf(instance.class_name).support_plane;
}

// Why something is too small to be mapped, whoever names it.
std::string TooLittle(const Instance& instance, double voxel_m, const InstanceOptions& options) {
  const UprightBox& box = instance.box_level;
  const double surface_m2 = static_cast<double>(instance.elements.size()) * voxel_m * voxel_m;
  const double seen_share = instance.is_named ? kNamedSideShare : 1;
  if (surface_m2 < seen_share * options.min_surface_m2)
    return fmt::format("only {:.2f} m2 of it were seen", surface_m2);
  std::array<double, 3> sides_m = {box.length_m, box.width_m, box.height_m()};
  std::ranges::sort(sides_m);
  const double min_side_m = seen_share * options.min_size_m;
  if (sides_m[1] < min_side_m)
    return fmt::format("small: {:.2f} x {:.2f} m", sides_m[2], sides_m[1]);
  return {};
}

// Why something that no detection names is not taken for a thing.
std::string NoThing(const UprightBox& box, const InstanceOptions& options) {
  if (box.top_m > options.max_top_m)
    return fmt::format("reaches {:.2f} m high: part of the room", box.top_m);
  if (box.long_side_m() > options.max_size_m)
    return fmt::format("{:.2f} m long: no single thing", box.long_side_m());
  const double size_m = std::max(box.long_side_m(), box.height_m());
  const bool stands = box.bottom_m < options.max_base_m;
  const double min_depth_m = stands ? options.min_depth_m : options.min_hung_depth_m;
  if (box.short_side_m() < min_depth_m)
    return fmt::format("only {:.2f} m deep", box.short_side_m());
  if (size_m < options.min_unnamed_size_m) return fmt::format("only {:.2f} m large", size_m);
  if (stands && box.height_m() < 0.5 * options.min_size_m)
    return fmt::format("only {:.2f} m high", box.height_m());
  return {};
}

UprightBox BoxOfElements(const SurfaceElements& elements, const std::vector<int>& own) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(own.size());
  for (const int i : own) points.push_back(elements.points()[static_cast<std::size_t>(i)]);
  UprightBox box = BoxOf(points);
  if (box.bottom_m < kHiddenBaseM && box.long_side_m() > box.height_m())
    box.bottom_m = std::min(box.bottom_m, 0.0);
  return box;
}

// Of what nothing names and only the front was seen of, as deep as there is room for it.
void Deepen(const Context& context, Instance& instance) {
  if (instance.is_named || instance.box_level.short_side_m() >= context.options.min_depth_m) return;
  Eigen::Vector3f facing = Eigen::Vector3f::Zero();
  for (const int i : instance.elements)
    facing += context.elements.normals()[static_cast<std::size_t>(i)];
  const std::optional<UprightBox> whole =
      ReachBack(instance.box_level, facing, context.walls, context.elements);
  if (!whole) return;
  instance.box_level = *whole;
  Name(context, instance);
}

// Its box, its name, and why it is no object.
void Judge(const Context& context, Instance& instance) {
  const InstanceOptions& options = context.options;
  instance.box_level = BoxOfElements(context.elements, instance.elements);
  Name(context, instance);
  Deepen(context, instance);
  instance.rejection = TooLittle(instance, context.elements.voxel_m(), options);
  if (instance.rejection.empty() && !instance.is_named)
    instance.rejection = NoThing(instance.box_level, options);
  if (instance.rejection.empty() && instance.class_name.empty())
    instance.rejection = "no class of the table is as large";
}

// Instances out of superpoints.
std::vector<Instance> Assemble(const Context& context,
                               const std::vector<int>& thing_of_superpoint) {
  std::vector<Instance> instances = Gather(context.superpoints, thing_of_superpoint);
  CountClasses(context.superpoints, thing_of_superpoint, context.votes, instances);
  for (Instance& instance : instances) Judge(context, instance);
  return instances;
}

void AddElements(const Context& context, const std::vector<int>& more, Instance& instance) {
  instance.elements.insert(instance.elements.end(), more.begin(), more.end());
  std::ranges::sort(instance.elements);
  instance.box_level = BoxOfElements(context.elements, instance.elements);
}

// Furniture under what is built into it becomes part of it; what is left of the furniture comes
// behind all other instances.
void CutFurniture(const Context& context, std::vector<Instance>& instances) {
  for (std::size_t i = 0; i < instances.size(); ++i) {
    std::vector<int> under;
    while (auto cut = CutUnder(i, instances, context.elements, context.classes)) {
      under.insert(under.end(), cut->under.begin(), cut->under.end());
      Instance& host = instances[cut->host];
      host.elements.clear();
      host.rejection = "a " + instances[i].class_name + " is built into it";
      for (std::vector<int>& elements : cut->beside) {
        Instance piece;
        piece.elements = std::move(elements);
        Judge(context, piece);
        instances.push_back(std::move(piece));
      }
    }
    if (!under.empty()) AddElements(context, under, instances[i]);
  }
}

// Parts go over to their things, which keep their names: detections of a basin say nothing of its
// pedestal. `part`: what they are of them, "foot".
void GiveAway(const Context& context,
              const std::vector<int>& thing_of,
              const std::string& part,
              std::vector<Instance>& instances) {
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (thing_of[i] < 0) continue;
    Instance& given = instances[i];
    Instance& thing = instances[static_cast<std::size_t>(thing_of[i])];
    AddElements(context, given.elements, thing);
    given.elements.clear();
    given.rejection = "the " + part + " of a " + thing.class_name;
    thing.rejection = TooLittle(thing, context.elements.voxel_m(), context.options);
  }
}

// Parts become their wholes, which are numbered anew in their order. Tells whether there were any.
bool JoinParts(const std::vector<int>& whole_of, std::vector<int>& thing_of_superpoint) {
  std::vector<int> number_of(whole_of.size(), -1);
  int next = 0;
  for (std::size_t k = 0; k < whole_of.size(); ++k) {
    const auto whole = static_cast<std::size_t>(whole_of[k]);
    if (whole == k) number_of[k] = next++;
  }
  for (int& thing : thing_of_superpoint) {
    const int whole = whole_of[static_cast<std::size_t>(thing)];
    thing = number_of[static_cast<std::size_t>(whole)];
  }
  return next < static_cast<int>(whole_of.size());
}

}  // namespace

void Describe(OptionsVisitor& visitor, InstanceOptions& options) {
  visitor.Field("min_size_m",
                options.min_size_m,
                {0.05, 5},
                "m",
                "least length and least height or width of a thing");
  visitor.Field("min_surface_m2",
                options.min_surface_m2,
                {0.001, 10},
                "m2",
                "least surface that was seen of a thing");
  visitor.Field("min_class_share",
                options.min_class_share,
                {0, 1},
                "1",
                "share of the views, weighted by scores, in which detections must name a thing");
  visitor.Field("max_base_m",
                options.max_base_m,
                {0, 2},
                "m",
                "what no detection names stands on the floor when it begins below this");
  visitor.Field("min_depth_m",
                options.min_depth_m,
                {0, 2},
                "m",
                "thinner ones that no detection names are parts of walls and doors");
  visitor.Field("min_unnamed_size_m",
                options.min_unnamed_size_m,
                {0, 5},
                "m",
                "least longest side of what no detection names");
  visitor.Retired("min_hung_size_m", "associate.things.min_unnamed_size_m");
  visitor.Field("min_hung_depth_m",
                options.min_hung_depth_m,
                {0, 2},
                "m",
                "least shorter side of one that stands on or hangs from something");
  visitor.Field("max_top_m",
                options.max_top_m,
                {0.5, 10},
                "m",
                "higher ones that no detection names belong to the room");
  visitor.Field("max_size_m",
                options.max_size_m,
                {0.5, 20},
                "m",
                "longer ones that no detection names are no single thing");
}

Instances FindInstances(const SurfaceElements& elements,
                        const Superpoints& superpoints,
                        std::span<const ElementPair> pairs,
                        const ViewVotes& votes,
                        std::span<const LayoutWall> walls,
                        const ClassTable& classes,
                        const InstanceOptions& options) {
  Contacts contacts = FindContacts(elements, superpoints, pairs);
  AddNear(elements, superpoints, contacts);
  std::vector<int> thing_of_superpoint =
      MergeSuperpoints(superpoints, contacts, votes, elements.voxel_m(), options.merge);
  const Context context{elements, superpoints, votes, walls, classes, options};
  std::vector<Instance> instances = Assemble(context, thing_of_superpoint);
  while (JoinParts(WholesOf(instances), thing_of_superpoint))
    instances = Assemble(context, thing_of_superpoint);
  CutFurniture(context, instances);
  GiveAway(context, CarriedByFeet(instances, context.classes), "foot", instances);
  GiveAway(context, RestsOf(instances, context.classes), "rest", instances);
  RejectCarried(instances);
  for (Instance& instance : instances) {
    if (instance.has_support_plane) instance.top_m = SupportHeight(instance.elements, elements);
  }
  Instances found{std::move(instances), std::vector<int>(elements.size(), -1)};
  for (std::size_t k = 0; k < found.instances.size(); ++k) {
    for (const int i : found.instances[k].elements)
      found.of_element[static_cast<std::size_t>(i)] = static_cast<int>(k);
  }
  return found;
}

}  // namespace deepslam::instances
