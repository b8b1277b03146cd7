#include "deepslam/tracking/placement_acceptance.h"

#include <algorithm>
#include <optional>

#include "deepslam/alignment/patch_zncc.h"
#include "deepslam/tracking/free_space.h"

namespace deepslam::tracking {
namespace {

using alignment::FrameAlignment;

// Share of free space that may be violated by a frame which a hand may have brought there: noise
// that is underrated makes as much. Placed right, captures without motion leave less than half of
// it.
constexpr double kMaxViolation = 0.02;
// Frames that are placed right reach this: real captures 0.7 and more. At wrong places it is seldom
// above 0.6, also where the same chair stands.
constexpr double kMinZncc = 0.65;
// Where no hand would have carried the camera, wrong places are as many as there are keyframes:
// the same furniture on a like floor reaches 0.68.
constexpr double kMinZnccFar = 0.72;

// `times`: as many times as fast as a hand usually is.
MotionLikelihood LikelihoodOfMotion(const PathSoFar& path,
                                    const PosedFrame& last,
                                    const PosedFrame& frame,
                                    const Pose3& world_from_camera,
                                    double times = 1) {
  ExpectedMotion expected;
  expected.world_from_last = last.world_from_camera;
  expected.duration_s = times * (frame.clock_s - last.clock_s);
  if (last.frame == path.previous.frame) expected.world_from_predicted = PredictedPose(path, frame);
  expected.sigma = path.motion.SigmaOfStart(expected.duration_s);
  return LikelihoodOf(world_from_camera, expected);
}

// So many points over the image that agree, each measured for itself, are no chance: by chance a
// dozen do, and on a thing that stands twice as many as it has.
constexpr int kManyPoints = 40;
// What alignment and points, each right, differ by where depth is poor.
constexpr double kSamePlaceM = 0.03;
constexpr double kSamePlaceRad = 0.035;  // 2 deg: at a metre what kSamePlaceM is
// Of what is asked of an alignment by itself.
constexpr double kOverlapBesideFeatures = 0.25;
// Share of free space that smeared depth violates. Who walks by so near that most points are theirs
// violates several times as much.
constexpr double kMaxViolationOfSmear = 0.2;
// A phone that is whirled round.
constexpr double kFastHand = 2;

// Of the free space of the reference, and of its sub-trajectory's keyframes, and the other way.
double Violation(const PathSoFar& path, const PosedFrame& reference, const PlacedPyramid& placed) {
  const DepthNoise& noise = path.options.alignment.pyramid.noise;
  const PlacedPyramid seen_before = reference.Placed();
  return std::max(
      FreeSpaceViolation({&placed, 1}, {&seen_before, 1}, noise),
      FreeSpaceViolation(path.keyframes.PlacedOf(reference.sub_trajectory), {&placed, 1}, noise));
}

}  // namespace

bool IsBorneOutByFeatures(const PathSoFar& path,
                          const PosedFrame& reference,
                          const PosedFrame& last,
                          const PosedFrame& frame,
                          const FrameAlignment& found,
                          const FeatureStart& start) {
  const alignment::AlignmentOptions& options = path.options.alignment;
  const Pose3 off = start.reference_from_frame.Inverse() * found.i_from_j;
  if (start.num_inliers < kManyPoints || off.translation_m.norm() > kSamePlaceM ||
      RotationAngle(off.rotation) > kSamePlaceRad)
    return false;
  if (found.overlap_ratio < kOverlapBesideFeatures * options.min_overlap ||
      found.inlier_ratio < options.min_inlier_ratio ||
      found.intensity_correlation < options.min_intensity_correlation)
    return false;
  const PlacedPyramid placed{frame.pyramid, reference.world_from_camera * found.i_from_j};
  if (last.sub_trajectory != reference.sub_trajectory ||
      Violation(path, reference, placed) > kMaxViolationOfSmear)
    return false;
  const MotionLikelihood motion =
      LikelihoodOfMotion(path, last, frame, placed.world_from_camera, kFastHand);
  return motion != MotionLikelihood::kUnlikely &&
         alignment::PatchZncc(
             *reference.pyramid, *frame.pyramid, found.i_from_j, options.pyramid.noise) >= kMinZncc;
}

bool IsAcceptable(const PathSoFar& path,
                  const PosedFrame& reference,
                  const PosedFrame& last,
                  const PosedFrame& frame,
                  const FrameAlignment& found) {
  if (path.options.reference == "previous") return true;  // the paper's plain behaviour
  const DepthNoise& noise = path.options.alignment.pyramid.noise;
  const PlacedPyramid placed{frame.pyramid, reference.world_from_camera * found.i_from_j};
  const auto looks_like_it = [&](double least) {
    return alignment::PatchZncc(*reference.pyramid, *frame.pyramid, found.i_from_j, noise) >= least;
  };
  const auto violates = [&](double most) { return Violation(path, reference, placed) > most; };
  const bool is_continued = last.sub_trajectory == reference.sub_trajectory;
  switch (is_continued ? LikelihoodOfMotion(path, last, frame, placed.world_from_camera)
                       : MotionLikelihood::kUnlikely) {
    case MotionLikelihood::kAsPredicted:
      return IsConfident(found) || looks_like_it(kMinZncc) || !violates(kMaxViolation);
    case MotionLikelihood::kOfAHand:
      return looks_like_it(kMinZncc) && !violates(kMaxViolation);
    case MotionLikelihood::kUnlikely:
      break;
  }
  return IsConfident(found) && looks_like_it(kMinZnccFar) && !violates(MaxViolationFar(found));
}

}  // namespace deepslam::tracking
