#include "deepslam/layout/surface_planes.h"

#include <CGAL/Shape_detection/Region_growing/Region_growing.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "deepslam/core/angles.h"

namespace deepslam::layout {
namespace {

// Vertices that share an edge; those of vertex v at [begin[v], begin[v + 1]).
struct Neighbours {
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> list;
};

Neighbours NeighboursOf(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  pairs.reserve(6 * mesh.faces.size());
  for (const auto& face : mesh.faces) {
    for (std::size_t n = 0; n < 3; ++n) {
      pairs.emplace_back(face[n], face[(n + 1) % 3]);
      pairs.emplace_back(face[(n + 1) % 3], face[n]);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Neighbours neighbours;
  neighbours.begin.assign(mesh.vertices.size() + 1, 0);
  for (const auto& [vertex, other] : pairs) {
    ++neighbours.begin[vertex + 1];
    neighbours.list.push_back(other);
  }
  std::partial_sum(neighbours.begin.begin(), neighbours.begin.end(), neighbours.begin.begin());
  return neighbours;
}

// Means over the vertices around, twice: marching cubes turn normals by the noise of each voxel.
std::vector<Eigen::Vector3f> Smoothed(const std::vector<Eigen::Vector3f>& normals,
                                      const Neighbours& neighbours) {
  constexpr int kRounds = 2;  // each takes in what is a vertex further off
  std::vector<Eigen::Vector3f> smooth = normals;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Eigen::Vector3f> before = smooth;
    for (std::size_t v = 0; v < smooth.size(); ++v) {
      for (std::size_t n = neighbours.begin[v]; n < neighbours.begin[v + 1]; ++n)
        smooth[v] += before[neighbours.list[n]];
      const float norm = smooth[v].norm();
      smooth[v] = norm > 0 ? Eigen::Vector3f(smooth[v] / norm) : before[v];
    }
  }
  return smooth;
}

// Sums over weighted points, from which their plane follows.
struct PointSums {
  double weight = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  Eigen::Vector3d normal_sum = Eigen::Vector3d::Zero();

  void Add(const Eigen::Vector3d& p, const Eigen::Vector3d& normal, double w) {
    weight += w;
    sum += w * p;
    products += w * p * p.transpose();
    normal_sum += w * normal;
  }
  [[nodiscard]] Eigen::Vector3d Mean() const { return sum / weight; }
  // Least squares, towards the normals' side; `rms_m` of the distances.
  [[nodiscard]] Plane Fit(double* rms_m = nullptr) const {
    const Eigen::Vector3d mean = Mean();
    const Eigen::Matrix3d covariance = products / weight - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    Eigen::Vector3d normal = solver.eigenvectors().col(0);
    if (normal.dot(normal_sum) < 0) normal = -normal;
    if (rms_m != nullptr) *rms_m = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
    return {normal, -normal.dot(mean)};
  }
};

class NeighbourQuery {
 public:
  explicit NeighbourQuery(const Neighbours& neighbours) : neighbours_(neighbours) {}
  void operator()(std::size_t vertex, std::vector<std::size_t>& found) const {
    for (std::size_t n = neighbours_.begin[vertex]; n < neighbours_.begin[vertex + 1]; ++n)
      found.push_back(neighbours_.list[n]);
  }

 private:
  const Neighbours& neighbours_;
};

// What belongs to the region that is growing. Its plane is fitted anew when it has grown by a
// fifth.
class FlatRegion {
 public:
  FlatRegion(const CoarseSurface& surface,
             const std::vector<Eigen::Vector3f>& normals,
             const std::vector<double>& areas_m2,
             const PlaneOptions& options)
      : surface_(surface),
        normals_(normals),
        areas_m2_(areas_m2),
        options_(options),
        min_cosine_(std::cos(options.max_angle_deg * kRadPerDeg)) {}

  [[nodiscard]] bool is_part_of_region(std::size_t /*from*/,
                                       std::size_t vertex,
                                       const std::vector<std::size_t>& /*region*/) const {
    return Normal(vertex).dot(plane_.normal) > min_cosine_ &&
           std::abs(plane_.SignedDistance(Point(vertex))) < options_.max_distance_m;
  }
  [[nodiscard]] bool is_valid_region(const std::vector<std::size_t>& /*region*/) const {
    return sums_.weight >= options_.min_area_m2;
  }
  void update(const std::vector<std::size_t>& region) {
    if (region.size() == 1) {
      sums_ = {};
      num_added_ = 0;
      fitted_m2_ = 0;
      plane_.normal = Normal(region[0]);
      plane_.d_m = -plane_.normal.dot(Point(region[0]));
    }
    for (; num_added_ < region.size(); ++num_added_) {
      const std::size_t vertex = region[num_added_];
      sums_.Add(Point(vertex), Normal(vertex), areas_m2_[vertex]);
    }
    // A plane is fitted each time its area has grown by a fifth, not at each vertex.
    constexpr double kGrown = 1.2;
    constexpr std::size_t kFewestFitted =
        12;  // vertices whose plane says more than the seed's normal
    if (region.size() < kFewestFitted || !(sums_.weight > kGrown * fitted_m2_)) return;
    fitted_m2_ = sums_.weight;
    plane_ = sums_.Fit();
  }

 private:
  [[nodiscard]] Eigen::Vector3d Point(std::size_t v) const {
    return surface_.mesh.vertices[v].cast<double>();
  }
  [[nodiscard]] Eigen::Vector3d Normal(std::size_t v) const { return normals_[v].cast<double>(); }

  const CoarseSurface& surface_;
  const std::vector<Eigen::Vector3f>& normals_;
  const std::vector<double>& areas_m2_;
  const PlaneOptions& options_;
  double min_cosine_;
  Plane plane_;
  PointSums sums_;
  std::size_t num_added_ = 0;
  double fitted_m2_ = 0;
};

// Seeds: the flattest surroundings first, by how much the normals around agree.
std::vector<std::size_t> SeedOrder(const std::vector<Eigen::Vector3f>& normals,
                                   const Neighbours& neighbours) {
  std::vector<float> flatness(normals.size());
  for (std::size_t v = 0; v < normals.size(); ++v) {
    Eigen::Vector3f sum = normals[v];
    for (std::size_t n = neighbours.begin[v]; n < neighbours.begin[v + 1]; ++n)
      sum += normals[neighbours.list[n]];
    const auto count = static_cast<float>(neighbours.begin[v + 1] - neighbours.begin[v] + 1);
    flatness[v] = sum.norm() / count;
  }
  std::vector<std::size_t> order(normals.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return flatness[a] > flatness[b];
  });
  return order;
}

struct SeedMap {
  using key_type = std::size_t;
  using value_type = std::size_t;
  using reference = std::size_t;
  using category = boost::readable_property_map_tag;
  const std::vector<std::size_t>* order = nullptr;
  friend std::size_t get(const SeedMap& map, std::size_t n) { return (*map.order)[n]; }
};

SurfacePlane PlaneOf(const CoarseSurface& surface,
                     const std::vector<double>& areas_m2,
                     const std::vector<std::size_t>& region) {
  SurfacePlane found;
  PointSums sums;
  for (const std::size_t v : region) {
    sums.Add(
        surface.mesh.vertices[v].cast<double>(), surface.normals[v].cast<double>(), areas_m2[v]);
    found.vertices.push_back(static_cast<std::uint32_t>(v));
  }
  std::sort(found.vertices.begin(), found.vertices.end());
  found.plane = sums.Fit(&found.rms_m);
  found.centre_m = sums.Mean();
  found.area_m2 = sums.weight;
  return found;
}

}  // namespace

std::vector<double> VertexAreas(const TriangleMesh& mesh) {
  std::vector<double> areas_m2(mesh.vertices.size(), 0);
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d a = mesh.vertices[face[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[face[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[face[2]].cast<double>();
    const double third_m2 = (b - a).cross(c - a).norm() / 6;
    for (const std::uint32_t v : face) areas_m2[v] += third_m2;
  }
  return areas_m2;
}

std::vector<SurfacePlane> FindPlanes(const CoarseSurface& surface,
                                     const std::vector<double>& areas_m2,
                                     const PlaneOptions& options) {
  if (surface.mesh.vertices.empty()) return {};
  const Neighbours neighbours = NeighboursOf(surface.mesh);
  const std::vector<Eigen::Vector3f> normals = Smoothed(surface.normals, neighbours);
  const std::vector<std::size_t> order = SeedOrder(normals, neighbours);
  NeighbourQuery query(neighbours);
  FlatRegion flat(surface, normals, areas_m2, options);
  CGAL::Shape_detection::
      Region_growing<std::vector<Eigen::Vector3f>, NeighbourQuery, FlatRegion, SeedMap>
          growing(surface.mesh.vertices, query, flat, SeedMap{&order});
  std::vector<std::vector<std::size_t>> regions;
  growing.detect(std::back_inserter(regions));
  std::vector<SurfacePlane> planes;
  for (const auto& region : regions) planes.push_back(PlaneOf(surface, areas_m2, region));
  std::stable_sort(planes.begin(), planes.end(), [](const SurfacePlane& a, const SurfacePlane& b) {
    return a.area_m2 > b.area_m2;
  });
  return planes;
}

}  // namespace deepslam::layout
