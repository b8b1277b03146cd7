#include "deepslam/shape/render_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deepslam/core/check.h"

namespace deepslam::shape {
namespace {

constexpr auto kVoxel = static_cast<float>(kVoxelSize);

// A ray in the object frame, start + t * direction, where t is the depth in the camera.
struct Ray {
  Eigen::Vector3f start;
  Eigen::Vector3f direction;
  float length = 1;  // of `direction`
};

// Interval of t inside the box, t_in > t_out when the ray misses it.
void ClipToBox(const Ray& ray,
               const Eigen::Vector3f& box_min,
               const Eigen::Vector3f& box_max,
               float& t_in,
               float& t_out) {
  for (int axis = 0; axis < 3; ++axis) {
    const float inverse =
        1.0F / ray.direction[axis];  // infinite for a parallel ray, as the slab test wants
    const float a = (box_min[axis] - ray.start[axis]) * inverse;
    const float b = (box_max[axis] - ray.start[axis]) * inverse;
    if (std::isnan(a) || std::isnan(b)) continue;
    t_in = std::max(t_in, std::min(a, b));
    t_out = std::min(t_out, std::max(a, b));
  }
}

// Moves from a voxel's face to the zero level of the signed distance, which has no stairs.
float Refined(const ShapeModel& model, const Ray& ray, float t_face) {
  const float reach = kVoxel / ray.length;
  float t = t_face;
  for (int n = 0; n < 4; ++n) {
    t += model.Distance(ray.start + t * ray.direction) / ray.length;
    if (std::abs(t - t_face) > reach) return t_face;
  }
  return t;
}

// A step along a ray; far away small steps are less than the last digit of t.
float Beyond(float t, float step) {
  const float beyond = t + step;
  return beyond > t ? beyond : std::nextafter(t, std::numeric_limits<float>::infinity());
}

// t of the first solid met, 0 when there is none.
float March(const ShapeModel& model, const Ray& ray, float t_in, float t_out) {
  const Eigen::Vector3f inverse = ray.direction.cwiseInverse();
  const float nudge = 1e-4F * kVoxel / ray.length;
  float t = t_in + nudge;
  while (t < t_out) {
    const Eigen::Vector3f scaled =
        ((ray.start + t * ray.direction).array() + 0.5F) * static_cast<float>(kGridSize);
    const Eigen::Array3i voxel = scaled.array().floor().cast<int>();
    if (!VoxelGrid::Contains(voxel.x(), voxel.y(), voxel.z())) return 0;
    const float distance = model.DistanceAt(voxel.x(), voxel.y(), voxel.z());
    if (distance < 0) return t > nudge ? t : 0;
    // Both the point and the nearest solid may be half a voxel's diagonal nearer than the centres
    // say.
    const float safe = distance - 1.25F * kVoxel;
    if (safe > kVoxel) {
      t = Beyond(t, safe / ray.length);
      continue;
    }
    float exit = std::numeric_limits<float>::max();
    for (int axis = 0; axis < 3; ++axis) {
      if (ray.direction[axis] == 0) continue;
      const float face = static_cast<float>(voxel[axis]) + (ray.direction[axis] > 0 ? 1.0F : 0.0F);
      exit = std::min(exit, (face - scaled[axis]) * kVoxel * inverse[axis]);
    }
    t = Beyond(t, std::max(exit, 0.0F) + nudge);
  }
  return 0;
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

DepthImage RenderDepth(const ShapeModel& model,
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
  Ray ray;
  ray.start = object_from_camera.translation_m.cast<float>();
  for (int v = box.v_min; v <= box.v_max; ++v) {
    for (int u = box.u_min; u <= box.u_max; ++u) {
      ray.direction = (turn * camera.Ray(u, v)).cast<float>();
      ray.length = ray.direction.norm();
      float t_in = 0;
      float t_out = std::numeric_limits<float>::max();
      ClipToBox(ray, model.box_min(), model.box_max(), t_in, t_out);
      if (t_in >= t_out) continue;
      const float t_face = March(model, ray, t_in, t_out);
      if (t_face > 0) depth_m(u, v) = std::max(0.0F, Refined(model, ray, t_face));
    }
  }
  return depth_m;
}

}  // namespace deepslam::shape
