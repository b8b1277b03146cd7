#include "deepslam/gltf/gltf_nodes.h"

#include <algorithm>
#include <cmath>

namespace deepslam::gltf {
namespace {

// Exporters round; what is further off is another kind of number.
constexpr double kRotationNormTolerance = 1e-3;
constexpr double kLeastNorm = 0.5;   // of four numbers that are a quaternion, if badly rounded
constexpr double kGreatestNorm = 2;  // beyond, four numbers that are no quaternion

void ReadParts(const JsonPlace& place, GltfNode& node) {
  place["translation"].Numbers({node.translation.data(), 3});
  place["scale"].Numbers({node.scale.data(), 3});
  if ((node.scale.array() == 0).any()) place["scale"].Breach("is zero");
  place["rotation"].Numbers({node.rotation.coeffs().data(), 4});  // both x, y, z, w
  const double norm = node.rotation.norm();
  if (!(norm > kLeastNorm && norm < kGreatestNorm)) {
    place["rotation"].Error("is no unit quaternion");
  } else if (!(std::abs(norm - 1) < kRotationNormTolerance)) {
    place["rotation"].Breach("is no unit quaternion");
  }
}

// The parts are the matrix's as far as it has no shear.
void ReadMatrix(const Eigen::Affine3d& matrix, GltfNode& node) {
  node.matrix = matrix;
  node.translation = matrix.translation();
  node.scale = matrix.linear().colwise().norm();
  if ((node.scale.array() > 0).all())
    node.rotation = Eigen::Matrix3d(matrix.linear() * node.scale.cwiseInverse().asDiagonal());
}

}  // namespace

Eigen::Affine3d GltfNode::ParentFromNode() const {
  if (matrix) return *matrix;
  Eigen::Affine3d parent_from_node = Eigen::Affine3d::Identity();
  parent_from_node.translate(translation);
  parent_from_node.rotate(rotation.normalized());
  parent_from_node.scale(scale);
  return parent_from_node;
}

GltfNode ReadNode(const JsonPlace& root, std::size_t number) {
  const JsonPlace place = root["nodes"].At(number);
  GltfNode node;
  node.name = place["name"].Text();
  node.mesh = place["mesh"].Index(root["meshes"].Size());
  node.children = place["children"].Indices(root["nodes"].Size());
  Eigen::Affine3d matrix = Eigen::Affine3d::Identity();
  if (place["matrix"].Numbers({matrix.data(), 16})) {  // both by columns
    matrix.makeAffine();
    ReadMatrix(matrix, node);
  } else {
    ReadParts(place, node);
  }
  return node;
}

std::vector<int> RootsOfDefaultScene(const JsonPlace& root) {
  const std::size_t num_nodes = root["nodes"].Size();
  const JsonPlace scenes = root["scenes"];
  if (scenes.Size() > 0) {
    const int chosen = root["scene"].Index(scenes.Size());
    return scenes.At(static_cast<std::size_t>(std::max(chosen, 0)))["nodes"].Indices(num_nodes);
  }
  std::vector<bool> is_child(num_nodes, false);
  for (std::size_t n = 0; n < num_nodes; ++n) {
    for (const int child : root["nodes"].At(n)["children"].Indices(num_nodes))
      is_child[static_cast<std::size_t>(child)] = true;
  }
  std::vector<int> roots;
  for (std::size_t n = 0; n < num_nodes; ++n) {
    if (!is_child[n]) roots.push_back(static_cast<int>(n));
  }
  return roots;
}

}  // namespace deepslam::gltf
