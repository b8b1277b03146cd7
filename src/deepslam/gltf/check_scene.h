// Whether what shall be written can be written, and what is equal in it.
#pragma once

#include <set>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/gltf/scene_writer.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::gltf {

// Indices in range, coordinates finite, a colour per vertex or none. Errors begin with `name`.
[[nodiscard]] Status CheckMeshInput(const TriangleMesh& mesh, const std::string& name);

// Finite, with a rotation. Errors begin with `name`.
[[nodiscard]] Status CheckPose(const Pose3& pose, const std::string& name);

// The object's name as valid UTF-8, made of class and instance where it is empty, with a suffix
// where it is taken; joins `taken`.
[[nodiscard]] std::string UniqueName(const GltfObject& object, std::set<std::string>& taken);
// The same of any name.
[[nodiscard]] std::string UniqueName(const std::string& name, std::set<std::string>& taken);

// Same faces, and vertices that are `ratio` times those of `first` but for rounding. Colours are
// not compared.
[[nodiscard]] bool IsScaledCopy(const TriangleMesh& mesh, const TriangleMesh& first, double ratio);

}  // namespace deepslam::gltf
