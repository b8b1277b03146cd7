// Where a candidate's model stands: one similarity per (candidate, view), one scale per candidate.
//
// The paper's "camera-to-model pose estimation" (moments and Procrustes over 8 azimuths against
// orthographic partial views, then similarity ICP, Eq. (1)), made robust by using all views of the
// object at once: hypotheses of the best views are carried into the world by the tracked cameras,
// judged against all views, refined jointly (one scale), and every view is then registered anew
// from the joint pose with the scale fixed, so that each is a measurement z_io.
//
// What keeps Eq. (1) from its trivial optimum: see similarity_icp.h.
#pragma once

#include <span>
#include <vector>

#include "deepslam/core/options.h"
#include "deepslam/registration/measured_view.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::registration {

struct RegisterOptions {
  int max_points = 400;            // object points per view
  int max_crop_px = 96;            // longer side of the reduced crops
  int min_points = 40;             // fewer: the view says nothing
  int num_azimuths = 8;            // the paper's quantisation of the rotation about the vertical
  int num_seed_views = 4;          // views whose own alignments become world hypotheses
  int num_refined_hypotheses = 6;  // hypotheses that get a joint refinement
  double coarse_radius_m = 0.15;   // a residual beyond it says nothing, at the start
  double fine_radius_m = 0.05;     // and at the end
  double upright_sigma_deg = 2;    // how upright furniture stands
  double ground_sigma_m = 0.01;    // how well the model's bottom meets the ground
  double size_sigma = 0.25;        // relative; how well a candidate's own size is believed
  double max_move_m = 0.15;        // a view that leaves the joint pose by more is no measurement
  double max_turn_deg = 20;
  double min_inlier_share = 0.3;  // of a view's points, within fine_radius_m
  double patch_m = 0.05;  // residuals within one patch of the surface count as one measurement
  double yaw_free_sigma_deg = 15;  // yaw less sure than this is reported as free
  double symmetry_share = 0.93;    // a model that covers itself this far at every angle is round
};
void Describe(OptionsVisitor& visitor, RegisterOptions& options);

// The views as RegisterCandidate wants them; once per object.
[[nodiscard]] std::vector<MeasuredView> PrepareForRegistration(std::span<const ObjectView> views,
                                                               const RegisterOptions& options);

// Registers one candidate in all views. Never fails: what could not be registered says so (ok =
// false, reason). Views stay in the order given; the result holds one entry per view. All numbers
// are finite.
[[nodiscard]] CandidateRegistration RegisterCandidate(const ShapeCandidate& candidate,
                                                      const shape::ShapeModel& model,
                                                      std::span<const ObjectView> views,
                                                      const RegisterOptions& options);

// The same with views prepared once for all candidates of an object (PrepareForRegistration).
[[nodiscard]] CandidateRegistration RegisterCandidate(const ShapeCandidate& candidate,
                                                      const shape::ShapeModel& model,
                                                      std::span<const MeasuredView> views,
                                                      const RegisterOptions& options);

// The same, once its place is nearly known: similarity refined jointly over all views
// (refine_pose.h), and every view registered from there.
[[nodiscard]] CandidateRegistration RegisterCandidateNear(const ShapeCandidate& candidate,
                                                          const shape::ShapeModel& model,
                                                          const Similarity3& world_from_object,
                                                          std::span<const MeasuredView> views,
                                                          const RegisterOptions& options);

}  // namespace deepslam::registration
