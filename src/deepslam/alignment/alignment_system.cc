#include "deepslam/alignment/alignment_system.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "deepslam/alignment/batch_columns.h"
#include "deepslam/alignment/geometric_term.h"
#include "deepslam/alignment/photometric_term.h"
#include "deepslam/alignment/projected_points.h"
#include "deepslam/alignment/residual_sums.h"
#include "deepslam/core/wide_vectors.h"

namespace deepslam::alignment {
namespace {

// Some of a batch of points, by their place in it.
struct Selection {
  std::size_t size = 0;
  IndexColumn points;

  // Without a branch, which outlines would mislead.
  void Offer(std::size_t k, std::int32_t is_selected) {
    points[size] = static_cast<std::int32_t>(k);
    size += static_cast<std::size_t>(is_selected);
  }
  template <typename Kept>
  void Keep(const Kept& kept) {
    std::size_t count = 0;
    for (std::size_t n = 0; n < size; ++n) {
      const std::int32_t point = points[n];
      points[count] = point;
      count += kept(static_cast<std::size_t>(point)) ? 1 : 0;
    }
    size = count;
  }
  [[nodiscard]] std::span<const std::int32_t> span() const { return {points.data(), size}; }
};

// Selects the points that either term counts, and hands them over.
class SystemBuilder {
 public:
  SystemBuilder(const PyramidLevel& i,
                const SourcePoints& j,
                const Pose3& i_from_j,
                const AlignmentGates& gates,
                const DepthNoise& noise)
      : i_(i),
        j_(j),
        gates_(gates),
        projector_(i.camera, j, i_from_j),
        is_photometric_(j.choice().photometric && !i.gradients.empty()),
        geometric_(i, j, PlaneMatcher(projector_.rotation(), noise, gates), gates, room_),
        photometric_(i, j, projector_, gates, room_) {}

  AlignmentSystem Build() {
    const auto stride = static_cast<std::size_t>(gates_.batch_stride);
    projector_.ForBatches([&](const ProjectedPoints& projected) { Add(projected); }, stride);
    geometric_.Flush();
    photometric_.Flush();
    geometric_.Finish(system_);
    photometric_.Finish(system_);
    CountForThoseBetween();
    system_.hessian += system_.photometric_hessian;
    system_.gradient += system_.photometric_gradient;
    return system_;
  }

 private:
  void Add(const ProjectedPoints& projected) {
    Column signed_depth_m;
    for (std::size_t k = 0; k < projected.size; ++k)
      signed_depth_m[k] = i_.signed_depth_m[static_cast<std::size_t>(projected.pixel[k])];
    Select(projected, signed_depth_m);
    geometric_.Add(projected, geometric_points_.span());
    if (!is_photometric_) return;
    if (j_.choice().near) {
      photometric_points_.Keep([&](std::size_t k) {
        return signed_depth_m[k] > 0 || ShowsItself(i_, projected.pixel[k]);
      });
    }
    photometric_.Add(projected, photometric_points_.span());
  }

  void Select(const ProjectedPoints& projected, const Column& signed_depth_m) {
    const std::int32_t* const has_normal = j_.has_normal() + projected.begin;
    const std::int32_t* const has_texture = j_.has_texture() + projected.begin;
    const float max_distance_m = gates_.max_distance_m;
    IndexColumn in_geometric, in_photometric;
    std::int32_t num_source = 0, num_inside = 0, num_overlap = 0;
    for (std::size_t k = 0; k < projected.size; ++k) {
      const std::int32_t is_inside = projected.is_inside[k];
      const std::int32_t is_on_reference = signed_depth_m[k] > 0 ? is_inside : 0;
      const bool is_far = std::abs(projected.z[k] - std::abs(signed_depth_m[k])) > max_distance_m;
      const std::int32_t is_near = is_far ? 0 : is_inside;
      num_source += has_normal[k];
      num_inside += has_normal[k] & is_inside;
      num_overlap += has_normal[k] & is_on_reference;
      in_geometric[k] = is_near & has_normal[k] & is_on_reference;
      in_photometric[k] = is_near & has_texture[k];
    }
    system_.num_source += num_source;
    system_.num_inside += num_inside;
    system_.num_overlap += num_overlap;
    geometric_points_.size = photometric_points_.size = 0;
    for (std::size_t k = 0; k < projected.size; ++k) {
      geometric_points_.Offer(k, in_geometric[k]);
      photometric_points_.Offer(k, in_photometric[k]);
    }
  }

  void CountForThoseBetween() {
    for (int* const count : {&system_.num_source,
                             &system_.num_inside,
                             &system_.num_overlap,
                             &system_.num_matched,
                             &system_.num_inliers,
                             &system_.num_photometric})
      *count *= gates_.batch_stride;
    system_.sum_squared_m2 *= gates_.batch_stride;
    for (Matrix6d* const hessian : {&system_.hessian, &system_.photometric_hessian})
      *hessian *= gates_.batch_stride;
    for (Vector6d* const gradient : {&system_.gradient, &system_.photometric_gradient})
      *gradient *= gates_.batch_stride;
  }

  const PyramidLevel& i_;
  const SourcePoints& j_;
  const AlignmentGates& gates_;
  const PointProjector projector_;
  const bool is_photometric_;
  AlignmentSystem system_;
  JacobianRoom room_;
  GeometricTerm geometric_;
  PhotometricTerm photometric_;
  Selection geometric_points_, photometric_points_;  // of the points projected last
};

}  // namespace

DEEPSLAM_WIDE_VECTORS AlignmentSystem BuildAlignmentSystem(const PyramidLevel& i,
                                                           const SourcePoints& j,
                                                           const Pose3& i_from_j,
                                                           const AlignmentGates& gates,
                                                           const DepthNoise& noise) {
  return SystemBuilder(i, j, i_from_j, gates, noise).Build();
}

}  // namespace deepslam::alignment
