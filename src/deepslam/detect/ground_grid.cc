#include "deepslam/detect/ground_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/detect/find_walls.h"
#include "deepslam/scene/ground.h"

namespace deepslam::detect {
namespace {

constexpr int kMinCellPoints = 3;  // fewer are noise
constexpr int kWallStride_px = 4;  // every 16th pixel is plenty for lines metres long
constexpr int kTopPart = 20;       // of the image's height; depth often begins a few rows down

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

GroundGrid SurveyCells(const Frame& frame,
                       const PinholeCamera& camera,
                       const Plane& ground_camera) {
  GroundGrid grid;
  grid.cell_m = ClusterOptions::kCell_m;
  grid.side =
      2 * static_cast<int>(std::ceil(1.5 * ClusterOptions::kMaxDepth_m / ClusterOptions::kCell_m)) +
      3;
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
      if (!(depth_m > 0) || depth_m > ClusterOptions::kMaxDepth_m) continue;
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

}  // namespace

GroundGrid SurveyGround(const Frame& frame,
                        const PinholeCamera& camera,
                        const Plane& ground_camera) {
  GroundGrid grid = SurveyCells(frame, camera, ground_camera);
  LeaveOutWalls(frame.depth_m.height() / kTopPart, grid);
  MarkMatter(ClusterOptions::kMinHeight_m, grid);
  return grid;
}

}  // namespace deepslam::detect
