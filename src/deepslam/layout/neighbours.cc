#include "deepslam/layout/neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace deepslam::layout {
namespace {

constexpr double kBeside_m = 0.5;      // an arm's length less: nobody walks between the two
constexpr double kUsedBefore_m = 1.5;  // room that people use before a thing
constexpr double kSharedHeight = 0.5;  // of the lower one, which is beside the other

using Corners = std::array<Eigen::Vector2d, 4>;

// Counter-clockwise.
Corners CornersOf(const ThingBox& thing) {
  const Eigen::Vector3d half = thing.size_m / 2;
  const auto corner = [&](double x, double y) -> Eigen::Vector2d {
    return (thing.world_from_object * Eigen::Vector3d(x * half.x(), y * half.y(), 0)).head<2>();
  };
  return {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
}

double ToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0;
  return (p - a - share * along).norm();
}

// Whether a line along a side of one has them on two sides.
bool AreApart(const Corners& one, const Corners& other) {
  for (std::size_t n = 0; n < 4; ++n) {
    const Eigen::Vector2d along = one[(n + 1) % 4] - one[n];
    const Eigen::Vector2d outward(along.y(), -along.x());
    const bool apart = std::all_of(other.begin(), other.end(), [&](const Eigen::Vector2d& p) {
      return outward.dot(p - one[n]) > 0;
    });
    if (apart) return true;
  }
  return false;
}

double DistanceBetween(const Corners& one, const Corners& other) {
  if (!AreApart(one, other) && !AreApart(other, one)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < 4; ++p) {
    for (std::size_t n = 0; n < 4; ++n) {
      least = std::min(least, ToSegment(one[p], other[n], other[(n + 1) % 4]));
      least = std::min(least, ToSegment(other[p], one[n], one[(n + 1) % 4]));
    }
  }
  return least;
}

double SharedHeight(const ThingBox& one, const ThingBox& other) {
  const double one_m = one.world_from_object.translation_m.z();
  const double other_m = other.world_from_object.translation_m.z();
  const double shared_m = std::min(one_m + one.size_m.z() / 2, other_m + other.size_m.z() / 2) -
                          std::max(one_m - one.size_m.z() / 2, other_m - other.size_m.z() / 2);
  const double lower_m = std::min(one.size_m.z(), other.size_m.z());
  return lower_m > 0 ? shared_m / lower_m : 0;
}

bool LiesBefore(const PlacedThing& thing, const PlacedThing& front) {
  if (!front.has_front) return false;
  const Eigen::Vector3d p =
      front.box.world_from_object.Inverse() * thing.box.world_from_object.translation_m;
  const Eigen::Vector3d half = front.box.size_m / 2;
  return p.x() > half.x() && p.x() <= half.x() + kUsedBefore_m && std::abs(p.y()) <= half.y();
}

}  // namespace

std::vector<Neighbours> NeighboursOf(std::span<const PlacedThing> things) {
  std::vector<Corners> corners;
  std::vector<double> reach_m;
  for (const PlacedThing& thing : things) {
    corners.push_back(CornersOf(thing.box));
    reach_m.push_back(thing.box.size_m.head<2>().norm() / 2);
  }
  std::vector<Neighbours> all;
  for (std::size_t a = 0; a < things.size(); ++a) {
    for (std::size_t b = 0; b < things.size(); ++b) {
      if (a == b || (things[a].room && things[b].room && things[a].room != things[b].room))
        continue;
      const double apart_m = (things[a].box.world_from_object.translation_m -
                              things[b].box.world_from_object.translation_m)
                                 .head<2>()
                                 .norm();
      if (apart_m > reach_m[a] + reach_m[b] + kUsedBefore_m) continue;
      Neighbours pair{a, b, DistanceBetween(corners[a], corners[b])};
      pair.beside = a < b && pair.distance_m <= kBeside_m &&
                    SharedHeight(things[a].box, things[b].box) >= kSharedHeight;
      pair.before = LiesBefore(things[a], things[b]);
      if (pair.beside || pair.before) all.push_back(pair);
    }
  }
  return all;
}

}  // namespace deepslam::layout
