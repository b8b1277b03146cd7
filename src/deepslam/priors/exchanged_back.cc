#include "deepslam/priors/exchanged_back.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/furniture/joined.h"
#include "deepslam/scene/mesh_box.h"
#include "deepslam/scene/voxel_grid.h"
#include "deepslam/shape/small_components.h"
#include "deepslam/shape/voxelize.h"

namespace deepslam::priors {

namespace {

constexpr double kLeastTogether = 0.95;  // of the voxels in the largest part
constexpr double kLeastSolid = 0.8;      // of the volume that the two parts had

struct Seat {
  VoxelGrid shape;
  float height = 0;  // share of the model's
  double below_m3 = 0;
  double above_m3 = 0;
};

double VoxelVolume(const TriangleMesh& mesh) {
  return std::pow(
      static_cast<double>(BoxOfFaces(mesh).sizes().maxCoeff()) / kModelExtent / kGridSize, 3);
}

std::optional<Seat> SeatOf(const TriangleMesh& mesh) {
  Result<VoxelGrid> shape = shape::Voxelize(mesh);
  if (!shape) return std::nullopt;
  const std::optional<float> height = furniture::SeatHeight(*shape);
  if (!height) return std::nullopt;
  Seat seat{std::move(*shape), *height};
  const VoxelBox box = *OccupiedBox(seat.shape);
  const double top = box.low.z() + static_cast<double>(seat.height) * box.sides().z();
  const double voxel_m3 = VoxelVolume(mesh);
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        if (seat.shape.At(i, j, k)) (k < top ? seat.below_m3 : seat.above_m3) += voxel_m3;
      }
    }
  }
  return seat;
}

bool HangsTogether(const VoxelGrid& shape) {
  std::size_t all = 0;
  std::size_t largest = 0;
  for (const std::vector<std::size_t>& part : shape::PartsOf(shape, 1)) {
    all += part.size();
    largest = std::max(largest, part.size());
  }
  return static_cast<double>(largest) >= kLeastTogether * static_cast<double>(all);
}

}  // namespace

TriangleMesh WithBackOf(const TriangleMesh& mesh, const TriangleMesh& other) {
  const std::optional<Seat> seat = SeatOf(mesh);
  const std::optional<Seat> other_seat = SeatOf(other);
  if (!seat || !other_seat) return mesh;
  TriangleMesh joined = furniture::JoinAtSeat({mesh, seat->shape, seat->height},
                                              {other, other_seat->shape, other_seat->height});
  const Result<VoxelGrid> shape = shape::Voxelize(joined);
  if (!shape || !HangsTogether(*shape)) return mesh;
  const Eigen::Vector3f scale =
      BoxOfFaces(mesh).sizes().cwiseQuotient(BoxOfFaces(other).sizes().cwiseMax(1e-6F));
  const double expected_m3 =
      seat->below_m3 + static_cast<double>(scale.x() * scale.y()) * other_seat->above_m3;
  const auto voxels = std::count(shape->occupied.begin(), shape->occupied.end(), 1);
  const double solid_m3 = static_cast<double>(voxels) * VoxelVolume(joined);
  return solid_m3 >= kLeastSolid * expected_m3 ? joined : mesh;
}

}  // namespace deepslam::priors
