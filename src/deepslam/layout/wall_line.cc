#include "deepslam/layout/wall_line.h"
#include "deepslam/core/angles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace deepslam::layout {
namespace {

// Weighted points on the ground, from which a line follows.
struct GroundSums {
  double weight = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d products = Eigen::Matrix2d::Zero();
  Eigen::Vector2d normal_sum = Eigen::Vector2d::Zero();

  void Add(const Eigen::Vector2d& p, double w) {
    weight += w;
    sum += w * p;
    products += w * p * p.transpose();
  }
  void Add(const GroundSums& other) {
    weight += other.weight;
    sum += other.sum;
    products += other.products;
    normal_sum += other.normal_sum;
  }
  void FitTo(WallLine& line) const {
    const Eigen::Vector2d mean = sum / weight;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(products / weight -
                                                                mean * mean.transpose());
    line.normal = solver.eigenvectors().col(0);
    if (line.normal.dot(normal_sum) < 0) line.normal = -line.normal;
    line.offset_m = line.normal.dot(mean);
    line.area_m2 = weight;
  }
};

GroundSums SumsOf(const CoarseSurface& surface,
                  const std::vector<double>& areas_m2,
                  const SurfacePlane& plane) {
  GroundSums sums;
  for (const std::uint32_t v : plane.vertices)
    sums.Add(surface.mesh.vertices[v].head<2>().cast<double>(), areas_m2[v]);
  sums.normal_sum = sums.weight * plane.plane.normal.head<2>();
  return sums;
}

// Whether nearly all of the plane lies on the line.
bool LiesOn(const CoarseSurface& surface,
            const SurfacePlane& plane,
            const WallLine& line,
            double same_offset_m) {
  std::size_t num_near = 0;
  for (const std::uint32_t v : plane.vertices) {
    const double off_m = line.Distance(surface.mesh.vertices[v].head<2>().cast<double>());
    num_near += std::abs(off_m) < same_offset_m ? 1 : 0;
  }
  // Share of its vertices: the rest may be noise, or a frame that stands out.
  constexpr double kNearlyAll = 0.85;
  return static_cast<double>(num_near) > kNearlyAll * static_cast<double>(plane.vertices.size());
}

struct GrowingLine {
  WallLine line;
  GroundSums sums;
  std::vector<const SurfacePlane*> planes;
};

void SetReach(const CoarseSurface& surface,
              const std::vector<const SurfacePlane*>& planes,
              WallLine& line) {
  const Eigen::Vector2d along = line.along();
  line.begin_m = std::numeric_limits<double>::infinity();
  line.end_m = -line.begin_m;
  for (const SurfacePlane* plane : planes) {
    for (const std::uint32_t v : plane->vertices) {
      const double at_m = along.dot(surface.mesh.vertices[v].head<2>().cast<double>());
      line.begin_m = std::min(line.begin_m, at_m);
      line.end_m = std::max(line.end_m, at_m);
    }
  }
}

// In (-45, 45] deg: how far a direction is from the nearest of four at right angles.
double FromAxes(double angle_rad, double axes_rad) {
  constexpr double kQuarter = std::numbers::pi / 2;  // turn
  const double turns = (angle_rad - axes_rad) / kQuarter;
  return (turns - std::round(turns)) * kQuarter;
}

double AngleOf(const WallLine& line) { return std::atan2(line.normal.y(), line.normal.x()); }

}  // namespace

std::vector<WallLine> FindWallLines(const CoarseSurface& surface,
                                    const std::vector<double>& areas_m2,
                                    const std::vector<SurfacePlane>& planes,
                                    const LineOptions& options) {
  const double max_vertical = std::sin(options.max_tilt_deg * kRadPerDeg);
  const double min_cosine = std::cos(options.same_angle_deg * kRadPerDeg);
  std::vector<GrowingLine> growing;
  for (const SurfacePlane& plane : planes) {
    if (std::abs(plane.plane.normal.z()) > max_vertical) continue;
    const Eigen::Vector2d normal = plane.plane.normal.head<2>().normalized();
    const GroundSums sums = SumsOf(surface, areas_m2, plane);
    const auto same = std::find_if(growing.begin(), growing.end(), [&](const GrowingLine& other) {
      return other.line.normal.dot(normal) > min_cosine &&
             LiesOn(surface, plane, other.line, options.same_offset_m);
    });
    GrowingLine& line = same == growing.end() ? growing.emplace_back() : *same;
    line.sums.Add(sums);
    line.planes.push_back(&plane);
    line.sums.FitTo(line.line);
  }
  std::vector<WallLine> lines;
  for (GrowingLine& line : growing) {
    SetReach(surface, line.planes, line.line);
    lines.push_back(line.line);
  }
  std::stable_sort(lines.begin(), lines.end(), [](const WallLine& a, const WallLine& b) {
    return a.area_m2 > b.area_m2;
  });
  return lines;
}

bool AlignLines(std::vector<WallLine>& lines) {
  constexpr double kNear_rad = 3 * kRadPerDeg;  // walls that are off by more were built so
  constexpr double kMostOfArea = 0.7;           // of the area
  double whole_m2 = 0;
  for (const WallLine& line : lines) whole_m2 += line.area_m2;
  // Each line proposes its own direction; the one that most of the area is near to wins.
  double best_m2 = 0;
  double axes_rad = 0;
  for (const WallLine& proposal : lines) {
    double near_m2 = 0;
    double off = 0;
    for (const WallLine& line : lines) {
      const double from_rad = FromAxes(AngleOf(line), AngleOf(proposal));
      if (std::abs(from_rad) > kNear_rad) continue;
      near_m2 += line.area_m2;
      off += line.area_m2 * from_rad;
    }
    if (near_m2 <= best_m2) continue;
    best_m2 = near_m2;
    axes_rad = AngleOf(proposal) + off / near_m2;
  }
  if (lines.size() < 2 || best_m2 < kMostOfArea * whole_m2) return false;
  for (WallLine& line : lines) {
    const double from_rad = FromAxes(AngleOf(line), axes_rad);
    if (std::abs(from_rad) > kNear_rad) continue;
    const Eigen::Vector2d middle = line.At(0.5 * (line.begin_m + line.end_m));
    // A line that is known better than this says that it is not parallel.
    const double half_length_m = 0.5 * (line.end_m - line.begin_m);
    constexpr double kMaxEndMove_m = 0.03;  // at its ends
    if (std::abs(from_rad) * half_length_m > kMaxEndMove_m) continue;
    const double angle_rad = AngleOf(line) - from_rad;
    const double length_m = line.end_m - line.begin_m;
    line.normal = {std::cos(angle_rad), std::sin(angle_rad)};
    line.offset_m = line.normal.dot(middle);
    line.begin_m = line.along().dot(middle) - 0.5 * length_m;
    line.end_m = line.begin_m + length_m;
  }
  return true;
}

}  // namespace deepslam::layout
