// What one frame shows of the ground and of what stands on it, in cells around the camera's foot.
#pragma once

#include <cstdint>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/detect/cluster_detector.h"
#include "deepslam/frames/frame.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"

namespace deepslam::detect {

// Height noise of structured light: a part that does not depend on the depth, and one that grows
// with its square.
inline constexpr double kHeightNoise_m = 0.03;
inline constexpr double kHeightNoisePerM2 = 0.006;  // 1/m: times the depth squared

// What a cell holds, as bits.
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

// The floor that is seen, and the points above it. Points of walls are left out, so that what
// stands against a wall stands for itself; cells with some points of at least
// ClusterOptions::kMinHeight_m hold matter. `ground_camera`: normal up, d the camera's height.
[[nodiscard]] GroundGrid SurveyGround(const Frame& frame,
                                      const PinholeCamera& camera,
                                      const Plane& ground_camera);

}  // namespace deepslam::detect
