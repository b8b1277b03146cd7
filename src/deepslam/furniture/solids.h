// Closed solids that furniture is put together from.
//
// Every solid is a closed, two-manifold surface of its own with faces counter-clockwise seen from
// outside; solids of one piece of furniture overlap where they touch. Metres, z up, x front.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::furniture {

// What a part is made of: parts of one material share their look.
enum class Material : std::uint8_t { kFrame, kTop, kBody, kDetail };

// Where a point of a solid, from the solid's middle, comes to lie.
using Bend = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;
// Backwards (-x) by `lean` for each metre up.
[[nodiscard]] Bend Leaning(double lean);

class Solids {
 public:
  using Ring = std::vector<Eigen::Vector3d>;

  // The surface through rings of equally many corners (>= 3), closed at both ends by fans round the
  // rings' middles. Rings run the same way round.
  void Loft(Material material, const std::vector<Ring>& rings);

  // Between two level rectangles: middles, and sizes along x and y.
  void Frustum(Material material,
               const Eigen::Vector3d& low,
               const Eigen::Vector2d& low_size,
               const Eigen::Vector3d& high,
               const Eigen::Vector2d& high_size);
  void Box(Material material, const Eigen::Vector3d& middle, const Eigen::Vector3d& size);
  // Round bar along a line of points, its radius changing evenly from the first to the last.
  void Tube(Material material,
            const std::vector<Eigen::Vector3d>& line,
            double first_radius,
            double last_radius,
            int sides = 8);
  // Turned about a vertical axis through `foot`: radii at heights above it.
  void Turned(Material material,
              const Eigen::Vector3d& foot,
              const std::vector<Eigen::Vector2d>& radius_height,
              int sides = 12);
  // Superellipsoid; roundness from near 0 (box) to 1 (ellipsoid), seen from the side and from
  // above.
  void Cushion(Material material,
               const Eigen::Vector3d& middle,
               const Eigen::Vector3d& size,
               double side_roundness,
               double top_roundness,
               const Bend& bend = {});
  // Level plate with a superellipse as outline: roundness as above, 1 = ellipse.
  void Plate(Material material,
             const Eigen::Vector3d& middle,
             const Eigen::Vector3d& size,
             double roundness);
  // Curved board that stands upright: its middle surface is `place(u, h)` for u in [-1, 1] (from
  // right to left) and h in [0, 1] (from below to above), and `thickness` is along x.
  void Board(Material material,
             const std::function<Eigen::Vector3d(double, double)>& place,
             double thickness,
             int columns = 9,
             int rows = 5);

  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  [[nodiscard]] const std::vector<std::uint8_t>& material_of_face() const { return materials_; }
  // Number of the first face of each solid.
  [[nodiscard]] const std::vector<std::uint32_t>& first_faces() const { return first_faces_; }

 private:
  TriangleMesh mesh_;
  std::vector<std::uint8_t> materials_;
  std::vector<std::uint32_t> first_faces_;
};

}  // namespace deepslam::furniture
