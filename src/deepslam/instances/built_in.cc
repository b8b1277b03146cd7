#include "deepslam/instances/built_in.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "deepslam/instances/upright_box.h"

namespace deepslam::instances {
namespace {

// Between the tops of a basin and of what it is let into: it may stand on it as a bowl, with taps.
constexpr double kRimAboveM = 0.35;
constexpr double kRimBelowM = 0.15;   // a basin of which the bottom was seen and not the rim
constexpr double kLeastBelowM = 0.3;  // of what is under it: less is a board
// Its middle may lie this far off an outline: of counters the front alone may have been seen.
constexpr double kBesideM = 0.3;
// Kitchen cabinets are 0.3 m wide at least: a shorter rest belongs to the piece that is cut out.
constexpr double kShortestPieceM = 0.25;
// Of what is under it, from its middle: counters are 0.65 m deep, and rows may go round corners.
constexpr double kHalfDepthM = 0.5;

bool IsUnder(const UprightBox& host, const UprightBox& thing) {
  if (thing.top_m > host.top_m + kRimAboveM || thing.top_m < host.top_m - kRimBelowM ||
      thing.bottom_m < host.bottom_m + kLeastBelowM)
    return false;
  return OutlineOf(host, kBesideM).Contains(thing.centre_m);
}

// Where these elements lie along an axis: from, to.
std::pair<double, double> ExtentAlong(const Eigen::Vector2d& axis,
                                      const std::vector<int>& own,
                                      const SurfaceElements& elements) {
  std::vector<double> at_m;
  for (const int i : own) {
    const Eigen::Vector3f& p = elements.points()[static_cast<std::size_t>(i)];
    at_m.push_back(axis.dot(p.head<2>().cast<double>()));
  }
  return ExtentOf(at_m);
}

BuiltInCut Cut(const Instance& host, const Instance& thing, const SurfaceElements& elements) {
  const Eigen::Vector2d axis = host.box_level.long_axis();
  const Eigen::Vector2d across(-axis.y(), axis.x());
  const auto [begin_m, end_m] = ExtentAlong(axis, host.elements, elements);
  auto [from_m, to_m] = ExtentAlong(axis, thing.elements, elements);
  if (from_m - begin_m < kShortestPieceM) from_m = -HUGE_VAL;
  if (end_m - to_m < kShortestPieceM) to_m = HUGE_VAL;
  BuiltInCut cut;
  std::vector<int> before;
  std::vector<int> behind;
  for (const int i : host.elements) {
    const Eigen::Vector2d p =
        elements.points()[static_cast<std::size_t>(i)].head<2>().cast<double>();
    const double at_m = axis.dot(p);
    const bool is_near = std::abs(across.dot(p - thing.box_level.centre_m)) < kHalfDepthM;
    if (at_m >= from_m && at_m <= to_m && is_near)
      cut.under.push_back(i);
    else
      (at_m < axis.dot(thing.box_level.centre_m) ? before : behind).push_back(i);
  }
  for (std::vector<int>* piece : {&before, &behind}) {
    if (!piece->empty()) cut.beside.push_back(std::move(*piece));
  }
  return cut;
}

}  // namespace

std::optional<BuiltInCut> CutUnder(std::size_t built_in,
                                   std::span<const Instance> instances,
                                   const SurfaceElements& elements,
                                   const ClassTable& classes) {
  const Instance& thing = instances[built_in];
  if (!thing.is_named || thing.elements.empty() || !classes.TraitsOf(thing.class_name).built_in)
    return std::nullopt;
  for (std::size_t k = 0; k < instances.size(); ++k) {
    const Instance& host = instances[k];
    if (k == built_in || host.is_named || host.elements.empty() || host.has_support_plane ||
        !IsUnder(host.box_level, thing.box_level))
      continue;
    BuiltInCut cut = Cut(host, thing, elements);
    if (cut.under.empty()) continue;
    cut.host = k;
    return cut;
  }
  return std::nullopt;
}

}  // namespace deepslam::instances
