// Nodes of a glTF: what they are called, what they carry and where they stand.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "deepslam/gltf/json_place.h"

namespace deepslam::gltf {

struct GltfNode {
  std::string name;
  int mesh = -1;
  std::vector<int> children;
  // parent_from_node, as three parts or, where the file has it so, as one matrix.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // about a unit
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  std::optional<Eigen::Affine3d> matrix;

  [[nodiscard]] Eigen::Affine3d ParentFromNode() const;
};

// Node `number` of a document, its indices in range.
[[nodiscard]] GltfNode ReadNode(const JsonPlace& root, std::size_t number);

// Nodes that the default scene begins with; of a document without scenes those that are no node's
// child.
[[nodiscard]] std::vector<int> RootsOfDefaultScene(const JsonPlace& root);

}  // namespace deepslam::gltf
