#include "deepslam/registration/world_hypotheses.h"

#include <algorithm>
#include <cmath>

#include "deepslam/core/every_nth.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/geometry/facing.h"
#include "deepslam/registration/initial_alignment.h"
#include "deepslam/registration/similarity_icp.h"
#include "deepslam/scene/sides_at_walls.h"

namespace deepslam::registration {
namespace {

// Ranking needs no more than this of the measurement.
constexpr std::size_t kMaxScoringViews = 8;
constexpr std::size_t kPointsPerScoringView = 60;  // of each of these views
// Hypotheses closer than all of these lead to the same optimum.
constexpr double kSameAngleRad = 0.3;
constexpr double kSamePlaceShare = 0.15;  // of the scale
constexpr double kSameScaleShare = 0.15;  // between logs of the scales
// Cost of a back turned to all cameras, as furniture faces people; disagreements lie in [0, 2].
constexpr double kBackShown = 0.1;
// Cost of a front turned to a wall: more than all cameras say, which pass on all sides.
constexpr double kFrontBlocked = 0.15;

using ViewPointers = std::vector<const MeasuredView*>;

// Height of the object's top above the ground: all but the highest 2 % of the points lie below it.
// 0 without a ground.
double TopHeight(std::span<const MeasuredView* const> views) {
  std::vector<double> heights;
  for (const MeasuredView* view : views) {
    if (!view->ground_world) return 0;
    for (const Eigen::Vector3f& point : view->points_camera) {
      heights.push_back(
          view->ground_world->SignedDistance(view->world_from_camera * point.cast<double>()));
    }
  }
  if (heights.empty()) return 0;
  const auto top = static_cast<std::size_t>(0.98 * static_cast<double>(heights.size() - 1));
  return std::max(0.0, OrderStatistic(heights, top));
}

// Views with many points come first; those cut by the image border count half, since their moments
// mislead.
ViewPointers BestViews(std::span<const MeasuredView* const> views, int count) {
  ViewPointers best(views.begin(), views.end());
  const auto worth = [](const MeasuredView* view) {
    const double patches = view->patch_share * static_cast<double>(view->points_camera.size());
    return view->touches_border ? 0.5 * patches : patches;
  };
  std::stable_sort(
      best.begin(), best.end(), [&](const auto* a, const auto* b) { return worth(a) > worth(b); });
  best.resize(std::min(best.size(), static_cast<std::size_t>(std::max(1, count))));
  return best;
}

void StandOnGround(const shape::ShapeModel& model,
                   const MeasuredView& view,
                   Similarity3& world_from_object) {
  if (!view.ground_world) return;
  const double gap_m =
      view.ground_world->SignedDistance(world_from_object * Eigen::Vector3d(0, 0, model.bottom()));
  world_from_object.translation_m -= gap_m * view.ground_world->normal;
}

bool IsSame(const Similarity3& a, const Similarity3& b) {
  return RotationAngle(a.rotation.conjugate() * b.rotation) < kSameAngleRad &&
         (a.translation_m - b.translation_m).norm() < kSamePlaceShare * a.scale &&
         std::abs(std::log(a.scale / b.scale)) < kSameScaleShare;
}

// At another scale the point of the model that lay on the measured centroid stays there.
Similarity3 Rescaled(const Similarity3& camera_from_object,
                     const Eigen::Vector3d& centroid_camera,
                     double scale_m) {
  const double factor = scale_m / camera_from_object.scale;
  Similarity3 rescaled = camera_from_object;
  rescaled.scale = scale_m;
  rescaled.translation_m =
      centroid_camera + factor * (camera_from_object.translation_m - centroid_camera);
  return rescaled;
}

}  // namespace

double FacingCost(const shape::ShapeModel& model,
                  const Similarity3& world_from_object,
                  std::span<const MeasuredView* const> views,
                  const Layout* layout) {
  std::vector<Eigen::Vector3d> cameras_world;
  for (const MeasuredView* view : views)
    cameras_world.push_back(view->world_from_camera.translation_m);
  const double back_shown =
      BackShown(world_from_object.rotation, world_from_object.translation_m, cameras_world);
  const double blocked =
      layout != nullptr ? WallConflict(*layout, world_from_object, model.box()) : 0;
  return kBackShown * back_shown + kFrontBlocked * blocked;
}

std::vector<WorldHypothesis> FindHypotheses(const shape::ShapeModel& model,
                                            VisibleSurface& visible,
                                            std::span<const MeasuredView* const> views,
                                            const PlacementPrior& prior) {
  const ViewPointers scoring_views = EvenlySpaced(views, kMaxScoringViews);
  std::vector<double> scales_m;
  if (prior.expected_m > 0) scales_m.push_back(prior.expected_m);
  const double top_m = TopHeight(views);
  if (prior.stands && top_m > 0)
    scales_m.push_back(std::clamp(top_m / model.extent().z(), prior.min_m, prior.max_m));
  std::vector<WorldHypothesis> all;
  const auto add_scored = [&](const MeasuredView& view, const Similarity3& camera_from_object) {
    WorldHypothesis hypothesis{view.world_from_camera * camera_from_object, 0.0};
    if (prior.stands) StandOnGround(model, view, hypothesis.world_from_object);
    const int stride = static_cast<int>(view.points_camera.size() / kPointsPerScoringView) + 1;
    hypothesis.disagreement =
        Disagreement(model,
                     visible,
                     scoring_views,
                     hypothesis.world_from_object,
                     RegisterOptions::kCoarseRadius_m,
                     stride) +
        FacingCost(model, hypothesis.world_from_object, scoring_views, prior.layout);
    all.push_back(hypothesis);
  };
  for (const MeasuredView* view : BestViews(views, RegisterOptions::kNumSeedViews)) {
    for (const Similarity3& camera_from_object :
         AlignByMoments(visible, *view, RegisterOptions::kNumAzimuths, prior.min_m, prior.max_m)) {
      add_scored(*view, camera_from_object);
      for (const double scale_m : scales_m)
        add_scored(*view, Rescaled(camera_from_object, view->centroid_camera, scale_m));
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.disagreement < b.disagreement;
  });
  std::vector<WorldHypothesis> kept;
  for (const WorldHypothesis& hypothesis : all) {
    if (static_cast<int>(kept.size()) >= std::max(1, RegisterOptions::kNumRefinedHypotheses)) break;
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const WorldHypothesis& other) {
      return IsSame(hypothesis.world_from_object, other.world_from_object);
    });
    if (is_new) kept.push_back(hypothesis);
  }
  return kept;
}

}  // namespace deepslam::registration
