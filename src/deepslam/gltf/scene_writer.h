// A labelled scene as one binary glTF 2.0 file (GLB), as bytes.
//
// In: world and object frames with z up, x front, y left, metres. Out: glTF's axes (y up, z front,
// x left), made here alone: (x, y, z) of ours is (y, z, x) there, for vertices and for node
// transforms, so every node keeps a plain translation and rotation and opens upright in any
// program.
//
// Nodes of the scene, in this order: one per object (name `chair_03`, extras {class, instance,
// score, prior, views}), one per part of the room itself (name `wall_03`, extras {layout, id,
// rooms,
// ...}), `ground`, `room`, `trajectory` (LINE_STRIP), `keyframes` (its children are cameras
// `keyframe_000017`).
//
// Objects of the same model whose meshes carry no colours and are equal up to size share one mesh;
// the size is then the node's scale. Coloured objects have a mesh each, since the colours lie in
// it, and can be switched by KHR_materials_variants: `appearance` (the vertex colours, the default)
// and `class` (the flat class colour). Labels stand in names and extras alone, which are core glTF.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::gltf {

struct GltfObject {
  std::string name;  // `chair_03`; made valid UTF-8, and unique by a suffix where it is not
  std::string class_name;
  int instance = 0;
  double score = 0;        // [0, 1]
  std::string source;      // where the shape came from; extras.prior
  std::vector<int> views;  // frames that saw it
  TriangleMesh mesh;       // object frame, m; coloured (sRGB) or not
  Pose3 world_from_object;
  Rgb8 class_colour{160, 160, 160};  // sRGB; used where the mesh has no colours
  std::string credit;                // creator and licence of a CAD model; empty = none
  // Key of the shape, and metres per unit of it: objects of one model without colours of their own
  // share a mesh. Empty = shares with none.
  std::string model;
  double scale_m = 1;
};

// A part of the room itself: a wall, a door, a ceiling.
struct GltfPart {
  std::string name;                       // `wall_03`; unique as names of objects are
  std::string kind;                       // extras.layout
  int id = 0;                             // extras.id
  std::vector<int> rooms;                 // extras.rooms: whose it is
  std::optional<int> wall;                // extras.wall: that an opening is in
  std::map<std::string, double> figures;  // extras of these names: lengths, areas, confidence
  TriangleMesh mesh_world;                // closed; empty: a node without a mesh
  Rgb8 colour{200, 200, 200};             // sRGB; used where the mesh has no colours
  double opacity = 1;                     // below 1: what lies behind it is seen through it
};

struct GltfKeyframe {
  int frame = 0;
  Pose3 world_from_camera;
};

struct GltfScene {
  std::vector<GltfObject> objects;
  std::vector<GltfPart> parts;         // of the room itself
  std::optional<TriangleMesh> room;    // world, may be open
  std::optional<TriangleMesh> ground;  // world polygon
  std::vector<Pose3> trajectory_world_from_camera;
  std::vector<GltfKeyframe> keyframes;
  PinholeCamera camera;  // of the keyframes; width 0 = unknown, no cameras are written
  std::string generator = "deepslam";
  std::map<std::string, std::string> provenance;  // into asset.extras: version, capture hash ...
};

struct GltfOptions {
  bool draco =
      true;  // KHR_draco_mesh_compression for objects and room; false = the uncompressed copy
  int position_bits = 14;  // Draco: vertices lie on a grid of longest side / (2^bits - 1)
  // Draco: octahedral normals of 8 bits err by less than a degree.
  static constexpr int kNormalBits = 8;
  // Edges sharper than this are shaded sharp: between round legs of twelve sides (30 degrees) and
  // corners.
  static constexpr double kCreaseAngle_deg = 40;
  bool cameras = true;  // keyframe cameras
  // Far end of the keyframe cameras: a room.
  static constexpr double kMaxFrustum_m = 10;
};
void Describe(OptionsVisitor& visitor, GltfOptions& options);

// Same scene and options, same bytes. An empty scene is a valid file. Objects with an empty mesh
// stay as nodes without mesh. Errors: indices out of range, coordinates or poses that are not
// finite, each with the object's name.
[[nodiscard]] Result<std::string> WriteGlb(const GltfScene& scene, const GltfOptions& options);

struct GlbKind {
  bool draco = true;           // in place of that of the options
  bool objects_alone = false;  // to say how large they are: no surroundings, path or cameras
};

// Each as WriteGlb writes it. Meshes are encoded once for all, side by side.
[[nodiscard]] std::vector<Result<std::string>> WriteGlbs(const GltfScene& scene,
                                                         const GltfOptions& options,
                                                         std::span<const GlbKind> kinds);

}  // namespace deepslam::gltf
