#include "deepslam/shape/render_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "deepslam/core/check.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::shape {
namespace {

constexpr auto kVoxel = static_cast<float>(kVoxelSize);

constexpr float kFar = std::numeric_limits<float>::max();

// Rays are worked on side by side, one in each lane.
constexpr std::size_t kLanes = 8;
using Lanes [[gnu::vector_size(kLanes * sizeof(float))]] = float;
using IntLanes [[gnu::vector_size(kLanes * sizeof(float))]] = std::int32_t;  // flags: 0 or -1

// Rays in the object frame, start + t * direction, where t is the depth in the camera.
struct Rays {
  std::array<float, 3> start;
  std::array<Lanes, 3> direction{};
  Lanes length{};  // of `direction`
  Lanes t_in;      // interval of t inside the model's box
  Lanes t_out;     // <= t_in where the ray misses it
};

void TakeSmaller(const Lanes& other, Lanes& lanes) { lanes = other < lanes ? other : lanes; }
void TakeLarger(const Lanes& other, Lanes& lanes) { lanes = other > lanes ? other : lanes; }

bool IsAny(const IntLanes& flags) {
  std::int32_t any = 0;
  for (std::size_t n = 0; n < kLanes; ++n) any |= flags[n];
  return any != 0;
}

// Rays of consecutive pixels of a row, the first at column u.
void CastRays(const PinholeCamera& camera,
              const Eigen::Matrix3d& object_from_camera,
              int u,
              int v,
              Rays& rays) {
  const Eigen::Matrix3d& turn = object_from_camera;
  const double y = (v - camera.cy) / camera.fy;
  const Eigen::Vector3d of_row = turn.col(1) * y + turn.col(2);
  for (std::size_t n = 0; n < kLanes; ++n) {
    const double x = (u + static_cast<int>(n) - camera.cx) / camera.fx;
    const Eigen::Vector3f direction = (turn.col(0) * x + of_row).cast<float>();
    for (std::size_t axis = 0; axis < 3; ++axis)
      rays.direction[axis][n] = direction[static_cast<Eigen::Index>(axis)];
    rays.length[n] = direction.norm();
  }
}

void ClipToBox(const Eigen::Vector3f& box_min, const Eigen::Vector3f& box_max, Rays& rays) {
  rays.t_in = Lanes{};
  rays.t_out = Lanes{} + kFar;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    // Infinite for a parallel ray, as the slab test wants.
    const Lanes inverse = 1.0F / rays.direction[axis];
    const Lanes a = (box_min[row] - rays.start[axis]) * inverse;
    const Lanes b = (box_max[row] - rays.start[axis]) * inverse;
    const IntLanes is_known = (a == a) & (b == b);
    const Lanes nearer = b < a ? b : a;
    const Lanes farther = a < b ? b : a;
    TakeLarger(is_known ? nearer : Lanes{}, rays.t_in);
    TakeSmaller(is_known ? farther : Lanes{} + kFar, rays.t_out);
  }
}

// As VoxelGrid::Index.
void IndicesOf(const std::array<IntLanes, 3>& voxel, IntLanes& index) {
  index = (voxel[0] * kGridSize + voxel[1]) * kGridSize + voxel[2];
}

// At voxels' centres.
void TakeDistances(const ShapeModel& model, const IntLanes& index, Lanes& distances) {
  // Columns along k lie one after another: k alone counts through all voxels.
  for (std::size_t n = 0; n < kLanes; ++n) distances[n] = model.DistanceAt(0, 0, index[n]);
}

// Rays on their way to the first solid.
struct March {
  Lanes nudge;
  Lanes t;
  Lanes t_face{};               // where they met it, 0 as long as they have not
  IntLanes is_on;               // neither there nor out of the box
  std::array<Lanes, 3> scaled;  // where they are, voxels
  std::array<IntLanes, 3> voxel;
  Lanes distance{};  // of that voxel
};

// Moves rays that are on; far away small steps are less than the last digit of t, which is >= 0.
void Advance(const Lanes& step, March& march) {
  const Lanes beyond = march.t + step;
  const Lanes next = reinterpret_cast<Lanes>(reinterpret_cast<IntLanes>(march.t) + 1);
  march.t = beyond > march.t ? beyond : next;
}

void Locate(const ShapeModel& model, const Rays& rays, March& march) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    march.scaled[axis] = ((rays.start[axis] + march.t * rays.direction[axis]) + 0.5F) *
                         static_cast<float>(kGridSize);
    march.is_on &=
        (march.scaled[axis] >= 0.0F) & (march.scaled[axis] < static_cast<float>(kGridSize));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Lanes within = march.is_on ? march.scaled[axis] : Lanes{};
    march.voxel[axis] = __builtin_convertvector(within, IntLanes);
  }
  IntLanes index;
  IndicesOf(march.voxel, index);
  TakeDistances(model, index, march.distance);
}

void Step(const Rays& rays, March& march) {
  const IntLanes is_there = march.is_on & (march.distance < 0.0F);
  march.t_face = (is_there & (march.t > march.nudge)) ? march.t : march.t_face;
  march.is_on &= ~is_there;
  Lanes exit = Lanes{} + kFar;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Lanes& direction = rays.direction[axis];
    const Lanes face = __builtin_convertvector(march.voxel[axis], Lanes) +
                       (direction > 0.0F ? Lanes{} + 1.0F : Lanes{});
    const Lanes to_face = (face - march.scaled[axis]) * kVoxel * (1.0F / direction);
    TakeSmaller(direction == 0.0F ? exit : to_face, exit);
  }
  TakeLarger(Lanes{}, exit);
  // Both the point and the nearest solid may be half a voxel's diagonal nearer than the centres
  // say.
  const Lanes safe = march.distance - 1.25F * kVoxel;
  Advance(safe > kVoxel ? safe / rays.length : exit + march.nudge, march);
  march.is_on &= march.t < rays.t_out;
}

// t of the first solid met, 0 when there is none.
void FindFaces(const ShapeModel& model, const Rays& rays, Lanes& t) {
  March march;
  march.nudge = 1e-4F * kVoxel / rays.length;
  march.t = rays.t_in + march.nudge;
  march.is_on = (rays.t_in < rays.t_out) & (march.t < rays.t_out);
  while (IsAny(march.is_on)) {
    Locate(model, rays, march);
    Step(rays, march);
  }
  t = march.t_face;
}

// Interpolated as ShapeModel::Distance does, which is asked where points lie beyond the centres of
// the outermost voxels. Only where `is_asked`.
void InterpolateDistances(const ShapeModel& model,
                          const std::array<Lanes, 3>& points,
                          const IntLanes& is_asked,
                          Lanes& distances) {
  constexpr float kInside = 0.5F - 0.5F * kVoxel;  // to the centres of the outermost voxels
  IntLanes is_inside = is_asked;
  for (const Lanes& p : points) is_inside &= (p >= -kInside) & (p <= kInside);
  std::array<IntLanes, 3> base;
  std::array<Lanes, 3> t;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Lanes voxel = (points[axis] + 0.5F) * static_cast<float>(kGridSize) - 0.5F;
    const Lanes within = is_inside ? voxel : Lanes{};
    base[axis] = __builtin_convertvector(within, IntLanes);
    base[axis] = base[axis] < 0 ? IntLanes{} : base[axis];
    base[axis] = base[axis] > kGridSize - 2 ? IntLanes{} + (kGridSize - 2) : base[axis];
    t[axis] = within - __builtin_convertvector(base[axis], Lanes);
  }
  IntLanes corner;
  IndicesOf(base, corner);
  std::array<Lanes, 8> at;  // its bits: one further along x, y, z
  for (int c = 0; c < 8; ++c) {
    const IntLanes index =
        corner + ((c >> 2) * kGridSize * kGridSize + (c >> 1 & 1) * kGridSize + (c & 1));
    TakeDistances(model, index, at[static_cast<std::size_t>(c)]);
  }
  const auto mix = [](const Lanes& to, const Lanes& weight, Lanes& from) {
    from += weight * (to - from);
  };
  for (const std::size_t c : {0U, 2U, 4U, 6U}) mix(at[c + 1], t[2], at[c]);
  for (const std::size_t c : {0U, 4U}) mix(at[c + 2], t[1], at[c]);
  mix(at[4], t[0], at[0]);
  distances = at[0];
  const IntLanes is_beyond = is_asked & ~is_inside;
  if (!IsAny(is_beyond)) return;
  for (std::size_t n = 0; n < kLanes; ++n) {
    if (is_beyond[n] != 0)
      distances[n] = model.Distance({points[0][n], points[1][n], points[2][n]});
  }
}

// Moves from voxels' faces to the zero level of the signed distance, which has no stairs.
void Refine(const ShapeModel& model, const Rays& rays, Lanes& t) {
  const Lanes t_face = t;
  const Lanes reach = kVoxel / rays.length;
  IntLanes is_near = t_face > 0.0F;
  for (int step = 0; step < 4 && IsAny(is_near); ++step) {
    std::array<Lanes, 3> points;
    for (std::size_t axis = 0; axis < 3; ++axis)
      points[axis] = rays.start[axis] + t * rays.direction[axis];
    Lanes distances;
    InterpolateDistances(model, points, is_near, distances);
    t += distances / rays.length;
    const Lanes moved = t - t_face;
    is_near &= ~((moved > reach) | (moved < -reach));
    t = is_near ? t : t_face;
  }
}

struct PixelBox {
  int u_min, v_min, u_max, v_max;
};

// Pixels that the model's box can reach; the whole image when a corner is behind the camera.
PixelBox ReachablePixels(const ShapeModel& model,
                         const Similarity3& camera_from_object,
                         const PinholeCamera& camera) {
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p_object((corner & 1) != 0 ? model.box_max().x() : model.box_min().x(),
                                   (corner & 2) != 0 ? model.box_max().y() : model.box_min().y(),
                                   (corner & 4) != 0 ? model.box_max().z() : model.box_min().z());
    const std::optional<Eigen::Vector2d> pixel = camera.Project(camera_from_object * p_object);
    if (!pixel) return {0, 0, camera.width - 1, camera.height - 1};
    low = low.min(pixel->array());
    high = high.max(pixel->array());
  }
  const auto clamped = [](double value, int size) {
    return static_cast<int>(std::clamp(value, -1.0, static_cast<double>(size)));
  };
  return {std::max(0, clamped(std::floor(low.x()), camera.width)),
          std::max(0, clamped(std::floor(low.y()), camera.height)),
          std::min(camera.width - 1, clamped(std::ceil(high.x()), camera.width)),
          std::min(camera.height - 1, clamped(std::ceil(high.y()), camera.height))};
}

}  // namespace

DEEPSLAM_WIDE_VECTORS DepthImage RenderDepth(const ShapeModel& model,
                                             const Similarity3& camera_from_object,
                                             const PinholeCamera& camera) {
  DEEPSLAM_CHECK(camera.fx > 0 && camera.fy > 0, "camera without focal length");
  DepthImage depth_m(camera.width, camera.height, 0.0F);
  if (model.empty() || !(camera_from_object.scale > 0)) return depth_m;
  const Similarity3 object_from_camera = camera_from_object.Inverse();
  if (!object_from_camera.translation_m.allFinite()) return depth_m;
  const Eigen::Matrix3d turn =
      object_from_camera.scale * object_from_camera.rotation.toRotationMatrix();
  const PixelBox box = ReachablePixels(model, camera_from_object, camera);
  Rays rays;
  const Eigen::Vector3f start = object_from_camera.translation_m.cast<float>();
  rays.start = {start.x(), start.y(), start.z()};
  for (int v = box.v_min; v <= box.v_max; ++v) {
    for (int u = box.u_min; u <= box.u_max; u += static_cast<int>(kLanes)) {
      CastRays(camera, turn, u, v, rays);
      ClipToBox(model.box_min(), model.box_max(), rays);
      Lanes t;
      FindFaces(model, rays, t);
      Refine(model, rays, t);
      const auto num_rays = std::min(kLanes, static_cast<std::size_t>(box.u_max - u + 1));
      for (std::size_t n = 0; n < num_rays; ++n) {
        depth_m(u + static_cast<int>(n), v) = std::max(0.0F, t[n]);
      }
    }
  }
  return depth_m;
}

}  // namespace deepslam::shape
