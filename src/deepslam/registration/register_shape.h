// Where a candidate's model stands: one similarity per (candidate, view), one scale per candidate.
//
// The paper's "camera-to-model pose estimation" (moments and Procrustes over 8 azimuths against
// orthographic partial views, then similarity ICP, Eq. (1)), made robust by using all views of the
// object at once: hypotheses of the best views are carried into the world by the tracked cameras,
// scored against all views, refined jointly (one scale), and every view is then registered anew
// from the joint pose with the scale fixed, so that each is a measurement z_io.
//
// What keeps Eq. (1) from its trivial optimum: see similarity_icp.h.
#pragma once

#include <span>
#include <vector>

#include "deepslam/registration/measured_view.h"
#include "deepslam/scene/layout.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/registration.h"
#include "deepslam/scene/shape_candidate.h"
#include "deepslam/shape/shape_model.h"

namespace deepslam::registration {

struct RegisterOptions {
  // Object points per view: one per 2 cm square of a chair seen from one side.
  static constexpr int kMaxPoints = 400;
  // Longer side of the reduced crops that show free space: a pixel is two thirds of a voxel.
  static constexpr int kMaxCrop_px = 96;
  // Views with fewer points are no measurement: a tenth of what is drawn.
  static constexpr int kMinPoints = 40;
  // Azimuths of the model's partial views, as many as the paper has.
  static constexpr int kNumAzimuths = 8;
  // Views whose own alignments become hypotheses in the world: more of them repeat what these say.
  static constexpr int kNumSeedViews = 4;
  // Hypotheses that get a joint refinement, the costly step.
  static constexpr int kNumRefinedHypotheses = 6;
  // Residuals beyond it have no weight at the start: how far the moments place a model wrongly.
  static constexpr double kCoarseRadius_m = 0.15;
  // And at the end: model, voxels and depth noise differ by no more.
  static constexpr double kFineRadius_m = 0.05;
  // One standard deviation of how upright one view shows objects: a Kinect's depth tilts the floor
  // itself by 0.8 deg from view to view.
  static constexpr double kUprightSigma_deg = 1;
  // One standard deviation of how well the model's bottom meets the ground: about half a voxel of
  // furniture.
  static constexpr double kGroundSigma_m = 0.01;
  // One standard deviation of a candidate's own size, relative: catalogues hold what is sold, not
  // what stands there.
  static constexpr double kSizeSigma = 0.25;
  // A view that leaves the joint pose by more is no measurement: it fits another face of the
  // object. As far as kCoarseRadius_m reaches; no option.
  double max_move_m = 0.15;
  // Nor is one that turns more than this: half the step between azimuths.
  static constexpr double kMaxTurn_deg = 20;
  // Nor one with a smaller share of its points within kFineRadius_m.
  static constexpr double kMinInlierShare = 0.3;
  // Residuals within one patch of the surface count as one measurement: model and object differ by
  // whole parts.
  static constexpr double kPatch_m = 0.05;
  // Yaw less sure than this is reported as free: it could not tell neighbouring azimuths apart.
  static constexpr double kYawFreeSigma_deg = 15;
  // A model that covers itself this far at every angle is round; voxels keep a round one from 1.
  static constexpr double kSymmetryShare = 0.93;
};

// The views as RegisterCandidate wants them; once per object.
[[nodiscard]] std::vector<MeasuredView> PrepareForRegistration(std::span<const ObjectView> views);

// Registers one candidate in all views, from where its source measured it if it says so, else by
// search. Never fails: what could not be registered says so (ok = false, reason). Views stay in the
// order given; the result holds one entry per view. All numbers are finite. `layout` is the room
// along the path of the views, for what has a front; none where it is not known.
[[nodiscard]] CandidateRegistration RegisterCandidate(const ShapeCandidate& candidate,
                                                      const shape::ShapeModel& model,
                                                      std::span<const ObjectView> views,
                                                      const RegisterOptions& options,
                                                      const Layout* layout = nullptr);

// The same with views prepared once for all candidates of an object (PrepareForRegistration).
[[nodiscard]] CandidateRegistration RegisterCandidate(const ShapeCandidate& candidate,
                                                      const shape::ShapeModel& model,
                                                      std::span<const MeasuredView> views,
                                                      const RegisterOptions& options,
                                                      const Layout* layout = nullptr);

// The same, once its place is nearly known: similarity refined jointly over all views
// (refine_pose.h), and every view registered from there.
[[nodiscard]] CandidateRegistration RegisterCandidateNear(const ShapeCandidate& candidate,
                                                          const shape::ShapeModel& model,
                                                          const Similarity3& world_from_object,
                                                          std::span<const MeasuredView> views,
                                                          const RegisterOptions& options);

}  // namespace deepslam::registration
