#include "deepslam/gltf/draco_encode.h"
#include "deepslam/gltf/scene_writer.h"

namespace deepslam::gltf {

void Describe(OptionsVisitor& visitor, GltfOptions& options) {
  visitor.Field("draco", options.draco, "compress meshes by KHR_draco_mesh_compression");
  visitor.Field("position_bits",
                options.position_bits,
                {static_cast<double>(kMinPositionBits), static_cast<double>(kMaxPositionBits)},
                "1",
                "Draco: bits per coordinate over a mesh's longest side");
  visitor.Field("normal_bits", options.normal_bits, {4, 16}, "1", "Draco: bits per normal");
  visitor.Field("crease_angle_deg",
                options.crease_angle_deg,
                {0, 180},
                "deg",
                "edges sharper than this are shaded sharp");
  visitor.Field("cameras", options.cameras, "write the keyframes' cameras");
  visitor.Field("max_frustum_m",
                options.max_frustum_m,
                {0.1, 1000},
                "m",
                "far end of the keyframes' cameras");
}

}  // namespace deepslam::gltf
