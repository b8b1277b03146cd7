#include "deepslam/convex/polygon_soup.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include <Eigen/Geometry>

namespace deepslam::convex {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();  // not on this side yet

// One side of the plane while a soup is cut: its points by their place in the soup, and the caps.
class Half {
 public:
  Half(const PolygonSoup& from, PolygonSoup& to, PolygonSoup& caps)
      : from_(from), to_(to), caps_(caps), places_(from.points.size(), kNone) {}

  void Corner(std::uint32_t corner, bool on_plane) {
    std::uint32_t& place = places_[corner];
    if (place == kNone) place = Append(from_.points[corner]);
    Put(place, on_plane);
  }
  void Cut(const Eigen::Vector3f& p) { Put(Append(p), true); }

  // Edges along the plane are the polygon's no more, unless its neighbour lies on this side too:
  // that one's cap then cancels.
  void EndPolygon(std::optional<Eigen::Vector3f>& middle_of_cap) {
    const std::size_t size = polygon_.size();
    for (std::size_t n = 0; n < size && size > 1; ++n) {
      const Side& a = polygon_[n];
      const Side& b = polygon_[(n + 1) % size];
      if (!a.on_plane || !b.on_plane) continue;
      if (!middle_of_cap) middle_of_cap = to_.points[a.place];
      AddCap(to_.points[b.place], to_.points[a.place], *middle_of_cap);
    }
    for (const Side& side : polygon_) to_.corners.push_back(side.place);
    if (size > 0) to_.sizes.push_back(static_cast<std::uint32_t>(size));
    polygon_.clear();
  }

 private:
  struct Side {
    std::uint32_t place = 0;
    bool on_plane = false;
  };

  std::uint32_t Append(const Eigen::Vector3f& p) {
    to_.points.push_back(p);
    return static_cast<std::uint32_t>(to_.points.size() - 1);
  }
  void Put(std::uint32_t place, bool on_plane) { polygon_.push_back({place, on_plane}); }
  void AddCap(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    const auto first = static_cast<std::uint32_t>(caps_.points.size());
    caps_.points.insert(caps_.points.end(), {a, b, c});
    caps_.corners.insert(caps_.corners.end(), {first, first + 1, first + 2});
    caps_.sizes.push_back(3);
  }

  const PolygonSoup& from_;
  PolygonSoup& to_;
  PolygonSoup& caps_;
  std::vector<std::uint32_t> places_;
  std::vector<Side> polygon_;
};

void SplitPolygon(std::span<const std::uint32_t> corners,
                  const PolygonSoup& soup,
                  const std::vector<float>& heights,
                  Half& below,
                  Half& above) {
  for (std::size_t n = 0; n < corners.size(); ++n) {
    const std::uint32_t a = corners[n];
    const std::uint32_t b = corners[(n + 1) % corners.size()];
    if (heights[a] <= 0) below.Corner(a, heights[a] == 0);
    if (heights[a] >= 0) above.Corner(a, heights[a] == 0);
    if (!((heights[a] < 0 && heights[b] > 0) || (heights[a] > 0 && heights[b] < 0))) continue;
    const Eigen::Vector3f cut =
        soup.points[a] + heights[a] / (heights[a] - heights[b]) * (soup.points[b] - soup.points[a]);
    below.Cut(cut);
    above.Cut(cut);
  }
}

struct Halves {
  PolygonSoup below;
  PolygonSoup above;
};

void SplitSoup(const PolygonSoup& soup,
               const CutPlane& plane,
               std::optional<Eigen::Vector3f>& middle_of_cap,
               Halves& halves,
               Halves& caps) {
  std::vector<float> heights;
  heights.reserve(soup.points.size());
  for (const Eigen::Vector3f& p : soup.points)
    heights.push_back(plane.normal.dot(p) - plane.offset);
  Half below(soup, halves.below, caps.below);
  Half above(soup, halves.above, caps.above);
  std::size_t begin = 0;
  for (const std::uint32_t size : soup.sizes) {
    SplitPolygon(std::span(soup.corners).subspan(begin, size), soup, heights, below, above);
    below.EndPolygon(middle_of_cap);
    above.EndPolygon(middle_of_cap);
    begin += size;
  }
}

void Append(const PolygonSoup& more, PolygonSoup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.points.size());
  soup.points.insert(soup.points.end(), more.points.begin(), more.points.end());
  for (const std::uint32_t corner : more.corners) soup.corners.push_back(first + corner);
  soup.sizes.insert(soup.sizes.end(), more.sizes.begin(), more.sizes.end());
}

double SixVolumesOf(const PolygonSoup& soup) {
  double six_volumes = 0;
  std::size_t begin = 0;
  for (const std::uint32_t size : soup.sizes) {
    const auto at = [&](std::size_t n) -> Eigen::Vector3d {
      return soup.points[soup.corners[begin + n]].cast<double>();
    };
    for (std::size_t n = 2; n < size; ++n) six_volumes += at(0).dot(at(n - 1).cross(at(n)));
    begin += size;
  }
  return six_volumes;
}

}  // namespace

SurfacePart WholeOf(const TriangleMesh& closed) {
  SurfacePart part;
  part.surface.points = closed.vertices;
  part.surface.sizes.assign(closed.faces.size(), 3);
  for (const auto& face : closed.faces)
    part.surface.corners.insert(part.surface.corners.end(), face.begin(), face.end());
  return part;
}

std::pair<SurfacePart, SurfacePart> Split(const SurfacePart& part, const CutPlane& plane) {
  std::optional<Eigen::Vector3f> middle_of_cap;
  Halves surface;
  Halves caps;
  Halves new_caps;
  SplitSoup(part.surface, plane, middle_of_cap, surface, new_caps);
  SplitSoup(part.caps, plane, middle_of_cap, caps, new_caps);
  Append(new_caps.below, caps.below);
  Append(new_caps.above, caps.above);
  return {{std::move(surface.below), std::move(caps.below)},
          {std::move(surface.above), std::move(caps.above)}};
}

double VolumeOf(const SurfacePart& part) {
  return (SixVolumesOf(part.surface) + SixVolumesOf(part.caps)) / 6;
}

}  // namespace deepslam::convex
