#include "deepslam/convex/decompose.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "deepslam/convex/convex_hull.h"
#include "deepslam/convex/cut_proxy.h"
#include "deepslam/convex/mass_properties.h"
#include "deepslam/convex/polygon_soup.h"
#include "deepslam/convex/solid_voxels.h"
#include "deepslam/shape/mesh_check.h"

namespace deepslam::convex {
namespace {

constexpr int kCellsAlong = 60;           // along the longest side: a chair's leg of 4 cm has two
constexpr std::size_t kTried = 4;         // cuts whose hulls are made: moments only guess these
constexpr std::size_t kMaxVertices = 64;  // PhysX takes no more
constexpr double kSmallestShare = 1e-4;   // of the mesh's volume: what is less is no piece
constexpr double kWorthACut = 2e-3;       // of the mesh's volume: air that is worth a cut

struct Part {
  SurfacePart surface;
  std::vector<Eigen::Vector3f> cells;
  TriangleMesh hull;
  double hull_m3 = 0;
  double own_m3 = 0;
  bool whole = false;  // no plane cuts it

  [[nodiscard]] double air_m3() const { return whole ? 0 : hull_m3 - own_m3; }
};

double HullsOf(const std::vector<Part>& parts) {
  double sum_m3 = 0;
  for (const Part& part : parts) sum_m3 += part.hull_m3;
  return sum_m3;
}

class Decomposition {
 public:
  Decomposition(const TriangleMesh& mesh, const DecomposeOptions& options)
      : options_(options), volume_m3_(VolumeOf(mesh)) {
    SolidVoxels voxels = SolidVoxelsOf(mesh, kCellsAlong);
    cell_m_ = voxels.cell_m;
    if (voxels.centres.empty()) return;
    parts_.push_back(MakePart(WholeOf(mesh), std::move(voxels.centres)));
    while (CutOnce()) {
    }
  }

  [[nodiscard]] std::vector<TriangleMesh> Pieces() const {
    std::vector<TriangleMesh> pieces;
    for (const Part& part : parts_) pieces.push_back(Fitted(part));
    return pieces;
  }

 private:
  // Without a volume where it is no piece.
  [[nodiscard]] Part MakePart(SurfacePart surface, std::vector<Eigen::Vector3f> cells) const {
    Part part;
    part.hull = BoundedHull(surface.surface.points, kMaxVertices);
    part.hull_m3 = VolumeOf(part.hull);
    part.own_m3 = VolumeOf(surface);
    // Corners where planes meet within the mesh are none of its surface; its cells reach near them.
    if (part.own_m3 > part.hull_m3) {
      std::vector<Eigen::Vector3f> points = surface.surface.points;
      points.insert(points.end(), cells.begin(), cells.end());
      part.hull = BoundedHull(points, kMaxVertices);
      part.hull_m3 = VolumeOf(part.hull);
    }
    part.surface = std::move(surface);
    part.cells = std::move(cells);
    return part;
  }

  // Both halves; none where all cells are on one side, as rounding may leave them.
  [[nodiscard]] std::vector<Part> Halves(const Part& part, const CutPlane& plane) const {
    std::vector<Eigen::Vector3f> cells_below;
    std::vector<Eigen::Vector3f> cells_above;
    for (const Eigen::Vector3f& p : part.cells)
      (plane.normal.dot(p) < plane.offset ? cells_below : cells_above).push_back(p);
    if (cells_below.empty() || cells_above.empty()) return {};
    auto [below, above] = Split(part.surface, plane);
    std::vector<Part> halves;
    halves.push_back(MakePart(std::move(below), std::move(cells_below)));
    halves.push_back(MakePart(std::move(above), std::move(cells_above)));
    return halves;
  }

  [[nodiscard]] bool IsGoodEnough() const {
    return HullsOf(parts_) <= (1 + options_.tolerance) * volume_m3_ ||
           parts_.size() >= static_cast<std::size_t>(options_.max_pieces);
  }

  // Whether there was anything to cut.
  bool CutOnce() {
    if (parts_.empty() || IsGoodEnough()) return false;
    const auto worst =
        std::max_element(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) {
          return a.air_m3() < b.air_m3();
        });
    if (worst->air_m3() < kWorthACut * volume_m3_) return false;
    std::vector<Part> best;
    for (const CutPlane& plane : BestCuts(worst->cells, cell_m_, kTried)) {
      std::vector<Part> halves = Halves(*worst, plane);
      if (!halves.empty() && (best.empty() || HullsOf(halves) < HullsOf(best)))
        best = std::move(halves);
    }
    if (best.empty()) {
      worst->whole = true;
      return true;
    }
    parts_.erase(worst);
    for (Part& half : best) {
      if (half.hull_m3 > kSmallestShare * volume_m3_) parts_.push_back(std::move(half));
    }
    return true;
  }

  // With the volume of what it stands for: moved along its principal axes, each side by the same
  // way.
  [[nodiscard]] TriangleMesh Fitted(const Part& part) const {
    TriangleMesh piece = part.hull;
    const MassProperties properties = MassPropertiesOf(piece);
    const double wanted = part.own_m3 / properties.volume_m3;
    const Eigen::Matrix3d axes = properties.mesh_from_axes.toRotationMatrix();
    Eigen::Array3d half = Eigen::Array3d::Zero();
    for (const Eigen::Vector3f& p : piece.vertices)
      half = half.max((axes.transpose() * (p.cast<double>() - properties.centre)).array().abs());
    double low_m = -0.5 * std::min<double>(cell_m_, half.minCoeff());
    double high_m = -low_m;
    for (int n = 0; n < 30; ++n) {  // bisection: the volume grows with the way
      const double way_m = 0.5 * (low_m + high_m);
      ((1 + way_m / half).prod() < wanted ? low_m : high_m) = way_m;
    }
    const Eigen::Matrix3d stretch =
        axes * (1 + low_m / half).matrix().asDiagonal() * axes.transpose();
    for (Eigen::Vector3f& p : piece.vertices)
      p = (properties.centre + stretch * (p.cast<double>() - properties.centre)).cast<float>();
    TriangleMesh hull = ConvexHull(piece.vertices);  // rounding may bring two corners to one place
    return hull.empty() ? piece : hull;
  }

  DecomposeOptions options_;
  double volume_m3_ = 0;
  float cell_m_ = 0;
  std::vector<Part> parts_;
};

}  // namespace

void Describe(OptionsVisitor& visitor, DecomposeOptions& options) {
  visitor.Field(
      "max_pieces", options.max_pieces, Range{1, 1000}, "1", "convex pieces of an object, at most");
  visitor.Field("tolerance",
                options.tolerance,
                Range{0, 10},
                "1",
                "hulls are cut until their volumes sum up to so much more than the object's");
}

std::vector<TriangleMesh> Decompose(const TriangleMesh& mesh, const DecomposeOptions& options) {
  if (!shape::CheckMesh(mesh).ok()) {
    TriangleMesh hull = BoundedHull(mesh.vertices, kMaxVertices);
    if (hull.empty()) return {};
    return {std::move(hull)};
  }
  return Decomposition(mesh, options).Pieces();
}

}  // namespace deepslam::convex
