#include "deepslam/propose/place_shape.h"

#include <algorithm>
#include <numbers>

#include "deepslam/core/every_nth.h"
#include "deepslam/propose/depth_evidence.h"
#include "deepslam/scene/sides_at_walls.h"

namespace deepslam::propose {
namespace {

constexpr std::size_t kFitPoints = 250;  // for seven unknowns; time is proportional to them
constexpr int kNumYaws = 12;             // Gauss-Newton turns by up to half a step from there
constexpr double kTolerance_m = 0.03;  // of designs that are like the object, not the object itself

// Taken from the agreement of a front turned to a wall: depth hardly tells the sides of closed
// furniture apart.
constexpr double kBlockedPenalty = 0.05;

double BlockedPenalty(const Placement& placement, const MeasuredDepth& measured) {
  if (measured.layout == nullptr) return 0;
  const Pose3 level_from_box(
      Eigen::Quaterniond(Eigen::AngleAxisd(placement.yaw_rad, Eigen::Vector3d::UnitZ())),
      {placement.center_m.x(),
       placement.center_m.y(),
       placement.bottom_m + 0.5 * placement.size_m.z()});
  const Pose3 world_from_box = measured.cloud.level_from_world.Inverse() * level_from_box;
  return kBlockedPenalty * WallConflict(*measured.layout,
                                        measured.layout->level_from_tracking * world_from_box,
                                        placement.size_m);
}

PlacedShape Descend(const CoarseShape& shape,
                    const Placement& start,
                    const Eigen::Vector3d& believed_size_m,
                    const MeasuredDepth& measured,
                    const PlaceLimits& limits,
                    double to_beat) {
  FitTerms terms;
  terms.catalogue_sigma = limits.stretch_sigma;
  if (!measured.cloud.has_ground) terms.bottom_sigma_m = 0.3;
  PlacedShape placed;
  placed.placement = RefinePlacement(shape, start, believed_size_m, measured.fit_points, terms);
  placed.placement.size_m = placed.placement.size_m.cwiseMax(limits.stretch_min * believed_size_m)
                                .cwiseMin(limits.stretch_max * believed_size_m);
  const double penalty = BlockedPenalty(placed.placement, measured);
  placed.score =
      std::max(0.0, ScorePlaced(shape, placed.placement, measured, to_beat + penalty) - penalty);
  return placed;
}

}  // namespace

MeasuredDepth MeasureDepth(const ObjectObservations& object, bool has_front, int max_views) {
  MeasuredDepth measured;
  if (has_front) measured.layout = object.layout;
  measured.cloud = CloudOf(object);
  if (measured.cloud.points.empty()) return measured;
  measured.fit_points = EvenlySpaced(measured.cloud.points, kFitPoints);
  const LevelBox box = MeasureBox(measured.cloud.points);
  for (int n = 0; n < kNumYaws; ++n) {
    measured.boxes.push_back(
        MeasureBoxAt(measured.cloud.points, box.yaw_rad + 2.0 * std::numbers::pi * n / kNumYaws));
  }
  const Eigen::Vector3d center_level(box.center_m.x(), box.center_m.y(), 0.5 * box.size_m.z());
  const Eigen::Vector3d center_world = measured.cloud.level_from_world.Inverse() * center_level;
  measured.views = LevelViews(object.views,
                              ChooseViews(object.views, center_world, max_views),
                              measured.cloud.level_from_world);
  return measured;
}

PlacedShape PlaceShape(const CoarseShape& shape,
                       const Eigen::Vector3d& believed_size_m,
                       const MeasuredDepth& measured,
                       const PlaceLimits& limits) {
  PlacedShape best;
  for (const LevelBox& box : measured.boxes) {
    const Eigen::Vector3d stretched_m = box.size_m.cwiseMax(limits.stretch_min * believed_size_m)
                                            .cwiseMin(limits.stretch_max * believed_size_m);
    for (const Eigen::Vector3d& size_m : {believed_size_m, stretched_m}) {
      const PlacedShape placed = Descend(shape,
                                         {size_m, box.center_m, 0, box.yaw_rad},
                                         believed_size_m,
                                         measured,
                                         limits,
                                         best.score);
      if (placed.score > best.score) best = placed;
    }
  }
  return best;
}

double ScorePlaced(const CoarseShape& shape,
                   const Placement& placement,
                   const MeasuredDepth& measured,
                   double to_beat) {
  return ScorePlacement(
      shape, placement, measured.fit_points, measured.views, kTolerance_m, to_beat);
}

}  // namespace deepslam::propose
