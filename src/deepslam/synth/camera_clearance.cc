#include "deepslam/synth/camera_clearance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace deepslam::synth {
namespace {

constexpr int kNumDirections = 256;  // about 13 degrees apart
// Of all directions; meshes of furniture leave gaps.
constexpr double kEnclosedShare = 0.9;

// Evenly over the sphere (Fibonacci's lattice).
std::vector<Eigen::Vector3f> Directions() {
  std::vector<Eigen::Vector3f> directions;
  for (int i = 0; i < kNumDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kNumDirections;
    const double turn_rad = 2 * std::numbers::pi * i / std::numbers::phi;
    const double r = std::sqrt(1 - z * z);
    directions.emplace_back(
        Eigen::Vector3d(r * std::cos(turn_rad), r * std::sin(turn_rad), z).cast<float>());
  }
  return directions;
}

}  // namespace

CameraClearance::CameraClearance(const TriangleMesh& mesh_object) {
  const Result<int> added = scene_.AddMesh(mesh_object, Pose3());
  DEEPSLAM_CHECK(added.ok(), "BuildWorld checks the models");
  scene_.Commit();
}

bool CameraClearance::Blocked(const Eigen::Vector3d& p_object, double margin_m) const {
  int num_hit = 0;
  for (const Eigen::Vector3f& direction : Directions()) {
    const std::optional<render::RayHit> hit = scene_.Cast(p_object.cast<float>(), direction);
    if (!hit) continue;
    if (hit->distance_m < margin_m) return true;
    ++num_hit;
  }
  return num_hit >= kEnclosedShare * kNumDirections;
}

}  // namespace deepslam::synth
