// An own check of a GLB: reread, decoded, measured. For foreign and damaged files as well: it never
// trusts a count.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/pose.h"
#include "deepslam/gltf/findings.h"

namespace deepslam::gltf {

struct ValidatedObject {
  std::string name;
  std::string class_name;
  int instance = 0;
  std::string prior;                                 // extras.prior
  std::optional<double> score;                       // extras.score
  Pose3 world_from_object;                           // in our axes: z up, m
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // of the mesh along the object's axes
  int num_vertices = 0;                              // after welding by position
  int num_faces = 0;
  int num_components = 0;
  double volume_m3 = 0;
  bool closed = false;
  bool two_manifold = false;
};

// A part of the room itself (a node with extras.layout).
struct ValidatedPart {
  std::string name;
  std::string kind;
  int id = 0;
  bool has_mesh = false;
};

struct ValidationReport {
  std::vector<std::string>
      errors;  // each names the place ("accessors[3].count: ..."); at most kMaxFindings
  std::vector<std::string> warnings;
  int num_objects = 0;  // nodes with extras.class
  int num_nodes = 0;
  int num_meshes = 0;
  int num_cameras = 0;
  std::int64_t num_vertices = 0;  // of all triangle primitives, as stored
  std::int64_t num_faces = 0;
  std::size_t num_bytes = 0;
  bool draco = false;                 // any primitive compressed
  std::vector<std::string> variants;  // appearances the scene can be switched between
  bool has_ground = false;
  bool has_room = false;
  bool has_trajectory = false;
  std::vector<ValidatedObject> objects;
  std::vector<ValidatedPart> parts;

  [[nodiscard]] bool ok() const { return errors.empty(); }
};

// Checks header and chunks, JSON, buffer views, accessors (bounds, alignment, true min and max),
// indices, Draco payloads against their accessors, materials of variants, transforms, the node
// tree, labels (name and extras agree, instance unique), and that every object and every part of
// the room itself is closed, oriented and two-manifold after welding by position. Structure first:
// later checks run on what passed.
[[nodiscard]] ValidationReport ValidateGlb(std::string_view bytes);

}  // namespace deepslam::gltf
