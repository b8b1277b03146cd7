// The objects of a map in the colours that its frames saw.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/mesh/colour_mesh.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/optimized_map.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::mesh {

// Colours the meshes of a map's objects one by one, as their views come. Map, classes and meshes
// outlive it. What no view saw has its class's colour; an object that has no mesh goes without.
class ObjectColouring {
 public:
  // `meshes`: one per object of the map, metric object frame.
  ObjectColouring(const OptimizedMap& map,
                  const ClassTable& classes,
                  const ColourOptions& options,
                  std::span<Result<TriangleMesh>> meshes);

  // The tracks of objects that are in the map.
  [[nodiscard]] std::vector<ObjectTrack> TracksToColour(std::span<const ObjectTrack> tracks) const;

  // By the views of one of these tracks, whose cameras are replaced by the map's. Different objects
  // may be coloured at the same time.
  void Colour(ObjectId object, std::span<ObjectView> views);

  // Those of the objects that were not.
  void ColourRest();

 private:
  void ColourBy(std::size_t n, std::span<const ObjectView> views);

  const OptimizedMap& map_;
  const ClassTable& classes_;
  const ColourOptions options_;
  const std::span<Result<TriangleMesh>> meshes_;
  std::map<ObjectId, std::size_t> index_of_;
  std::vector<unsigned char> is_coloured_;  // a byte each: written by several threads
};

}  // namespace deepslam::mesh
