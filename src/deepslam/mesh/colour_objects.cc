#include "deepslam/mesh/colour_objects.h"

#include <algorithm>
#include <iterator>

namespace deepslam::mesh {

ObjectColouring::ObjectColouring(const OptimizedMap& map,
                                 const ClassTable& classes,
                                 const ColourOptions& options,
                                 std::span<Result<TriangleMesh>> meshes)
    : map_(map),
      classes_(classes),
      options_(options),
      meshes_(meshes),
      is_coloured_(map.map.objects.size(), 0) {
  const std::vector<MapObject>& objects = map.map.objects;
  for (std::size_t n = 0; n < objects.size(); ++n) index_of_.emplace(objects[n].id, n);
}

std::vector<ObjectTrack> ObjectColouring::TracksToColour(
    std::span<const ObjectTrack> tracks) const {
  std::vector<ObjectTrack> mapped;
  std::ranges::copy_if(tracks, std::back_inserter(mapped), [&](const ObjectTrack& track) {
    return index_of_.contains(track.id);
  });
  return mapped;
}

void ObjectColouring::Colour(ObjectId object, std::span<ObjectView> views) {
  for (ObjectView& view : views) {
    view.world_from_camera =
        map_.frames[static_cast<std::size_t>(view.frame.value)].world_from_camera;
  }
  const std::size_t n = index_of_.at(object);
  ColourBy(n, views);
  is_coloured_[n] = 1;
}

void ObjectColouring::ColourRest() {
  for (std::size_t n = 0; n < is_coloured_.size(); ++n) {
    if (is_coloured_[n] == 0) ColourBy(n, {});
  }
}

void ObjectColouring::ColourBy(std::size_t n, std::span<const ObjectView> views) {
  if (!meshes_[n].ok()) return;
  const MapObject& object = map_.map.objects[n];
  meshes_[n] = ColourMesh(*meshes_[n],
                          views,
                          object.world_from_object,
                          ClassColour(classes_, object.class_name),
                          options_);
}

}  // namespace deepslam::mesh
