// One Gauss-Newton step's linear system of frame alignment (frame_alignment.h has the residuals).
#pragma once

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/plane_match.h"
#include "deepslam/alignment/source_points.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// CorrespondenceGates, and by what a step compares intensities.
struct AlignmentGates : CorrespondenceGates {
  float photometric_scale = 10.0F;  // grey levels
  // I_i = gain * I_j + bias + falloff * I_j * (rho_i^2 - rho_j^2), rho being the tangent of the
  // angle between the ray and the optical axis: lenses darken towards the corners, and what stays
  // with the camera as it moves would hold it back.
  float gain = 1.0F;
  float bias = 0.0F;  // grey levels
  float falloff = 0.0F;
  // Hessians from the products of the two frames' normals and intensity gradients in place of the
  // squares of one: noise is independent between frames and averages away, where squares take it
  // for structure; and texture that lies beside its like, as at a wrong place, counts for nothing.
  // For measuring a solution; may be slightly indefinite. The gradient is void then.
  bool cross_frames = false;
  // Every so many batches of points are taken, bands of some rows, for those between them too.
  int batch_stride = 1;
};

struct AlignmentSystem {
  // Of a left perturbation exp(d) i_from_j in frame i, order (translation; rotation). Already
  // divided by the squared scales, so the unit is that of an information matrix of independent
  // residuals.
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  Matrix6d photometric_hessian = Matrix6d::Zero();   // the photometric part of `hessian`
  Vector6d photometric_gradient = Vector6d::Zero();  // ... and of `gradient`
  int num_source = 0;                                // points of j with a normal
  int num_inside = 0;                                // of those that fall inside the image of i
  int num_overlap = 0;  // of those that fall on valid points of i, near or far
  int num_matched = 0;  // of those within the gates
  int num_inliers = 0;  // residual within three standard deviations of the depth noise
  int num_photometric = 0;
  double sum_squared_m2 = 0;         // geometric, over inliers
  double intensity_correlation = 0;  // of the two intensities over the photometric residuals
  // What the next step should use: robust spread of the residuals found, intensity fitted to them.
  float geometric_scale = 1.0F;
  float photometric_scale = 10.0F;
  float gain = 1.0F;
  float bias = 0.0F;
  float falloff = 0.0F;
};

[[nodiscard]] AlignmentSystem BuildAlignmentSystem(const PyramidLevel& i,
                                                   const SourcePoints& j,
                                                   const Pose3& i_from_j,
                                                   const AlignmentGates& gates,
                                                   const DepthNoise& noise);

// Whether so many photometric residuals say something about how alike the images are.
[[nodiscard]] inline bool ComparesImages(int num_photometric) {
  constexpr int kMinPhotometricResiduals = 75;  // chance makes so many correlate by 0.12
  return num_photometric >= kMinPhotometricResiduals;
}

}  // namespace deepslam::alignment
