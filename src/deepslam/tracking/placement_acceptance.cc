#include "deepslam/tracking/placement_acceptance.h"

#include <optional>

#include "deepslam/alignment/free_space.h"
#include "deepslam/alignment/patch_zncc.h"

namespace deepslam::tracking {
namespace {

using alignment::DepthNoise;
using alignment::FrameAlignment;
using alignment::FreeSpaceViolation;
using alignment::PlacedPyramid;

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

MotionLikelihood LikelihoodOfMotion(const PathSoFar& path,
                                    const PosedFrame& last,
                                    const PosedFrame& frame,
                                    const Pose3& world_from_camera) {
  ExpectedMotion expected;
  expected.world_from_last = last.world_from_camera;
  expected.duration_s = frame.clock_s - last.clock_s;
  if (last.frame == path.previous.frame) expected.world_from_predicted = PredictedPose(path, frame);
  expected.sigma = path.motion.SigmaOfStart(expected.duration_s);
  return LikelihoodOf(world_from_camera, expected);
}

}  // namespace

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
  const auto violates = [&](double most) {
    const PlacedPyramid seen_before = reference.Placed();
    return FreeSpaceViolation({&placed, 1}, {&seen_before, 1}, noise) > most ||
           FreeSpaceViolation(
               path.keyframes.PlacedOf(reference.sub_trajectory), {&placed, 1}, noise) > most;
  };
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
  return IsConfident(found) && looks_like_it(kMinZnccFar) && !violates(kMaxViolationFar);
}

}  // namespace deepslam::tracking
