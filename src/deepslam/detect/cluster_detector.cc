#include "deepslam/detect/cluster_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>

#include "deepslam/core/order_statistics.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/detect/find_walls.h"
#include "deepslam/scene/ground.h"

namespace deepslam::detect {
namespace {

// Height noise of structured light: a part that does not depend on the depth, and one that grows
// with its square.
constexpr double kHeightNoise_m = 0.03;
constexpr double kHeightNoisePerM2 = 0.006;
constexpr int kMinCellPoints = 3;
constexpr double kThin_m = 0.08;     // a flat thing this thin ...
constexpr double kThinTall_m = 1.2;  // ... and this tall is a piece of wall or a door
constexpr int kBorder_px = 4;
constexpr int kWallStride_px = 4;
constexpr int kTopPart = 20;  // of the image's height; depth often begins a few rows down
constexpr double kBorderShare =
    0.25;  // of the cluster's height in the image that may run along one border

constexpr double kShadowShare = 0.05;  // of the image width: the sensor's shadow beside a thing
constexpr double kStepBehind_m = 0.10;
constexpr double kMinEndShare = 0.6;
constexpr double kWhollyCovered = 0.8;
constexpr std::size_t kOutermost = 100;  // part of the points at either end that may be noise

enum : std::uint8_t { kFloor = 1, kMatter = 2 };

struct GridPoint {
  int u, v;
  int cell;
  float height_m;
  float x_m, y_m;  // on the ground
  float depth_m;
};

// The ground as seen by one camera, in cells around the camera's foot.
struct GroundGrid {
  int side = 0;  // cells
  double cell_m = 0;
  std::vector<std::uint8_t> kinds;
  std::vector<GridPoint> points;  // above the ground and of no wall, in image order
  Mask wall;                      // pixels of walls

  [[nodiscard]] double reach_m() const { return 0.5 * side * cell_m; }
  // `i` and `j` count from the camera's foot; -1 at the grid's border and beyond.
  [[nodiscard]] int Cell(int i, int j) const {
    i += side / 2;
    j += side / 2;
    if (i < 1 || j < 1 || i >= side - 1 || j >= side - 1) return -1;
    return i * side + j;
  }
};

// How the pixels of a row lie to the ground.
struct GroundRow {
  explicit GroundRow(std::size_t width)
      : x_m(width), y_m(width), height_m(width), noise_m(width), i(width), j(width) {}

  std::vector<double> x_m, y_m, height_m, noise_m;
  std::vector<std::int32_t> i, j;  // cells from the camera's foot
};

std::int32_t Floor(double x) {
  const auto towards_zero = static_cast<std::int32_t>(x);
  return towards_zero - (static_cast<double>(towards_zero) > x ? 1 : 0);
}

DEEPSLAM_WIDE_VECTORS void SurveyRow(const float* depth_m,
                                     const std::vector<double>& rays_x,
                                     double ray_y,
                                     const Plane& ground_camera,
                                     const Eigen::Matrix<double, 3, 2>& ground_basis,
                                     double reach_m,
                                     double cell_m,
                                     GroundRow& row) {
  const Plane ground = ground_camera;
  const Eigen::Matrix<double, 3, 2> basis = ground_basis;
  const double* const ray_x = rays_x.data();
  double* const x_m = row.x_m.data();
  double* const y_m = row.y_m.data();
  double* const height_m = row.height_m.data();
  double* const noise_m = row.noise_m.data();
  std::int32_t* const i = row.i.data();
  std::int32_t* const j = row.j.data();
  const std::size_t width = rays_x.size();
#pragma GCC ivdep
  for (std::size_t u = 0; u < width; ++u) {
    const double z = depth_m[u];
    const double x = z * ray_x[u];
    const double y = z * ray_y;
    const double on_ground_x = basis(0, 0) * x + basis(1, 0) * y + basis(2, 0) * z;
    const double on_ground_y = basis(0, 1) * x + basis(1, 1) * y + basis(2, 1) * z;
    x_m[u] = on_ground_x;
    y_m[u] = on_ground_y;
    height_m[u] =
        ground.normal.x() * x + ground.normal.y() * y + ground.normal.z() * z + ground.d_m;
    noise_m[u] = kHeightNoise_m + kHeightNoisePerM2 * z * z;
    // What lies farther falls into the grid's border, which is no cell.
    i[u] = Floor(std::min(std::max(on_ground_x, -reach_m), reach_m) / cell_m);
    j[u] = Floor(std::min(std::max(on_ground_y, -reach_m), reach_m) / cell_m);
  }
}

GroundGrid MakeGrid(const Frame& frame,
                    const PinholeCamera& camera,
                    const Plane& ground_camera,
                    const ClusterOptions& options) {
  GroundGrid grid;
  grid.cell_m = options.cell_m;
  grid.side = 2 * static_cast<int>(std::ceil(1.5 * options.max_depth_m / options.cell_m)) + 3;
  const auto num_cells = static_cast<std::size_t>(grid.side) * static_cast<std::size_t>(grid.side);
  grid.kinds.assign(num_cells, 0);
  grid.wall = Mask(frame.depth_m.width(), frame.depth_m.height());
  const Eigen::Matrix<double, 3, 2> basis = GroundTangentBasis(ground_camera.normal);
  std::vector<double> rays_x;
  for (int u = 0; u < frame.depth_m.width(); ++u) rays_x.push_back(camera.Ray(u, 0).x());
  GroundRow row(rays_x.size());
  grid.points.reserve(frame.depth_m.size());
  for (int v = 0; v < frame.depth_m.height(); ++v) {
    const float* const depth_row_m = frame.depth_m.row(v);
    SurveyRow(depth_row_m,
              rays_x,
              camera.Ray(0, v).y(),
              ground_camera,
              basis,
              grid.reach_m(),
              grid.cell_m,
              row);
    for (int u = 0; u < frame.depth_m.width(); ++u) {
      const float depth_m = depth_row_m[u];
      if (!(depth_m > 0) || depth_m > options.max_depth_m) continue;
      const auto at = static_cast<std::size_t>(u);
      const int cell = grid.Cell(row.i[at], row.j[at]);
      if (cell < 0) continue;
      const double height_m = row.height_m[at];
      const double noise_m = row.noise_m[at];
      if (std::abs(height_m) <= noise_m) {
        grid.kinds[static_cast<std::size_t>(cell)] |= kFloor;
      } else if (height_m > noise_m) {
        grid.points.push_back({u,
                               v,
                               cell,
                               static_cast<float>(height_m),
                               static_cast<float>(row.x_m[at]),
                               static_cast<float>(row.y_m[at]),
                               depth_m});
      }
    }
  }
  return grid;
}

// Without the walls what stands against them stands for itself.
void LeaveOutWalls(int top_rows, GroundGrid& grid) {
  std::vector<UprightPoint> some;
  for (const GridPoint& p : grid.points) {
    if (p.u % kWallStride_px != 0 || p.v % kWallStride_px != 0) continue;
    some.push_back({{p.x_m, p.y_m}, p.height_m, p.depth_m, p.v < top_rows});
  }
  const std::vector<Wall> walls = FindWalls(some);
  std::erase_if(grid.points, [&](const GridPoint& p) {
    const bool is_wall = std::any_of(walls.begin(), walls.end(), [&](const Wall& wall) {
      return std::abs(wall.Beyond({p.x_m, p.y_m})) <= WallTolerance_m(p.depth_m);
    });
    if (is_wall) grid.wall(p.u, p.v) = 1;
    return is_wall;
  });
}

void MarkMatter(double min_height_m, GroundGrid& grid) {
  std::vector<int> num_points(grid.kinds.size(), 0);
  for (const GridPoint& p : grid.points) {
    if (p.height_m >= min_height_m) ++num_points[static_cast<std::size_t>(p.cell)];
  }
  for (std::size_t i = 0; i < num_points.size(); ++i) {
    if (num_points[i] >= kMinCellPoints) grid.kinds[i] |= kMatter;
  }
}

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

// Component of every matter cell, -1 elsewhere; components count from 0 in the order of their first
// cells.
struct Components {
  std::vector<int> of_cell;
  int count = 0;
};

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

struct Cluster {
  int component = 0;
  std::size_t num_points = 0;
  std::size_t num_cells = 0;
  int num_left = 0;  // pixels at the image's borders
  int num_right = 0;
  int num_top = 0;
  int num_rows = 0;
  Box2 box_px;
  // Of what may be furniture alone:
  std::vector<GridPoint> points;  // in image order
  std::vector<int> cells;
  double min_height_m = 0;
  double max_height_m = 0;
  double long_side_m = 0;  // on the ground
  double short_side_m = 0;
};

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
bool MayBeFurniture(const Cluster& cluster, const ClusterOptions& options) {
  const double cell_m2 = options.cell_m * options.cell_m;
  if (static_cast<double>(cluster.num_cells) * cell_m2 < options.min_footprint_m2) return false;
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
                  const ClusterOptions& options,
                  std::vector<Cluster>& clusters) {
  std::vector<Cluster*> of_component(static_cast<std::size_t>(components.count), nullptr);
  for (Cluster& cluster : clusters) {
    if (!MayBeFurniture(cluster, options)) continue;
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

// Share of the outline towards the camera in front of which floor is seen: 1 for a thing that
// stands free.
double FreeShare(const GroundGrid& grid,
                 const Components& components,
                 const Cluster& cluster,
                 const ClusterOptions& options) {
  const int reach = std::max(1, static_cast<int>(std::lround(options.free_margin_m / grid.cell_m)));
  int num_front = 0;
  int num_free = 0;
  for (const int cell : cluster.cells) {
    const Eigen::Vector2d place(cell / grid.side - grid.side / 2, cell % grid.side - grid.side / 2);
    if (place.norm() < 2.0) continue;
    const Eigen::Vector2d step = -place.normalized();
    bool front = true;
    bool floor = false;
    for (int k = 1; k <= reach && front; ++k) {
      const Eigen::Vector2d q = place + k * step;
      const int i = static_cast<int>(std::lround(q.x())) + grid.side / 2;
      const int j = static_cast<int>(std::lround(q.y())) + grid.side / 2;
      const auto index = static_cast<std::size_t>(i * grid.side + j);
      if (static_cast<int>(index) != cell && components.of_cell[index] == cluster.component)
        front = false;
      floor = floor || (grid.kinds[index] & kFloor) != 0;
    }
    num_front += front ? 1 : 0;
    num_free += front && floor ? 1 : 0;
  }
  return num_front > 0 ? static_cast<double>(num_free) / num_front : 0.0;
}

struct PixelPlace {
  int u = 0;
  int v = 0;
};

// Share of image rows in which the cluster's left end (`side` -1) or right end (+1) is seen to end:
// next to it lies floor, a wall or something farther. A thing that runs on behind an occluder, out
// of the picture or into missing depth does not.
double EndShare(const Frame& frame,
                const PinholeCamera& camera,
                const Plane& ground_camera,
                const Mask& wall,
                const Cluster& cluster,
                int side) {
  std::vector<PixelPlace> ends;  // the outermost of each row
  for (const GridPoint& p : cluster.points) {
    if (ends.empty() || ends.back().v != p.v) {
      ends.push_back({p.u, p.v});
    } else if (side > 0) {
      ends.back().u = p.u;
    }
  }
  const int reach = static_cast<int>(std::lround(kShadowShare * frame.depth_m.width()));
  std::size_t num_ends = 0;
  for (const auto& [u_end, v] : ends) {
    const double depth_m = frame.depth_m(u_end, v);
    for (int u = u_end + side, k = 0; k < reach && frame.depth_m.Contains(u, v); u += side, ++k) {
      const double beyond_m = frame.depth_m(u, v);
      if (!(beyond_m > 0)) continue;
      const double height_m = ground_camera.SignedDistance(camera.Unproject(u, v, beyond_m));
      const bool floor = height_m < kHeightNoise_m + kHeightNoisePerM2 * beyond_m * beyond_m;
      const bool is_end = floor || wall(u, v) != 0 || beyond_m > depth_m + kStepBehind_m;
      num_ends += is_end ? 1U : 0U;
      break;
    }
  }
  return static_cast<double>(num_ends) / static_cast<double>(ends.size());
}

// Measures the cluster, as far as it takes.
bool IsFurniture(const ClusterOptions& options, Cluster& cluster) {
  if (cluster.points.empty()) return false;
  MeasureHeights(cluster);
  if (cluster.max_height_m > options.max_height_m || cluster.min_height_m > options.max_base_m) {
    return false;
  }
  MeasureFootprint(cluster);
  const double longest_m = std::max(cluster.long_side_m, cluster.max_height_m);
  if (longest_m < options.min_size_m || cluster.long_side_m > options.max_size_m) return false;
  return cluster.short_side_m >= kThin_m || cluster.max_height_m <= kThinTall_m;
}

// Of a cluster's pixels, which are those of its mask.
double CoveredShare(const Detection& cluster, std::span<const Detection> covered) {
  const Box2& box = cluster.box_px;
  const Mask mask = cluster.mask.Unpacked();
  std::size_t num_pixels = 0;
  std::size_t num_covered = 0;
  for (int v = static_cast<int>(box.v_min); v <= static_cast<int>(box.v_max); ++v) {
    for (int u = static_cast<int>(box.u_min); u <= static_cast<int>(box.u_max); ++u) {
      if (mask(u, v) == 0) continue;
      ++num_pixels;
      num_covered += std::any_of(covered.begin(),
                                 covered.end(),
                                 [&](const Detection& d) { return d.box_px.Contains(u, v); })
                         ? 1U
                         : 0U;
    }
  }
  return static_cast<double>(num_covered) / static_cast<double>(num_pixels);
}

// For each detection the cluster whose box is most like its own: what it has found. As many as
// there are boxes where there is none.
std::vector<std::size_t> FoundBy(std::span<const Detection> detections,
                                 std::span<const Box2> boxes_px) {
  std::vector<std::size_t> found;
  for (const Detection& detection : detections) {
    const auto best =
        std::max_element(boxes_px.begin(), boxes_px.end(), [&](const Box2& a, const Box2& b) {
          return IntersectionOverUnion(detection.box_px, a) <
                 IntersectionOverUnion(detection.box_px, b);
        });
    found.push_back(static_cast<std::size_t>(best - boxes_px.begin()));
  }
  return found;
}

// A box reaches over what stands before the thing it is of: only the cluster it has found is its
// own, and what lies in boxes nearly wholly.
bool IsExplained(const FrameClusters::Furniture& furniture,
                 std::span<const Detection> detections,
                 std::span<const std::size_t> found,
                 double max_covered_share) {
  const Detection& cluster = furniture.detection;
  if (CoveredShare(cluster, detections) > kWhollyCovered) return true;
  for (std::size_t n = 0; n < detections.size(); ++n) {
    if (found[n] == furniture.cluster &&
        CoveredShare(cluster, detections.subspan(n, 1)) > max_covered_share)
      return true;
  }
  return false;
}

// The class without detector labels whose sizes hold the cluster, most central first; the fallback
// if none does.
std::string ClassOf(const Cluster& cluster, const ClassTable& classes) {
  const double longest_m = std::max(cluster.long_side_m, cluster.max_height_m);
  const auto distance = [](double value, double low, double high) {
    return high > low ? std::abs(value - 0.5 * (low + high)) / (0.5 * (high - low)) : 2.0;
  };
  std::string best;
  double best_distance = 1.0;
  for (const ObjectClass& c : classes.classes) {
    if (!c.detector_labels.empty() || c.traits.fallback) continue;
    const double d = std::max(distance(longest_m, c.min_size_m, c.max_size_m),
                              distance(cluster.max_height_m, c.min_height_m, c.max_height_m));
    if (d <= best_distance) {
      best_distance = d;
      best = c.name;
    }
  }
  const ObjectClass* const fallback = classes.Fallback();
  if (best.empty() && fallback != nullptr) best = fallback->name;
  return best;
}

}  // namespace

void Describe(OptionsVisitor& visitor, ClusterOptions& options) {
  visitor.Field("enabled", options.enabled, "look for floor-standing clusters no detection covers");
  visitor.Field(
      "min_height_m", options.min_height_m, {0.02, 1}, "m", "lower points belong to the ground");
  visitor.Field("max_height_m",
                options.max_height_m,
                {0.3, 5},
                "m",
                "clusters that reach higher belong to the room");
  visitor.Field("max_depth_m", options.max_depth_m, {0.5, 20}, "m", "farther depth is not used");
  visitor.Field("max_base_m",
                options.max_base_m,
                {0.02, 1},
                "m",
                "a cluster's lowest point must be this near to the ground");
  visitor.Field("cell_m",
                options.cell_m,
                {0.01, 0.2},
                "m",
                "cell of the grid on the ground in which clusters are connected");
  visitor.Field("min_footprint_m2",
                options.min_footprint_m2,
                {0, 5},
                "m2",
                "clusters that cover less ground are dropped");
  visitor.Field(
      "min_size_m", options.min_size_m, {0.05, 5}, "m", "least longest side of a cluster");
  visitor.Field("max_size_m",
                options.max_size_m,
                {0.3, 10},
                "m",
                "wider clusters are walls or fitted furniture");
  visitor.Field("min_points_share",
                options.min_points_share,
                {0, 1},
                "1",
                "least share of the image's pixels");
  visitor.Field("max_covered_share",
                options.max_covered_share,
                {0, 1},
                "1",
                "clusters covered more than this by the detection that found them are dropped");
  visitor.Field("free_margin_m",
                options.free_margin_m,
                {0.02, 1},
                "m",
                "floor must be seen within this distance of the cluster's foot");
  visitor.Field("min_free_share",
                options.min_free_share,
                {0, 1},
                "1",
                "share of the outline along which floor must be seen");
}

FrameClusters FindClusters(const Frame& frame,
                           const PinholeCamera& camera,
                           const Plane& ground_camera,
                           const ClassTable& classes,
                           const ClusterOptions& options) {
  FrameClusters found;
  if (!options.enabled || frame.depth_m.empty() || !(camera.fx > 0) || !(camera.fy > 0))
    return found;
  GroundGrid grid = MakeGrid(frame, camera, ground_camera, options);
  LeaveOutWalls(frame.depth_m.height() / kTopPart, grid);
  MarkMatter(options.min_height_m, grid);
  const Components components = ConnectCells(grid);
  const auto min_points = static_cast<std::size_t>(
      std::max(1.0, options.min_points_share * static_cast<double>(frame.depth_m.size())));
  std::vector<Cluster> clusters =
      MeasureClusters(frame.depth_m.width(), grid, components, min_points);
  GatherPoints(grid, components, options, clusters);
  for (Cluster& cluster : clusters) {
    found.boxes_px.push_back(cluster.box_px);
    if (!IsFurniture(options, cluster)) continue;
    const double free_share = FreeShare(grid, components, cluster, options);
    if (free_share < options.min_free_share) continue;
    if (EndShare(frame, camera, ground_camera, grid.wall, cluster, -1) < kMinEndShare ||
        EndShare(frame, camera, ground_camera, grid.wall, cluster, 1) < kMinEndShare) {
      continue;
    }
    Detection detection;
    detection.frame = frame.idx;
    detection.class_name = ClassOf(cluster, classes);
    if (detection.class_name.empty()) continue;
    detection.score = 0.3 + 0.4 * free_share;  // never above a good detection of a network
    detection.box_px = cluster.box_px;
    detection.source = DetectionSource::kCluster;
    Mask mask(frame.depth_m.width(), frame.depth_m.height());
    for (const GridPoint& p : cluster.points) mask(p.u, p.v) = 1;
    detection.mask = mask;
    found.furniture.push_back({std::move(detection), found.boxes_px.size() - 1});
  }
  return found;
}

std::vector<Detection> Uncovered(FrameClusters clusters,
                                 std::span<const Detection> covered,
                                 const ClusterOptions& options) {
  const std::vector<std::size_t> found = FoundBy(covered, clusters.boxes_px);
  std::vector<Detection> detections;
  for (FrameClusters::Furniture& furniture : clusters.furniture) {
    if (IsExplained(furniture, covered, found, options.max_covered_share)) continue;
    detections.push_back(std::move(furniture.detection));
  }
  return detections;
}

std::vector<Detection> DetectClusters(const Frame& frame,
                                      const PinholeCamera& camera,
                                      const Plane& ground_camera,
                                      std::span<const Detection> covered,
                                      const ClassTable& classes,
                                      const ClusterOptions& options) {
  return Uncovered(FindClusters(frame, camera, ground_camera, classes, options), covered, options);
}

}  // namespace deepslam::detect
