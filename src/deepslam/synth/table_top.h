// Where on a table's top a point is: for tops whose depth comes from near their edges only.
#pragma once

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::synth {

class TableTop {
 public:
  // The highest level surface of a mesh in its object frame (z up, metres), whatever its outline.
  explicit TableTop(const TriangleMesh& mesh_object);

  // Whether the point lies on the top and further than `margin_m` from its outline; exact to about
  // a cell (5 mm).
  [[nodiscard]] bool Inside(const Eigen::Vector3d& p_object, double margin_m) const;

 private:
  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  double top_m_ = 0;
  Image<float> to_edge_m_;
};

}  // namespace deepslam::synth
