#include "deepslam/registration/view_matches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/depth_noise.h"
#include "deepslam/geometry/point_columns.h"

namespace deepslam::registration {
namespace {

// A model of the right kind is still some centimetres beside the object; matching closer than this
// means nothing.
constexpr float kModelSigma = 0.01F;
// A measured depth this close to the model's, outside the segment, is neither for nor against it.
constexpr float kNeutralGap = 0.03F;
// Silhouettes are cut out by the segmentation, not measured: half the say of a measured point.
constexpr float kSilhouetteWeight = 0.5F;
// Below this cosine measured and model surface do not face the same way.
constexpr float kMinFacing = 0.2F;
// A point outside the model whose normal is further than this from the model's lies beside an edge.
constexpr float kEdgeFacing = 0.6F;
// Points looked at together; what they say fills at most two of the batches that are summed.
constexpr std::size_t kTogether = kPointBatch / 2;

float TukeyWeight(float residual, float per_radius) {
  const float t = residual * per_radius;
  const float rest = 1.0F - t * t;
  return rest > 0 ? rest * rest : 0.0F;
}

float Truncated(float residual, float per_radius) {
  const float t = residual * per_radius;
  return t * t < 1.0F ? t * t : 1.0F;
}

// Of the model's surface; what a point's depth adds is its own.
float ModelVariance(float scale_m) {
  const float voxel_sigma = 0.29F * scale_m * static_cast<float>(kVoxelSize);  // within a voxel
  return kModelSigma * kModelSigma + voxel_sigma * voxel_sigma;
}

// A view relative to the placed model.
struct PlacedView {
  PlacedView(const MeasuredView& view, const Similarity3& world_from_object)
      : PlacedView(view.world_from_camera.Inverse() * world_from_object) {}
  explicit PlacedView(const Similarity3& placed)
      : PlacedView(SimilarityMatrix(placed), SimilarityMatrix(placed.Inverse()), placed.scale) {}

  Eigen::Vector3d camera_object;  // the camera's place, object units
  float scale_m;
  AffineMap camera_from_object;
  AffineMap object_from_camera;
  LinearMap object_axes_from_camera;  // of directions

 private:
  PlacedView(const SimilarityMatrix& there, const SimilarityMatrix& back, double scale)
      : camera_object(back.translation_m),
        scale_m(static_cast<float>(scale)),
        camera_from_object(there.linear.cast<float>(), there.translation_m.cast<float>()),
        object_from_camera(back.linear.cast<float>(), back.translation_m.cast<float>()),
        object_axes_from_camera(back.rotation.cast<float>()) {}
};

struct SurfaceMatch {
  float distance_m;        // >= 0
  float plane_residual_m;  // along the measured normal
  float facing;
  bool is_beside;  // outside the model, and its nearest surface is an edge seen from the side
  Triple outward;  // model normal there, unit; zero where there is none
};

SurfaceMatch MatchSurface(float distance, const Triple& gradient, const Triple& n, float scale_m) {
  // Of a gradient; it is 1 but at ridges of the field, which face nowhere.
  constexpr float kMinLength = 1e-3F;
  const float length = std::sqrt(Dot(gradient, gradient));
  const bool has_normal = length >= kMinLength;
  const Triple outward = (has_normal ? 1.0F / length : 0.0F) * gradient;
  const float facing = Dot(n, outward);
  const float signed_m = distance * scale_m;
  // n . (x - eta(x)), eta = x - distance * gradient
  const float plane_residual_m = has_normal ? signed_m * facing : signed_m;
  const bool is_beside = (signed_m > 0) & (std::abs(facing) < kEdgeFacing) & has_normal;
  return {std::abs(signed_m), plane_residual_m, facing, is_beside, outward};
}

// Measured points brought to the model, up to kTogether of them: every stride-th from the first-th
// on. Lanes after the last repeat it.
struct ForwardBatch {
  std::size_t size = 0;
  VectorColumns points_object, normals_object;
  PointColumn sigmas_m;
  shape::FieldSampleColumns samples;

  void Load(const shape::ShapeModel& model,
            const MeasuredView& view,
            const PlacedView& placed,
            std::size_t first,
            std::size_t stride) {
    const std::size_t last = view.points_camera.size() - 1;
    size = std::min(kTogether, (last - first) / stride + 1);
    const std::size_t whole = WholeLanes(size);
    for (std::size_t k = 0; k < whole; ++k) {
      const std::size_t i = first + std::min(k, size - 1) * stride;
      const Eigen::Vector3f& point = view.points_camera[i];
      const Eigen::Vector3f& normal = view.normals_camera[i];
      points_object.Set(k, point.x(), point.y(), point.z());
      normals_object.Set(k, normal.x(), normal.y(), normal.z());
      sigmas_m[k] = view.sigmas_m[i];
    }
#pragma GCC ivdep
    for (std::size_t k = 0; k < whole; ++k) {
      const Triple x = placed.object_from_camera * TripleAt(points_object, k);
      const Triple n = placed.object_axes_from_camera * TripleAt(normals_object, k);
      points_object.Set(k, x.x, x.y, x.z);
      normals_object.Set(k, n.x, n.y, n.z);
    }
    model.At(points_object, whole, samples);
  }
  [[nodiscard]] SurfaceMatch Match(std::size_t k, float scale_m) const {
    return MatchSurface(
        samples.distance[k], TripleAt(samples.gradient, k), TripleAt(normals_object, k), scale_m);
  }
};

// `use` is called with a ForwardBatch of all points in turn.
template <typename Use>
void ForEachForward(const shape::ShapeModel& model,
                    const MeasuredView& view,
                    const PlacedView& placed,
                    int point_stride,
                    const Use& use) {
  const auto stride = static_cast<std::size_t>(std::max(1, point_stride));
  ForwardBatch batch;
  for (std::size_t i = 0; i < view.points_camera.size(); i += kTogether * stride) {
    batch.Load(model, view, placed, i, stride);
    use(batch);
  }
}

// A visible model point against the measurement in the pixel it falls into.
struct BackMatch {
  enum Kind { kUnknown, kAgrees, kSurface, kFree, kConflict } kind = kUnknown;
  float residual_m = 0;           // kSurface: along the normal; kFree: sideways
  Triple normal_camera = {};      // kSurface
  float right_m = 0, down_m = 0;  // kFree: from the silhouette to the model point
};

// Whether a pixel or one beside it measured the given depth: at an edge of the object, rounding
// decides which it is.
bool AgreesAround(const MeasuredView& view, int u, int v, float depth_m) {
  const int left = std::max(0, u - 1), right = std::min(view.depth_m.width() - 1, u + 1);
  const int low = std::min(view.depth_m.height() - 1, v + 1);
  for (int y = std::max(0, v - 1); y <= low; ++y) {
    const float* const row = view.depth_m.row(y);
    for (int x = left; x <= right; ++x) {
      if (std::abs(row[x] - depth_m) < kNeutralGap) return true;
    }
  }
  return false;
}

// Of a model point in the camera's frame that falls into pixel (u, v) of the view.
BackMatch MatchBack(const MeasuredView& view, const Triple& q, int u, int v, float radius_m) {
  BackMatch match;
  const float depth = view.depth_m(u, v);
  if (depth <= 0) return match;
  const float gap = depth - q.z;
  if (view.mask(u, v) != 0) {
    const Eigen::Vector3f& n = view.normals(u, v);
    match.normal_camera = {n.x(), n.y(), n.z()};
    match.kind = BackMatch::kConflict;
    if (n.x() == 0 && n.y() == 0 && n.z() == 0)
      return std::abs(gap) < radius_m ? BackMatch() : match;
    // To the point measured along the same ray.
    match.residual_m = -gap / q.z * Dot(match.normal_camera, q);
    if (std::abs(gap) < 2 * radius_m && std::abs(match.residual_m) < radius_m)
      match.kind = BackMatch::kSurface;
    return match;
  }
  if (AgreesAround(view, u, v, q.z)) {
    match.kind = BackMatch::kAgrees;
    return match;
  }
  const PixelIndex nearest = view.nearest_object_pixel(u, v);
  if (gap < 0 || nearest.u < 0) return match;
  match.kind = BackMatch::kFree;
  match.right_m = static_cast<float>(u - nearest.u) * q.z / static_cast<float>(view.camera.fx);
  match.down_m = static_cast<float>(v - nearest.v) * q.z / static_cast<float>(view.camera.fy);
  match.residual_m = std::sqrt(match.right_m * match.right_m + match.down_m * match.down_m);
  return match;
}

// Points of the model as a camera sees them, up to kTogether of them, with the pixels they fall
// into; u < 0 outside the image and behind the camera.
struct BackBatch {
  std::size_t size = 0;
  VectorColumns points_camera;
  std::array<std::int32_t, kPointBatch> u, v;

  void Load(const std::vector<SurfacePoint>& seen,
            const MeasuredView& view,
            const PlacedView& placed,
            std::size_t first,
            std::size_t stride) {
    // Keeps the division finite; what is behind is left out below.
    constexpr float kMinDepth_m = 1e-6F;
    size = std::min(kTogether, (seen.size() - 1 - first) / stride + 1);
    const std::size_t whole = WholeLanes(size);
    for (std::size_t k = 0; k < whole; ++k) {
      const Eigen::Vector3f& point = seen[first + std::min(k, size - 1) * stride].point;
      points_camera.Set(k, point.x(), point.y(), point.z());
    }
    const auto fx = static_cast<float>(view.camera.fx), fy = static_cast<float>(view.camera.fy);
    const auto cx = static_cast<float>(view.camera.cx), cy = static_cast<float>(view.camera.cy);
    const auto width = static_cast<float>(view.depth_m.width());
    const auto height = static_cast<float>(view.depth_m.height());
#pragma GCC ivdep
    for (std::size_t k = 0; k < whole; ++k) {
      const Triple q = placed.camera_from_object * TripleAt(points_camera, k);
      points_camera.Set(k, q.x, q.y, q.z);
      const float per_z = 1.0F / (q.z > kMinDepth_m ? q.z : kMinDepth_m);
      // Half a pixel on, so that what is cut off rounds to the nearest.
      const float right = fx * q.x * per_z + cx + 0.5F;
      const float down = fy * q.y * per_z + cy + 0.5F;
      const bool is_inside =
          (q.z > kMinDepth_m) & (right > 0) & (down > 0) & (right < width) & (down < height);
      u[k] = static_cast<std::int32_t>(is_inside ? right : -1.0F);
      v[k] = static_cast<std::int32_t>(is_inside ? down : -1.0F);
    }
  }
};

// `use` is called with all visible points of the model that fall into the image, each with its
// place in the camera's frame and its BackMatch.
template <typename Use>
void ForEachBack(const MeasuredView& view,
                 const PlacedView& placed,
                 const std::vector<SurfacePoint>& seen,
                 float radius_m,
                 int point_stride,
                 const Use& use) {
  const auto stride = static_cast<std::size_t>(std::max(1, point_stride));
  BackBatch batch;
  for (std::size_t i = 0; i < seen.size(); i += kTogether * stride) {
    batch.Load(seen, view, placed, i, stride);
    for (std::size_t k = 0; k < batch.size; ++k) {
      if (batch.u[k] < 0) continue;
      const Triple q = TripleAt(batch.points_camera, k);
      use(seen[i + k * stride], q, MatchBack(view, q, batch.u[k], batch.v[k], radius_m));
    }
  }
}

// Residuals side by side; those without weight are left out.
struct ResidualBatch {
  std::size_t size = 0;
  VectorColumns direction_object, x_object_m;
  PointColumn residual_m, weight;

  void Add(const Triple& direction, const Triple& x_m, float residual, float by_weight) {
    direction_object.Set(size, direction.x, direction.y, direction.z);
    x_object_m.Set(size, x_m.x, x_m.y, x_m.z);
    residual_m[size] = residual;
    weight[size] = by_weight;
    size += by_weight > 0 ? 1 : 0;
  }
};

// Hands residuals on to `Use` batch by batch.
template <typename Use>
class ResidualCollector {
 public:
  explicit ResidualCollector(const Use& use) : use_(use) {}
  void Add(const Triple& direction, const Triple& x_m, float residual, float weight) {
    batch_.Add(direction, x_m, residual, weight);
    if (batch_.size == kPointBatch) Finish();
  }
  void Finish() {
    use_(batch_);
    batch_.size = 0;
  }

 private:
  ResidualBatch batch_;
  const Use& use_;
};

template <typename Collector>
void AddForward(const shape::ShapeModel& model,
                const MeasuredView& view,
                const PlacedView& placed,
                const MatchOptions& options,
                Collector& residuals) {
  const auto share = static_cast<float>(std::min(1.0, view.patch_share * options.point_stride));
  const float scale_m = placed.scale_m;
  const float variance = ModelVariance(scale_m);
  const auto per_radius = static_cast<float>(1 / options.radius_m);
  const auto per_edge_radius =
      static_cast<float>(1 / std::max(options.radius_m, options.edge_radius_m));
  const float edge_share = options.both_directions ? 1.0F : 0.0F;
  VectorColumns directions;
  PointColumn residuals_m, weights;
  ForEachForward(model, view, placed, options.point_stride, [&](const ForwardBatch& batch) {
    const std::size_t whole = WholeLanes(batch.size);
#pragma GCC ivdep
    for (std::size_t k = 0; k < whole; ++k) {
      const SurfaceMatch match = batch.Match(k, scale_m);
      const float information = share / (batch.sigmas_m[k] * batch.sigmas_m[k] + variance);
      // A flat surface that goes on past the model's edge: Eq. (1) is zero there wherever the edge
      // lies, and a table top would slide in its own plane. Mixed by 0 and 1: no branches in lanes.
      const float edge = match.is_beside ? edge_share : 0.0F;
      const float plane = 1.0F - edge;
      const float tukey =
          TukeyWeight(match.distance_m, edge * per_edge_radius + plane * per_radius);
      const float facing = match.facing >= kMinFacing ? match.facing : 0.0F;
      const Triple n = TripleAt(batch.normals_object, k);
      directions.Set(k,
                     -(edge * match.outward.x + plane * n.x),
                     -(edge * match.outward.y + plane * n.y),
                     -(edge * match.outward.z + plane * n.z));
      residuals_m[k] = edge * match.distance_m + plane * match.plane_residual_m;
      weights[k] = information * tukey * (edge * kSilhouetteWeight + plane * facing);
    }
    for (std::size_t k = 0; k < batch.size; ++k) {
      residuals.Add(TripleAt(directions, k),
                    scale_m * TripleAt(batch.points_object, k),
                    residuals_m[k],
                    weights[k]);
    }
  });
}

template <typename Collector>
void AddBackward(VisibleSurface& visible,
                 const MeasuredView& view,
                 const PlacedView& placed,
                 const MatchOptions& options,
                 Collector& residuals) {
  const float scale_m = placed.scale_m;
  const double cell_m = VisibleSurface::kCellVoxels * kVoxelSize * static_cast<double>(scale_m);
  // Each point speaks for those that are left out.
  const auto share =
      static_cast<float>(options.point_stride * std::min(1.0, std::pow(cell_m / view.patch_m, 2)));
  const float variance = ModelVariance(scale_m);
  const auto radius_m = static_cast<float>(options.radius_m);
  const float per_radius = 1 / radius_m;
  const LinearMap& axes = placed.object_axes_from_camera;
  const Triple right = {axes.x_row.x, axes.y_row.x, axes.z_row.x};
  const Triple down = {axes.x_row.y, axes.y_row.y, axes.z_row.y};
  const std::vector<SurfacePoint>& seen = visible.From(placed.camera_object);
  const auto add = [&](const SurfacePoint& surface, const Triple& q, const BackMatch& match) {
    if (match.kind != BackMatch::kSurface && match.kind != BackMatch::kFree) return;
    const Triple q_m = {
        scale_m * surface.point.x(), scale_m * surface.point.y(), scale_m * surface.point.z()};
    const float sigma = DepthSigmaM(q.z);
    const float weight =
        share * TukeyWeight(match.residual_m, per_radius) / (sigma * sigma + variance);
    if (match.kind == BackMatch::kSurface) {
      const Triple normal = axes * match.normal_camera;
      const float facing =
          Dot(normal, {surface.normal.x(), surface.normal.y(), surface.normal.z()});
      if (facing >= kMinFacing) residuals.Add(normal, q_m, match.residual_m, weight * facing);
    } else {
      residuals.Add(right, q_m, match.right_m, kSilhouetteWeight * weight);
      residuals.Add(down, q_m, match.down_m, kSilhouetteWeight * weight);
    }
  };
  ForEachBack(view, placed, seen, radius_m, options.point_stride, add);
}

// `use` is called with all residuals, batch by batch.
template <typename Use>
void ForEachResiduals(const shape::ShapeModel& model,
                      VisibleSurface& visible,
                      const MeasuredView& view,
                      const Similarity3& world_from_object,
                      const MatchOptions& options,
                      const Use& use) {
  const PlacedView placed(view, world_from_object);
  ResidualCollector<Use> residuals(use);
  AddForward(model, view, placed, options, residuals);
  if (options.both_directions) AddBackward(visible, view, placed, options, residuals);
  residuals.Finish();
}

// Adds the batch's residuals, whose last lanes it fills up.
void AddBatch(ResidualBatch& batch, SevenEquations& equations) {
  const std::size_t whole = WholeLanes(batch.size);
  for (std::size_t k = batch.size; k < whole; ++k) {
    batch.direction_object.Set(k, 0, 0, 0);
    batch.x_object_m.Set(k, 0, 0, 0);
    batch.residual_m[k] = batch.weight[k] = 0;
  }
  SevenEquations::Columns columns;
#pragma GCC ivdep
  for (std::size_t k = 0; k < whole; ++k) {
    const Triple n = TripleAt(batch.direction_object, k);
    const Triple x = TripleAt(batch.x_object_m, k);
    columns[0][k] = n.x;
    columns[1][k] = n.y;
    columns[2][k] = n.z;
    columns[3][k] = x.y * n.z - x.z * n.y;
    columns[4][k] = x.z * n.x - x.x * n.z;
    columns[5][k] = x.x * n.y - x.y * n.x;
    columns[6][k] = Dot(n, x);
    columns[7][k] = batch.residual_m[k];
  }
  equations.Add(columns, batch.weight, whole);
}

}  // namespace

DEEPSLAM_WIDE_VECTORS std::vector<MotionResidual> ResidualsOf(const shape::ShapeModel& model,
                                                              VisibleSurface& visible,
                                                              const MeasuredView& view,
                                                              const Similarity3& world_from_object,
                                                              const MatchOptions& options) {
  std::vector<MotionResidual> list;
  ForEachResiduals(
      model, visible, view, world_from_object, options, [&](const ResidualBatch& batch) {
        for (std::size_t k = 0; k < batch.size; ++k) {
          const Triple n = TripleAt(batch.direction_object, k);
          const Triple x = TripleAt(batch.x_object_m, k);
          list.push_back({{n.x, n.y, n.z}, {x.x, x.y, x.z}, batch.residual_m[k], batch.weight[k]});
        }
      });
  return list;
}

DEEPSLAM_WIDE_VECTORS int AddResidualsOf(const shape::ShapeModel& model,
                                         VisibleSurface& visible,
                                         const MeasuredView& view,
                                         const Similarity3& world_from_object,
                                         const MatchOptions& options,
                                         SevenEquations& equations) {
  int count = 0;
  ForEachResiduals(model, visible, view, world_from_object, options, [&](ResidualBatch& batch) {
    count += static_cast<int>(batch.size);
    AddBatch(batch, equations);
  });
  return count;
}

DEEPSLAM_WIDE_VECTORS ViewMisfit MisfitOf(const shape::ShapeModel& model,
                                          VisibleSurface& visible,
                                          const MeasuredView& view,
                                          const Similarity3& world_from_object,
                                          double radius_m,
                                          int point_stride) {
  ViewMisfit misfit;
  const PlacedView placed(view, world_from_object);
  const auto per_radius = static_cast<float>(1 / radius_m);
  PointColumn squares;
  ForEachForward(model, view, placed, point_stride, [&](const ForwardBatch& batch) {
    const std::size_t whole = WholeLanes(batch.size);
#pragma GCC ivdep
    for (std::size_t k = 0; k < whole; ++k) {
      const SurfaceMatch match = batch.Match(k, placed.scale_m);
      squares[k] = match.facing < 0 ? 1.0F : Truncated(match.distance_m, per_radius);
    }
    for (std::size_t k = 0; k < batch.size; ++k)
      misfit.forward.sum += static_cast<double>(squares[k]);
    misfit.forward.count += static_cast<int>(batch.size);
  });
  const auto add = [&](const SurfacePoint&, const Triple&, const BackMatch& match) {
    if (match.kind == BackMatch::kUnknown) return;
    const bool conflict = match.kind == BackMatch::kConflict;
    misfit.backward.sum +=
        conflict ? 1.0 : static_cast<double>(Truncated(match.residual_m, per_radius));
    ++misfit.backward.count;
  };
  ForEachBack(view,
              placed,
              visible.From(placed.camera_object),
              static_cast<float>(radius_m),
              point_stride,
              add);
  return misfit;
}

PointMatch MatchPoint(const shape::ShapeModel& model,
                      const Eigen::Vector3d& point_object,
                      const Eigen::Vector3d& normal_object,
                      double scale_m) {
  const auto [distance, gradient] = model.At(point_object.cast<float>());
  const Eigen::Vector3f normal = normal_object.cast<float>();
  const SurfaceMatch match = MatchSurface(distance,
                                          {gradient.x(), gradient.y(), gradient.z()},
                                          {normal.x(), normal.y(), normal.z()},
                                          static_cast<float>(scale_m));
  return {match.distance_m, match.plane_residual_m, match.facing};
}

}  // namespace deepslam::registration
