#include "deepslam/synth/truth.h"

#include <fmt/format.h>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam::synth {
namespace {

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\u{:04x}", static_cast<int>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

}  // namespace

std::string TruthJson(const World& world) {
  std::string json =
      "{\n  \"format\": \"deepslam-truth/1\",\n  \"room\": \"room.ply\",\n  \"objects\": [";
  for (std::size_t i = 0; i < world.objects.size(); ++i) {
    const PlacedObject& object = world.objects[i];
    const Eigen::Vector3d& t = object.world_from_object.translation_m;
    const Eigen::Quaterniond& q = object.world_from_object.rotation;
    json += fmt::format(
        "{}\n    {{\"id\": {}, \"class\": {}, \"model\": {}, \"mesh\": \"meshes/{}.ply\",\n"
        "     \"size_m\": [{:.6f}, {:.6f}, {:.6f}], \"scale_m\": {:.9f},\n"
        "     \"translation_m\": [{:.6f}, {:.6f}, {:.6f}], \"rotation_xyzw\": [{:.9f}, {:.9f}, "
        "{:.9f}, {:.9f}]}}",
        i == 0 ? "" : ",",
        i,
        Quoted(object.class_name),
        Quoted(object.model),
        i,
        object.size_m.x(),
        object.size_m.y(),
        object.size_m.z(),
        object.size_m.maxCoeff() / kModelExtent,
        t.x(),
        t.y(),
        t.z(),
        q.x(),
        q.y(),
        q.z(),
        q.w());
  }
  return json + "\n  ]\n}\n";
}

}  // namespace deepslam::synth
