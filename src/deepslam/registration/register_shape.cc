#include "deepslam/registration/register_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "deepslam/core/angles.h"
#include "deepslam/registration/information.h"
#include "deepslam/registration/refine_pose.h"
#include "deepslam/registration/similarity_icp.h"
#include "deepslam/registration/world_hypotheses.h"
#include "deepslam/scene/sides_at_walls.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::registration {
namespace {

// Up taken from how cameras are held, without a ground: anything from level to looking well down.
constexpr double kGuessedUprightSigma = 25 * kRadPerDeg;
// Furniture of a source that names no size.
constexpr double kMinFurniture_m = 0.1;
constexpr double kMaxFurniture_m = 5.0;  // m; no single piece of furniture is longer
// How far the joint pose holds a single view: the drift between views that tracking leaves.
constexpr double kHoldSigma = 0.05;
constexpr double kHoldSigmaRad = 5 * kRadPerDeg;  // and of its turn
// A placement in the air must disagree this much less than one on the ground.
constexpr double kAirborneRatio = 0.7;
// Of the largest view; the coarse fit only ranks hypotheses.
constexpr std::size_t kPointsPerCoarseView = 150;
// A single view starts where all views together have come to.
constexpr int kViewIterations = 8;

using ViewPointers = std::vector<const MeasuredView*>;

bool IsSize(double size_m) { return std::isfinite(size_m) && size_m > 0; }

PlacementPrior PriorOf(const ShapeCandidate& candidate, const Layout* layout = nullptr) {
  double min_size = IsSize(candidate.min_size_m) ? candidate.min_size_m : kMinFurniture_m;
  double max_size = IsSize(candidate.max_size_m) ? candidate.max_size_m : kMaxFurniture_m;
  if (min_size > max_size) std::swap(min_size, max_size);
  PlacementPrior prior{min_size / kModelExtent, max_size / kModelExtent};
  prior.layout = layout;
  if (IsSize(candidate.size_m)) {
    prior.expected_m = std::clamp(candidate.size_m / kModelExtent, prior.min_m, prior.max_m);
  }
  return prior;
}

ViewPointers UsableViews(std::span<const MeasuredView> views, int min_points) {
  ViewPointers usable;
  for (const MeasuredView& view : views) {
    if (static_cast<int>(view.points_camera.size()) >= std::max(3, min_points)) {
      usable.push_back(&view);
    }
  }
  return usable;
}

// Where no view alone has enough points, all that have any are used together.
ViewPointers ViewsForJointPose(std::span<const MeasuredView> views) {
  ViewPointers usable = UsableViews(views, RegisterOptions::kMinPoints);
  return usable.empty() ? UsableViews(views, 3) : usable;
}

SimilarityIcpOptions JointOptions(const PlacementPrior& prior, bool ground_known) {
  SimilarityIcpOptions icp;
  icp.start_radius_m = RegisterOptions::kCoarseRadius_m;
  icp.end_radius_m = RegisterOptions::kFineRadius_m;
  icp.min_scale_m = prior.min_m;
  icp.max_scale_m = prior.max_m;
  icp.expected_scale_m = prior.expected_m;
  icp.size_sigma = RegisterOptions::kSizeSigma;
  icp.upright_sigma_rad =
      ground_known ? RegisterOptions::kUprightSigma_deg * kRadPerDeg : kGuessedUprightSigma;
  icp.ground_sigma_m = prior.stands ? RegisterOptions::kGroundSigma_m : 0.0;
  return icp;
}

// Of a candidate whose place is nearly known: only whole furniture is held to the ground.
SimilarityIcpOptions OptionsNear(const ShapeCandidate& candidate, const ViewPointers& views) {
  PlacementPrior prior = PriorOf(candidate);
  prior.stands = !TraitsOf(candidate.source).is_partial;
  return JointOptions(prior, views.front()->ground_world.has_value());
}

// The same surface explained from its other side: half a turn about the vertical through what was
// measured. Moments do not find it where only a chair's back rises above a table.
Similarity3 TurnedRound(const Similarity3& world_from_object, const ViewPointers& views) {
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
  for (const MeasuredView* view : views) pivot += view->world_from_camera * view->centroid_camera;
  pivot /= static_cast<double>(views.size());
  const Eigen::Vector3d up = world_from_object.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond half_turn(Eigen::AngleAxisd(std::numbers::pi, up));
  Similarity3 turned = world_from_object;
  turned.rotation = (half_turn * world_from_object.rotation).normalized();
  turned.translation_m = pivot + half_turn * (world_from_object.translation_m - pivot);
  return turned;
}

// Where it stands, by quarter turns about its box's middle: depth hardly tells the sides of a
// nightstand apart, and moments find but one of them.
std::array<Similarity3, 3> QuarterTurned(const shape::ShapeModel& model,
                                         const Similarity3& world_from_object) {
  const Eigen::Vector3d middle = model.box().center().cast<double>();
  std::array<Similarity3, 3> all;
  for (std::size_t n = 0; n < all.size(); ++n) {
    const double turn_rad = 0.5 * std::numbers::pi * static_cast<double>(n + 1);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
    all[n] = world_from_object * Similarity3{1, turn, middle - turn * middle};
  }
  return all;
}

// The best world hypothesis, or the same turned round, or away from a wall, refined over all views
// with its scale.
Similarity3 JointPose(const shape::ShapeModel& model,
                      VisibleSurface& visible,
                      const ViewPointers& views,
                      const std::vector<WorldHypothesis>& hypotheses,
                      const Layout* layout,
                      const SimilarityIcpOptions& options) {
  SimilarityIcpOptions coarse = options;
  coarse.ground_firm = RegisterOptions::kGroundSigma_m > 0;
  coarse.edge_radius_m = options.start_radius_m;
  std::size_t most_points = 0;
  for (const MeasuredView* view : views) {
    most_points = std::max(most_points, view->points_camera.size());
  }
  coarse.point_stride = static_cast<int>(most_points / kPointsPerCoarseView) + 1;
  Similarity3 best = hypotheses.front().world_from_object;
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](const Similarity3& world_from_object) {
    const Similarity3 refined = AlignShape(model, visible, views, world_from_object, coarse);
    const double disagreement =
        Disagreement(model, visible, views, refined, options.end_radius_m, coarse.point_stride) +
        FacingCost(model, refined, views, layout);
    if (disagreement >= least) return;
    least = disagreement;
    best = refined;
  };
  for (const WorldHypothesis& hypothesis : hypotheses) attempt(hypothesis.world_from_object);
  attempt(TurnedRound(best, views));
  if (layout != nullptr && WallConflict(*layout, best, model.box()) > 0) {
    for (const Similarity3& turned : QuarterTurned(model, best)) {
      if (WallConflict(*layout, turned, model.box()) == 0) attempt(turned);
    }
  }
  SimilarityIcpOptions fine = options;
  fine.start_radius_m = 0.5 * (options.start_radius_m + options.end_radius_m);
  return AlignShape(model, visible, views, best, fine);
}

struct JointPlacement {
  Similarity3 world_from_object;
  SimilarityIcpOptions icp;  // what it was found with
};

// Furniture stands on the ground; of a partial shape that is tried but not required.
std::optional<JointPlacement> PlaceJointly(const shape::ShapeModel& model,
                                           VisibleSurface& visible,
                                           const ViewPointers& views,
                                           PlacementPrior prior,
                                           bool is_partial) {
  std::optional<JointPlacement> best;
  double least = 0;
  for (const bool stands : {true, false}) {
    prior.stands = stands;
    if (!stands && !is_partial) break;
    const std::vector<WorldHypothesis> hypotheses = FindHypotheses(model, visible, views, prior);
    if (hypotheses.empty()) return std::nullopt;
    const SimilarityIcpOptions icp = JointOptions(prior, views.front()->ground_world.has_value());
    const Similarity3 joint = JointPose(model, visible, views, hypotheses, prior.layout, icp);
    const double disagreement =
        Disagreement(model, visible, views, joint, RegisterOptions::kFineRadius_m, 2);
    if (best && disagreement > kAirborneRatio * least) continue;
    best = JointPlacement{joint, icp};
    least = disagreement;
  }
  return best;
}

// Where the source measured the shape: nothing has to be searched for, and no other side of the
// measurement can be taken for this one.
std::optional<JointPlacement> PlaceAsMeasured(const ShapeCandidate& candidate,
                                              const shape::ShapeModel& model,
                                              VisibleSurface& visible,
                                              const ViewPointers& views) {
  if (!candidate.world_from_object || !IsSize(candidate.world_from_object->scale))
    return std::nullopt;
  const SimilarityIcpOptions icp = OptionsNear(candidate, views);
  SimilarityIcpOptions fine = icp;
  fine.start_radius_m = 0.5 * (icp.start_radius_m + icp.end_radius_m);
  return JointPlacement{AlignShape(model, visible, views, *candidate.world_from_object, fine), icp};
}

std::string WhyNotRegistered(const ViewFit& fit,
                             double moved_m,
                             double turned_rad,
                             const RegisterOptions& options) {
  if (fit.inlier_share < RegisterOptions::kMinInlierShare) {
    return "only " + std::to_string(static_cast<int>(100 * fit.inlier_share)) +
           " % of the points lie on the model";
  }
  if (moved_m > options.max_move_m) {
    return "moved " + std::to_string(static_cast<int>(100 * moved_m)) +
           " cm away from the other views' pose";
  }
  if (turned_rad > RegisterOptions::kMaxTurn_deg * kRadPerDeg) {
    return "turned " + std::to_string(static_cast<int>(turned_rad / kRadPerDeg)) +
           " deg away from the other views' pose";
  }
  return {};
}

// The view's own measurement z_io, the scale fixed, from the joint pose.
ViewRegistration RegisterView(const shape::ShapeModel& model,
                              VisibleSurface& visible,
                              const MeasuredView& view,
                              const Similarity3& world_from_object,
                              SimilarityIcpOptions icp,
                              bool is_round,
                              const RegisterOptions& options) {
  ViewRegistration result;
  result.view = view.view;
  result.frame = view.frame;
  const Pose3 joint = view.world_from_camera.Inverse() * world_from_object.RigidPart();
  result.camera_from_object = joint;
  if (static_cast<int>(view.points_camera.size()) < RegisterOptions::kMinPoints) {
    result.reason = "only " + std::to_string(view.points_camera.size()) + " points";
    return result;
  }
  icp.free_scale = false;
  icp.num_iterations = kViewIterations;
  icp.start_radius_m = 2 * RegisterOptions::kFineRadius_m;
  icp.hold_sigma_m = kHoldSigma;
  icp.hold_sigma_rad = kHoldSigmaRad;
  const MeasuredView* const only = &view;
  const Similarity3 refined = AlignShape(model, visible, {&only, 1}, world_from_object, icp);
  const Pose3 camera_from_object = view.world_from_camera.Inverse() * refined.RigidPart();
  const ViewFit fit = FitOfView(model,
                                view,
                                camera_from_object,
                                world_from_object.scale,
                                RegisterOptions::kFineRadius_m,
                                is_round);
  const Pose3 moved = joint.Inverse() * camera_from_object;
  result.reason =
      WhyNotRegistered(fit, moved.translation_m.norm(), RotationAngle(moved.rotation), options);
  result.ok = result.reason.empty();
  result.rmse_m = fit.rmse_m;
  result.inlier_share = fit.inlier_share;
  if (!result.ok) return result;
  result.camera_from_object = camera_from_object;
  result.information = fit.information;
  result.yaw_free = fit.yaw_sigma_rad > RegisterOptions::kYawFreeSigma_deg * kRadPerDeg;
  return result;
}

// Entries for every view, none registered.
CandidateRegistration NotRegistered(const ShapeCandidate& candidate,
                                    std::span<const MeasuredView> views,
                                    std::string reason) {
  CandidateRegistration result;
  result.candidate = candidate.id;
  for (const MeasuredView& view : views) {
    ViewRegistration& entry = result.views.emplace_back();
    entry.view = view.view;
    entry.frame = view.frame;
    entry.reason = reason;
  }
  result.reason = std::move(reason);
  return result;
}

// Every view registered from the joint pose.
CandidateRegistration RegisteredAt(const ShapeCandidate& candidate,
                                   const shape::ShapeModel& model,
                                   VisibleSurface& visible,
                                   std::span<const MeasuredView> views,
                                   const Similarity3& joint,
                                   const SimilarityIcpOptions& icp,
                                   const RegisterOptions& options) {
  const bool is_round = IsRound(model, RegisterOptions::kSymmetryShare);
  CandidateRegistration result;
  result.candidate = candidate.id;
  result.scale_m = joint.scale;
  result.world_from_object = joint.RigidPart();
  for (const MeasuredView& view : views) {
    result.views.push_back(RegisterView(model, visible, view, joint, icp, is_round, options));
    result.ok = result.ok || result.views.back().ok;
  }
  if (!result.ok) result.reason = "no view agrees with the model";
  return result;
}

}  // namespace

std::vector<MeasuredView> PrepareForRegistration(std::span<const ObjectView> views) {
  return PrepareViews(
      views, RegisterOptions::kMaxPoints, RegisterOptions::kMaxCrop_px, RegisterOptions::kPatch_m);
}

CandidateRegistration RegisterCandidate(const ShapeCandidate& candidate,
                                        const shape::ShapeModel& model,
                                        std::span<const ObjectView> views,
                                        const RegisterOptions& options,
                                        const Layout* layout) {
  return RegisterCandidate(candidate, model, PrepareForRegistration(views), options, layout);
}

CandidateRegistration RegisterCandidate(const ShapeCandidate& candidate,
                                        const shape::ShapeModel& model,
                                        std::span<const MeasuredView> views,
                                        const RegisterOptions& options,
                                        const Layout* layout) {
  if (model.empty()) return NotRegistered(candidate, views, "the model is empty");
  const ViewPointers usable = ViewsForJointPose(views);
  if (usable.empty()) return NotRegistered(candidate, views, "no view has enough points");
  VisibleSurface visible(model);
  const auto registered_at = [&](const JointPlacement& place) {
    return RegisteredAt(
        candidate, model, visible, views, place.world_from_object, place.icp, options);
  };
  if (const auto measured = PlaceAsMeasured(candidate, model, visible, usable)) {
    CandidateRegistration result = registered_at(*measured);
    if (result.ok) return result;
  }
  const bool is_partial = TraitsOf(candidate.source).is_partial;
  const std::optional<JointPlacement> found =
      PlaceJointly(model, visible, usable, PriorOf(candidate, layout), is_partial);
  if (!found) return NotRegistered(candidate, views, "the views' points have no extent");
  return registered_at(*found);
}

CandidateRegistration RegisterCandidateNear(const ShapeCandidate& candidate,
                                            const shape::ShapeModel& model,
                                            const Similarity3& world_from_object,
                                            std::span<const MeasuredView> views,
                                            const RegisterOptions& options) {
  if (model.empty()) return NotRegistered(candidate, views, "the model is empty");
  const ViewPointers usable = ViewsForJointPose(views);
  if (usable.empty()) return NotRegistered(candidate, views, "no view has enough points");
  VisibleSurface visible(model);
  const SimilarityIcpOptions icp = OptionsNear(candidate, usable);
  const Similarity3 joint = RefinePose(model, visible, usable, world_from_object, icp);
  return RegisteredAt(candidate, model, visible, views, joint, icp, options);
}

}  // namespace deepslam::registration
