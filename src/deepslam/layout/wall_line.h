// A line on the ground that faces of walls stand on, found from upright planes.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/core/options.h"
#include "deepslam/layout/surface_planes.h"
#include "deepslam/scene/coarse_surface.h"

namespace deepslam::layout {

// Points x with normal . x = offset_m. Positions along it are along() . x.
struct WallLine {
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // unit, to the free side
  double offset_m = 0;
  double area_m2 = 0;  // of the planes it was found from
  double begin_m = 0;  // where they begin and end along it
  double end_m = 0;

  // The free side lies to the left of it.
  [[nodiscard]] Eigen::Vector2d along() const { return {normal.y(), -normal.x()}; }
  [[nodiscard]] Eigen::Vector2d At(double position_m) const {
    return offset_m * normal + position_m * along();
  }
  [[nodiscard]] double Distance(const Eigen::Vector2d& p) const { return normal.dot(p) - offset_m; }
};

struct LineOptions {
  // Of a wall's plane from upright: the ground's tilt and drift, below that of sloped roofs.
  double max_tilt_deg = 8;
  double same_angle_deg = 6;    // planes of one wall differ by less,
  double same_offset_m = 0.07;  // and lie within this of the wall's line
};

// Planes that stand upright, put together into lines; by area, largest first. Of planes that lie in
// one another's line but face opposite ways, each makes a line of its own: walls have two faces.
[[nodiscard]] std::vector<WallLine> FindWallLines(const CoarseSurface& surface,
                                                  const std::vector<double>& areas_m2,
                                                  const std::vector<SurfacePlane>& planes,
                                                  const LineOptions& options);

// Turns lines that are nearly parallel or at right angles to a common direction to be exactly so,
// each about its middle, where lines of most of the area agree on one; returns whether they do.
bool AlignLines(std::vector<WallLine>& lines);

}  // namespace deepslam::layout
