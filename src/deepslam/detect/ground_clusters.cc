#include "deepslam/detect/ground_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <Eigen/Eigenvalues>

#include "deepslam/core/order_statistics.h"

namespace deepslam::detect {
namespace {

constexpr double kThin_m = 0.08;     // a flat thing this thin ...
constexpr double kThinTall_m = 1.2;  // ... and this tall is a piece of wall or a door
constexpr int kBorder_px = 4;        // depth often ends a few pixels before the picture does
// Of the cluster's height in the image that may run along one border.
constexpr double kBorderShare = 0.25;
constexpr std::size_t kOutermost = 100;  // part of the points at either end that may be noise

std::array<int, 8> Neighbours(int cell, int side) {
  return {cell - side - 1,
          cell - side,
          cell - side + 1,
          cell - 1,
          cell + 1,
          cell + side - 1,
          cell + side,
          cell + side + 1};
}

// Sides of the points' rectangle along their principal directions, outermost hundredth left out.
void MeasureFootprint(Cluster& cluster) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const GridPoint& p : cluster.points) mean += Eigen::Vector2d(p.x_m, p.y_m);
  mean /= static_cast<double>(cluster.points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const GridPoint& p : cluster.points) {
    const Eigen::Vector2d d = Eigen::Vector2d(p.x_m, p.y_m) - mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(scatter);
  std::array<double, 2> sides = {0, 0};
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> along;
    along.reserve(cluster.points.size());
    for (const GridPoint& p : cluster.points) {
      along.push_back(solver.eigenvectors().col(axis).dot(Eigen::Vector2d(p.x_m, p.y_m)));
    }
    const auto [low, high] = InnerRange(along, kOutermost);
    sides[static_cast<std::size_t>(axis)] = high - low;
  }
  cluster.short_side_m = std::min(sides[0], sides[1]);
  cluster.long_side_m = std::max(sides[0], sides[1]);
}

void MeasureHeights(Cluster& cluster) {
  std::vector<float> heights_m;
  heights_m.reserve(cluster.points.size());
  for (const GridPoint& p : cluster.points) heights_m.push_back(p.height_m);
  const auto [low, high] = InnerRange(heights_m, kOutermost);
  cluster.min_height_m = low;
  cluster.max_height_m = high;
}

// Points side by side in a row of the image that belong to one component.
void AddRun(std::span<const GridPoint> run, int image_width, Cluster& cluster) {
  const GridPoint& first = run.front();
  const GridPoint& last = run.back();
  cluster.num_points += run.size();
  Box2& box = cluster.box_px;
  box = {std::min<double>(box.u_min, first.u),
         std::min<double>(box.v_min, first.v),
         std::max<double>(box.u_max, last.u),
         std::max<double>(box.v_max, last.v)};
  for (auto p = run.begin(); p != run.end() && p->u < kBorder_px; ++p) ++cluster.num_left;
  for (auto p = run.rbegin(); p != run.rend() && p->u >= image_width - kBorder_px; ++p)
    ++cluster.num_right;
  if (first.v < kBorder_px) cluster.num_top += static_cast<int>(run.size());
}

// Calls use(component, run) for all such runs, in image order; the component is -1 where there is
// none.
template <typename Use>
void ForRuns(std::span<const GridPoint> points, const Components& components, const Use& use) {
  const auto component_of = [&](std::size_t n) {
    return components.of_cell[static_cast<std::size_t>(points[n].cell)];
  };
  for (std::size_t begin = 0; begin < points.size();) {
    const int component = component_of(begin);
    std::size_t end = begin + 1;
    while (end < points.size() && points[end].v == points[begin].v &&
           component_of(end) == component)
      ++end;
    use(component, points.subspan(begin, end - begin));
    begin = end;
  }
}

// Clusters of so many points or more as they lie in the image; most points first.
std::vector<Cluster> MeasureClusters(int image_width,
                                     const GroundGrid& grid,
                                     const Components& components,
                                     std::size_t min_points) {
  std::vector<Cluster> clusters(static_cast<std::size_t>(components.count));
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    clusters[c].component = static_cast<int>(c);
    clusters[c].box_px = {1e9, 1e9, -1, -1};
  }
  ForRuns(grid.points, components, [&](int component, std::span<const GridPoint> run) {
    if (component >= 0) AddRun(run, image_width, clusters[static_cast<std::size_t>(component)]);
  });
  for (const int component : components.of_cell) {
    if (component >= 0) ++clusters[static_cast<std::size_t>(component)].num_cells;
  }
  std::erase_if(clusters, [min_points](const Cluster& c) { return c.num_points < min_points; });
  for (Cluster& cluster : clusters)
    cluster.num_rows = static_cast<int>(cluster.box_px.height_px()) + 1;
  std::stable_sort(clusters.begin(), clusters.end(), [](const Cluster& a, const Cluster& b) {
    return a.num_points > b.num_points;
  });
  return clusters;
}

// As far as the image and the grid tell.
bool MayBeFurniture(const Cluster& cluster) {
  const double cell_m2 = ClusterOptions::kCell_m * ClusterOptions::kCell_m;
  if (static_cast<double>(cluster.num_cells) * cell_m2 < ClusterOptions::kMinFootprint_m2)
    return false;
  // What runs out of the picture on both sides or through its top may be anything.
  const double limit = kBorderShare * cluster.num_rows * kBorder_px;
  const bool left = cluster.num_left > limit;
  const bool right = cluster.num_right > limit;
  return !(left && right) &&
         cluster.num_top <= kBorderShare * cluster.box_px.width_px() * kBorder_px;
}

// Points and cells of those that may be furniture.
void GatherPoints(const GroundGrid& grid,
                  const Components& components,
                  std::vector<Cluster>& clusters) {
  std::vector<Cluster*> of_component(static_cast<std::size_t>(components.count), nullptr);
  for (Cluster& cluster : clusters) {
    if (!MayBeFurniture(cluster)) continue;
    of_component[static_cast<std::size_t>(cluster.component)] = &cluster;
    cluster.points.reserve(cluster.num_points);
    cluster.cells.reserve(cluster.num_cells);
  }
  const auto wanted = [&](int component) {
    return component < 0 ? nullptr : of_component[static_cast<std::size_t>(component)];
  };
  ForRuns(grid.points, components, [&](int component, std::span<const GridPoint> run) {
    if (Cluster* const cluster = wanted(component))
      cluster->points.insert(cluster->points.end(), run.begin(), run.end());
  });
  for (std::size_t i = 0; i < components.of_cell.size(); ++i) {
    if (Cluster* const cluster = wanted(components.of_cell[i]))
      cluster->cells.push_back(static_cast<int>(i));
  }
}

}  // namespace

Components ConnectCells(const GroundGrid& grid) {
  Components components;
  components.of_cell.assign(grid.kinds.size(), -1);
  std::vector<int> open;
  const int num_cells = static_cast<int>(grid.kinds.size());
  for (int seed = 0; seed < num_cells; ++seed) {
    const auto s = static_cast<std::size_t>(seed);
    if ((grid.kinds[s] & kMatter) == 0 || components.of_cell[s] >= 0) continue;
    components.of_cell[s] = components.count;
    open.assign(1, seed);
    while (!open.empty()) {
      const int cell = open.back();
      open.pop_back();
      for (const int next : Neighbours(cell, grid.side)) {
        if (next < 0 || next >= num_cells) continue;
        const auto n = static_cast<std::size_t>(next);
        if ((grid.kinds[n] & kMatter) == 0 || components.of_cell[n] >= 0) continue;
        components.of_cell[n] = components.count;
        open.push_back(next);
      }
    }
    ++components.count;
  }
  return components;
}

std::vector<Cluster> FindGroundClusters(int image_width,
                                        const GroundGrid& grid,
                                        const Components& components,
                                        std::size_t min_points) {
  std::vector<Cluster> clusters = MeasureClusters(image_width, grid, components, min_points);
  GatherPoints(grid, components, clusters);
  return clusters;
}

bool IsFurniture(Cluster& cluster) {
  if (cluster.points.empty()) return false;
  MeasureHeights(cluster);
  if (cluster.max_height_m > ClusterOptions::kMaxHeight_m ||
      cluster.min_height_m > ClusterOptions::kMaxBase_m) {
    return false;
  }
  MeasureFootprint(cluster);
  const double longest_m = std::max(cluster.long_side_m, cluster.max_height_m);
  if (longest_m < ClusterOptions::kMinSize_m || cluster.long_side_m > ClusterOptions::kMaxSize_m)
    return false;
  return cluster.short_side_m >= kThin_m || cluster.max_height_m <= kThinTall_m;
}

}  // namespace deepslam::detect
