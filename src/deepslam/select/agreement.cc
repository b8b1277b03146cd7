#include "deepslam/select/agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "deepslam/core/parallel.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/geometry/depth_noise.h"
#include "deepslam/geometry/point_columns.h"
#include "deepslam/shape/render_voxels.h"
#include "deepslam/shape/view_points.h"

namespace deepslam::select {
namespace {

// Larger surfaces are thinned to between half of this and this: right to about 2 %.
constexpr std::size_t kSeenSamples = 1000;

bool IsUsable(const ObjectView& view) {
  const DepthImage& depth = view.depth_crop_m;
  const PinholeCamera& camera = view.camera;
  return !depth.empty() && view.mask_crop.width() == depth.width() &&
         view.mask_crop.height() == depth.height() && std::isfinite(camera.fx) &&
         std::isfinite(camera.fy) && camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.cx) &&
         std::isfinite(camera.cy) && view.world_from_camera.translation_m.allFinite() &&
         view.world_from_camera.rotation.coeffs().allFinite();
}

// Every factor-th pixel; depth is not averaged, so that edges stay.
void AddReducedCrop(const ObjectView& view, int factor, ScoredView& out) {
  const int width = std::max(1, view.depth_crop_m.width() / factor);
  const int height = std::max(1, view.depth_crop_m.height() / factor);
  out.camera = view.camera.Reduced(factor);
  out.camera.width = width;
  out.camera.height = height;
  out.depth_m = DepthImage(width, height);
  out.mask = Mask(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int x = std::min(u * factor + factor / 2, view.depth_crop_m.width() - 1);
      const int y = std::min(v * factor + factor / 2, view.depth_crop_m.height() - 1);
      const float depth = view.depth_crop_m(x, y);
      if (!std::isfinite(depth) || depth <= 0) continue;
      out.depth_m(u, v) = depth;
      out.mask(u, v) = view.mask_crop(x, y) != 0 ? 1 : 0;
    }
  }
}

// The placed model, asked how well measured points lie on its surface.
class PlacedModel {
 public:
  PlacedModel(const shape::ShapeModel& model,
              const Similarity3& camera_from_object,
              const SelectOptions& options)
      : model_(model),
        object_from_camera_(camera_from_object.Inverse()),
        scale_m_(camera_from_object.scale),
        options_(options) {}

  [[nodiscard]] const SelectOptions& options() const { return options_; }
  [[nodiscard]] const shape::ShapeModel& model() const { return model_; }
  [[nodiscard]] double scale_m() const { return scale_m_; }

  [[nodiscard]] Eigen::Vector3f ToObject(const Eigen::Vector3d& point_camera) const {
    return (object_from_camera_ * point_camera).cast<float>();
  }

 private:
  const shape::ShapeModel& model_;
  SimilarityMatrix object_from_camera_;
  double scale_m_;
  const SelectOptions& options_;
};

// Measured points side by side, up to kPointBatch.
struct PointAgreements {
  std::size_t size = 0;
  VectorColumns points_object;
  std::array<double, kPointBatch> depths_m;
  std::array<double, kPointBatch> distances_m, agreements;  // made by Measure

  void Add(const PlacedModel& placed, const Eigen::Vector3d& point_camera) {
    const Eigen::Vector3f p = placed.ToObject(point_camera);
    points_object.Set(size, p.x(), p.y(), p.z());
    depths_m[size] = point_camera.z();
    ++size;
  }

  void Measure(const PlacedModel& placed) {
    for (std::size_t n = size; n < WholeLanes(size); ++n)
      points_object.Set(n, points_object.x[0], points_object.y[0], points_object.z[0]);
    shape::FieldSampleColumns samples;
    placed.model().At(points_object, WholeLanes(size), samples);
    const double scale_m = placed.scale_m();
    const double model_tolerance_m = SelectOptions::kModelTolerance_m;
    const double fade_m = SelectOptions::kFade_m;
    for (std::size_t n = 0; n < size; ++n) {
      distances_m[n] = scale_m * static_cast<double>(std::abs(samples.distance[n]));
      const double tolerance_m =
          model_tolerance_m + 2 * DepthSigmaM(depths_m[n]) + 0.5 * kVoxelSize * scale_m;
      agreements[n] = std::clamp(1.0 - (distances_m[n] - tolerance_m) / fade_m, 0.0, 1.0);
    }
  }
};

struct SurfaceAgreement {
  double sum = 0;
  int num_reached = 0;
};

SurfaceAgreement SurfaceOf(const PlacedModel& placed,
                           std::span<const Eigen::Vector3f> points_camera) {
  SurfaceAgreement surface;
  PointAgreements points;
  for (std::size_t first = 0; first < points_camera.size(); first += kPointBatch) {
    points.size = 0;
    for (const Eigen::Vector3f& point :
         points_camera.subspan(first, std::min(kPointBatch, points_camera.size() - first)))
      points.Add(placed, point.cast<double>());
    points.Measure(placed);
    for (std::size_t n = 0; n < points.size; ++n) {
      surface.sum += points.agreements[n];
      surface.num_reached += points.distances_m[n] <= SelectOptions::kReach_m ? 1 : 0;
    }
  }
  return surface;
}

// How well what each pixel of a view measured lies on the model, where a pixel of the rendered
// model is beside it; 0 elsewhere and where nothing was measured.
class PixelAgreement {
 public:
  PixelAgreement(const DepthImage& rendered_m, const PlacedModel& placed, const ScoredView& view)
      : agreement_(view.depth_m.width(), view.depth_m.height(), 0.0) {
    for (int v = 0; v < agreement_.height(); ++v) {
      for (int u = 0; u < agreement_.width(); ++u) {
        if (!(view.depth_m(u, v) > 0) || !IsBeside(rendered_m, u, v)) continue;
        points_.Add(placed, view.camera.Unproject(u, v, view.depth_m(u, v)));
        at_[points_.size - 1] = &agreement_(u, v);
        if (points_.size == kPointBatch) Finish(placed);
      }
    }
    if (points_.size > 0) Finish(placed);
  }

  // Best agreement in a pixel and around it: thin parts may be a pixel beside their place.
  [[nodiscard]] double Around(int u, int v) const {
    double best = 0;
    for (int y = std::max(0, v - 1); y <= std::min(agreement_.height() - 1, v + 1); ++y) {
      for (int x = std::max(0, u - 1); x <= std::min(agreement_.width() - 1, u + 1); ++x)
        best = std::max(best, agreement_(x, y));
    }
    return best;
  }

 private:
  static bool IsBeside(const DepthImage& rendered_m, int u, int v) {
    const int last = std::min(rendered_m.width() - 1, u + 1);
    for (int y = std::max(0, v - 1); y <= std::min(rendered_m.height() - 1, v + 1); ++y) {
      for (int x = std::max(0, u - 1); x <= last; ++x) {
        if (rendered_m(x, y) > 0) return true;
      }
    }
    return false;
  }
  void Finish(const PlacedModel& placed) {
    points_.Measure(placed);
    for (std::size_t n = 0; n < points_.size; ++n) *at_[n] = points_.agreements[n];
    points_.size = 0;
  }

  Image<double> agreement_;
  PointAgreements points_;
  std::array<double*, kPointBatch> at_;
};

void AddCoverage(const DepthImage& rendered_m,
                 const PlacedModel& placed,
                 const ScoredView& view,
                 ViewAgreement& agreement) {
  const PixelAgreement agreement_of(rendered_m, placed, view);
  double confirmed = 0;
  double violated = 0;
  for (int v = 0; v < rendered_m.height(); ++v) {
    for (int u = 0; u < rendered_m.width(); ++u) {
      if (rendered_m(u, v) <= 0) continue;
      const double share = agreement_of.Around(u, v);
      const float depth = view.depth_m(u, v);
      const bool is_behind = depth > rendered_m(u, v);
      const bool is_known = depth > 0 && (is_behind || view.mask(u, v) != 0);
      if (share < 0.5 && !is_known) continue;
      ++agreement.num_seen;
      confirmed += share;
      if (is_behind) violated += 1.0 - share;
    }
  }
  if (agreement.num_seen == 0) return;
  agreement.coverage = confirmed / agreement.num_seen;
  agreement.violation = violated / agreement.num_seen;
}

// Whether a view measured the surface at one of the model's surface points.
bool IsConfirmed(const shape::ShapeModel& model,
                 std::size_t surface_idx,
                 const Similarity3& camera_from_object,
                 const ScoredView& view) {
  if (view.depth_m.empty()) return false;
  const Eigen::Vector3d point =
      camera_from_object * model.surface_points()[surface_idx].cast<double>();
  const Eigen::Vector3d normal =
      camera_from_object.rotation * model.surface_normals()[surface_idx].cast<double>();
  const auto pixel = view.camera.Project(point);
  if (!pixel || normal.dot(point) > 0 || !(pixel->cwiseAbs().maxCoeff() < 1e6)) return false;
  const int u = static_cast<int>(std::lround(pixel->x()));
  const int v = static_cast<int>(std::lround(pixel->y()));
  if (!view.depth_m.Contains(u, v) || view.depth_m(u, v) <= 0) return false;
  return std::abs(view.depth_m(u, v) - point.z()) <
         SelectOptions::kModelTolerance_m + SelectOptions::kFade_m + 2 * DepthSigmaM(point.z());
}

}  // namespace

std::vector<ScoredView> PrepareForScoring(std::span<const ObjectView> views) {
  std::vector<ScoredView> prepared(views.size());
  ParallelFor(views.size(), [&](std::size_t i) {
    const ObjectView& view = views[i];
    prepared[i].view = view.detection;
    prepared[i].frame = view.frame;
    if (!IsUsable(view)) return;
    for (const Eigen::Vector3f& point :
         shape::ExtractViewPoints(view, SelectOptions::kMaxPoints).points_camera) {
      if (point.allFinite() && point.z() > 0) prepared[i].points_camera.push_back(point);
    }
    prepared[i].world_from_camera = view.world_from_camera;
    prepared[i].ground_camera = view.ground_camera;
    const int side = std::max(view.depth_crop_m.width(), view.depth_crop_m.height());
    AddReducedCrop(view,
                   (side + SelectOptions::kMaxRender_px - 1) / SelectOptions::kMaxRender_px,
                   prepared[i]);
  });
  return prepared;
}

DEEPSLAM_WIDE_VECTORS ViewAgreement MeasureAgreement(const shape::ShapeModel& model,
                                                     const Similarity3& camera_from_object,
                                                     const ScoredView& view,
                                                     const SelectOptions& options) {
  ViewAgreement agreement;
  agreement.view = view.view;
  agreement.frame = view.frame;
  const bool is_placed = camera_from_object.translation_m.allFinite() &&
                         camera_from_object.rotation.coeffs().allFinite() &&
                         std::isfinite(camera_from_object.scale) && camera_from_object.scale > 0;
  if (model.empty() || view.depth_m.empty() || !is_placed) return agreement;
  const PlacedModel placed(model, camera_from_object, options);
  agreement.num_points = static_cast<int>(view.points_camera.size());
  if (agreement.num_points > 0) {
    const SurfaceAgreement surface = SurfaceOf(placed, view.points_camera);
    agreement.surface = surface.sum / agreement.num_points;
    agreement.reached = static_cast<double>(surface.num_reached) / agreement.num_points;
  }
  AddCoverage(shape::RenderDepth(model, camera_from_object, view.camera), placed, view, agreement);
  return agreement;
}

double SeenShare(const shape::ShapeModel& model,
                 std::span<const Similarity3> camera_from_object,
                 std::span<const ScoredView> views) {
  const std::span<const Eigen::Vector3f> points = model.surface_points();
  const std::size_t stride = points.size() / kSeenSamples + 1;
  int num_seen = 0;
  int total = 0;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    ++total;
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (!IsConfirmed(model, i, camera_from_object[k], views[k])) continue;
      ++num_seen;
      break;
    }
  }
  return total > 0 ? static_cast<double>(num_seen) / total : 0.0;
}

}  // namespace deepslam::select
