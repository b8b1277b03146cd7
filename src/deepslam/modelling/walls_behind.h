// The walls that an object cannot reach through: what nobody saw of it ends at them.
#pragma once

#include <span>
#include <vector>

#include "deepslam/geometry/plane.h"
#include "deepslam/geometry/similarity.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::modelling {

// Faces of walls that the model's box crosses where it stands (world: that of the views), over half
// of its length along the wall at least, with all cameras on the face's side. In the model's frame
// and unit, normals to that side, moved back by 3 cm. Whether the object was measured behind one,
// as through a door, is not asked.
[[nodiscard]] std::vector<Plane> WallsBehind(const Layout& layout,
                                             const shape::ShapeModel& model,
                                             const Similarity3& world_from_object,
                                             std::span<const ObjectView> views);

}  // namespace deepslam::modelling
