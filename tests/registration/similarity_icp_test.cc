#include "deepslam/registration/similarity_icp.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "deepslam/core/angles.h"
#include "deepslam/registration/information.h"
#include "deepslam/registration/initial_alignment.h"
#include "support/furniture_world.h"
#include "support/pose_matchers.h"

namespace deepslam::registration {
namespace {

using testing_support::FurnitureWorld;
using testing_support::PoseNear;

// Error of the scale after alignment that starts at the true place with a wrong scale, the model's
// bottom staying put.
double ScaleErrorFrom(double start_factor, bool both_directions) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const std::vector<MeasuredView> views = PrepareViews(world.Views({0.2, 0.7, 1.2}));
  std::vector<const MeasuredView*> pointers;
  for (const MeasuredView& view : views) pointers.push_back(&view);
  Similarity3 start = world.world_from_object();
  start.scale *= start_factor;
  start.translation_m.z() *= start_factor;
  VisibleSurface visible(world.model());
  SimilarityIcpOptions options;
  options.both_directions = both_directions;
  options.start_radius_m = 0.3;
  options.num_iterations = 30;
  const Similarity3 aligned = AlignShape(world.model(), visible, pointers, start, options);
  return std::abs(aligned.scale / world.world_from_object().scale - 1.0);
}

TEST(AlignShape, ReturnsToTheTrueScaleFromFarSmallerAndLarger) {
  EXPECT_LE(ScaleErrorFrom(0.7, true), 0.05);
  EXPECT_LE(ScaleErrorFrom(1.4, true), 0.05);
}

// Eq. (1) alone rewards a wrong scale; this is what the way back is for.
TEST(AlignShape, LosesTheScaleWithEquationOneAlone) {
  EXPECT_GT(std::max(ScaleErrorFrom(0.7, false), ScaleErrorFrom(1.4, false)), 0.05);
}

// Only a table's top is measured, and not its far end: no depth contradicts a model that has slid
// out there, but the measured top goes on past the model's other edge.
TEST(AlignShape, ATableTopDoesNotSlideInItsOwnPlane) {
  const double yaw_rad = 0.7;
  const FurnitureWorld world(testing_support::TableGrid(), 1.6, yaw_rad);
  const Similarity3 truth = world.world_from_object();
  std::vector<ObjectView> seen = world.Views({yaw_rad - 0.2, yaw_rad, yaw_rad + 0.2});
  for (ObjectView& view : seen) {
    for (int v = 0; v < view.mask_crop.height(); ++v) {
      for (int u = 0; u < view.mask_crop.width(); ++u) {
        const double depth_m = view.depth_crop_m(u, v);
        const Eigen::Vector3d p_object =
            truth.Inverse() * (view.world_from_camera * view.camera.Unproject(u, v, depth_m));
        if (p_object.z() < 0.18) view.mask_crop(u, v) = 0;
        if (p_object.y() < 0.25) continue;
        view.mask_crop(u, v) = 0;
        view.depth_crop_m(u, v) = 0;
      }
    }
  }
  const std::vector<MeasuredView> views = PrepareViews(seen);
  std::vector<const MeasuredView*> pointers;
  for (const MeasuredView& view : views) pointers.push_back(&view);
  const Eigen::Vector3d along = truth.rotation * Eigen::Vector3d::UnitY();
  Similarity3 slid = truth;
  slid.translation_m += 0.12 * along;
  VisibleSurface visible(world.model());
  SimilarityIcpOptions options;
  options.free_scale = false;
  options.edge_radius_m = 0.15;
  const Similarity3 aligned = AlignShape(world.model(), visible, pointers, slid, options);
  EXPECT_NEAR(along.dot(aligned.translation_m - truth.translation_m), 0.0, 0.03);
}

TEST(AlignShape, StaysWhereNothingCanBeMatched) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const std::vector<MeasuredView> views = PrepareViews(world.Views({0.2}));
  const MeasuredView* const view = &views[0];
  Similarity3 far = world.world_from_object();
  far.translation_m.x() += 50;
  VisibleSurface visible(world.model());
  SimilarityIcpOptions options;
  options.both_directions = false;
  EXPECT_EQ(AlignShape(world.model(), visible, {&view, 1}, far, options), far);
  EXPECT_EQ(AlignShape(world.model(), visible, {}, far, options), far);
}

// How far a chair turns towards an up that is 6 deg off, seen so many times by one view.
double TiltFound(int num_views, bool ground_known) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  std::vector<MeasuredView> views = PrepareViews(world.Views({0.2}));
  MeasuredView& view = views[0];
  view.up_camera = Eigen::AngleAxisd(6 * kRadPerDeg, Eigen::Vector3d::UnitX()) * view.up_camera;
  if (!ground_known) view.ground_world.reset();
  const std::vector<const MeasuredView*> pointers(static_cast<std::size_t>(num_views), &view);
  VisibleSurface visible(world.model());
  const Similarity3 truth = world.world_from_object();
  SimilarityIcpOptions options;
  options.free_scale = false;
  options.upright_sigma_rad = 0.004;
  const Similarity3 aligned = AlignShape(world.model(), visible, pointers, truth, options);
  return aligned.rotation.angularDistance(truth.rotation);
}

TEST(AlignShape, MoreViewsOfOneFaultDoNotOutweighTheGround) {
  const double once_rad = TiltFound(1, true);
  EXPECT_GT(once_rad, 0.03);
  EXPECT_NEAR(TiltFound(16, true), once_rad, 0.1 * once_rad);
  EXPECT_LT(TiltFound(16, false), 0.5 * TiltFound(1, false)) << "a guess counts once";
}

TEST(Disagreement, IsLeastAtTheTruth) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  const std::vector<MeasuredView> views = PrepareViews(world.Views({0.2, 1.0, 2.0}));
  std::vector<const MeasuredView*> pointers;
  for (const MeasuredView& view : views) pointers.push_back(&view);
  VisibleSurface visible(world.model());
  const auto disagreement = [&](const Similarity3& placed) {
    return Disagreement(world.model(), visible, pointers, placed, 0.1, 1);
  };
  const Similarity3 truth = world.world_from_object();
  const double least = disagreement(truth);
  for (const double factor : {0.8, 1.25}) {
    Similarity3 scaled = truth;
    scaled.scale *= factor;
    EXPECT_GT(disagreement(scaled), 2 * least) << "scale times " << factor;
  }
  Similarity3 shifted = truth;
  shifted.translation_m.x() += 0.1;
  EXPECT_GT(disagreement(shifted), 2 * least);
  Similarity3 turned = truth;
  turned.rotation = Eigen::AngleAxisd(1.57, Eigen::Vector3d::UnitZ()) * turned.rotation;
  EXPECT_GT(disagreement(turned), 2 * least);
}

TEST(AlignByMoments, OfItsAlignmentsTheOneThatFitsBestIsNearTheTruth) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  for (const double azimuth : {0.0, 0.9, 2.1, 4.0}) {
    const std::vector<MeasuredView> views = PrepareViews(world.Views({azimuth}));
    const MeasuredView* const view = &views[0];
    VisibleSurface visible(world.model());
    const std::vector<Similarity3> alignments = AlignByMoments(visible, *view, 8, 0.5, 2.0);
    ASSERT_EQ(alignments.size(), 16u);
    Similarity3 best;
    double least = std::numeric_limits<double>::infinity();
    for (const Similarity3& camera_from_object : alignments) {
      const Similarity3 placed = view->world_from_camera * camera_from_object;
      const double disagreement = Disagreement(world.model(), visible, {&view, 1}, placed, 0.15, 1);
      if (disagreement >= least) continue;
      least = disagreement;
      best = camera_from_object;
    }
    const Pose3 truth =
        world.WorldFromCamera(azimuth, {}).Inverse() * world.world_from_object().RigidPart();
    // Half a step of 45 degrees, and the lift of the moments by what the partial view lacks.
    EXPECT_THAT(best.RigidPart(), PoseNear(truth, 0.25, 23));
  }
}

// Points on the top of a closed block, seen from above at a slant.
MeasuredView PlateView(const Pose3& camera_from_object, double top_m) {
  MeasuredView view;
  for (int i = -10; i <= 10; ++i) {
    for (int j = -10; j <= 10; ++j) {
      const Eigen::Vector3d point(0.03 * i, 0.03 * j, top_m);
      view.points_camera.push_back((camera_from_object * point).cast<float>());
      view.normals_camera.push_back(
          (camera_from_object.rotation * Eigen::Vector3d::UnitZ()).cast<float>());
      view.sigmas_m.push_back(0.002f);
    }
  }
  view.patch_share = 1.0;
  return view;
}

TEST(FitOfView, InformationIsStrongAcrossThePlateAndWeakAlongIt) {
  VoxelGrid grid;
  testing_support::FillBox(grid, {-0.48, -0.48, -0.2}, {0.48, 0.48, 0.2});
  const shape::ShapeModel model(grid);
  const Pose3 camera_from_object{
      Eigen::Quaterniond(Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, 0.3, 0.2).normalized())),
      {0.1, 0.2, 2.0}};
  const double top_m = model.box_max().z();
  const MeasuredView view = PlateView(camera_from_object, top_m);
  const ViewFit fit = FitOfView(model, view, camera_from_object, 1.0, 0.05, false);
  EXPECT_EQ(fit.num_inliers, 441);
  // t2v(measured^-1 * true) is in the object's frame: z across the plate.
  EXPECT_GT(fit.information(2, 2), 1e6);
  EXPECT_LT(fit.information(0, 0), 100);
  EXPECT_LT(fit.information(1, 1), 100);
  EXPECT_GT(fit.information(3, 3), 1e4);
  EXPECT_GT(fit.information(4, 4), 1e4);
  EXPECT_LT(fit.information(5, 5), 100);
  EXPECT_GT(fit.yaw_sigma_rad, 1.0);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(fit.information);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
}

// chi^2 of a small true motion must be what the residuals really become, in t2v's order and frame.
TEST(FitOfView, InformationPredictsTheResidualsOfASmallMotion) {
  const FurnitureWorld world(testing_support::ChairGrid(), 0.9);
  testing_support::ViewSettings exact;
  exact.noise_factor = 0;
  const MeasuredView view = PrepareViews(world.Views({0.6}, exact))[0];
  const double scale_m = world.world_from_object().scale;
  const Pose3 measured = view.world_from_camera.Inverse() * world.world_from_object().RigidPart();
  const ViewFit fit = FitOfView(world.model(), view, measured, scale_m, 0.05, false);
  const auto residual_squares = [&](const Pose3& camera_from_object) {
    // Fixed correspondences: every point's plane through the place the model point moves to.
    double sum = 0;
    const Pose3 camera_from_moved = camera_from_object * measured.Inverse();
    for (std::size_t i = 0; i < view.points_camera.size(); ++i) {
      const Eigen::Vector3d point = view.points_camera[i].cast<double>();
      const double residual =
          view.normals_camera[i].cast<double>().dot(camera_from_moved * point - point);
      sum += residual * residual;
    }
    return sum;
  };
  // All six directions relate residuals to information by one and the same factor, but for weights
  // and floor.
  std::vector<double> factors;
  for (int i = 0; i < 6; ++i) {
    Vector6d motion = Vector6d::Zero();
    motion[i] = 1e-3;
    const double chi2 = motion.dot(fit.information * motion);
    factors.push_back(chi2 / residual_squares(measured * V2t(motion)));
  }
  for (const double factor : factors) EXPECT_NEAR(factor / factors[0], 1.0, 0.3);
}

}  // namespace
}  // namespace deepslam::registration
