// How a hand-held camera moves: what is expected of it next, and how likely a motion is.
#pragma once

#include <optional>

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::tracking {

// Constant velocity, of the last two frames that were placed one after the other.
class MotionModel {
 public:
  // Without `predicts` frames are expected where the camera was (SigmaOfStart).
  explicit MotionModel(bool predicts) : predicts_(predicts) {}

  // Between the last two frames. `unobserved`: a direction of it was predicted itself, since
  // nothing showed it.
  void Observe(const Pose3& before_from_after, double interval_s, bool unobserved);
  // The motion across a loss predicts nothing.
  void Forget() { interval_s_ = 0; }

  // The motion carried on for a while. Nothing where none is known, or for longer than it can be
  // carried on.
  [[nodiscard]] std::optional<Pose3> Predict(double duration_s) const;

  // How well a frame's start is known after `duration_s` of prediction from frame to frame, or of
  // none. A motion that was not observed is as old as when it last was.
  [[nodiscard]] alignment::StartSigma SigmaOfStart(double duration_s) const;

 private:
  bool predicts_;
  Pose3 before_from_after_;
  double interval_s_ = 0;    // 0: no motion is known
  double unobserved_s_ = 0;  // for how long a direction of the motion was predicted
};

enum class MotionLikelihood {
  kAsPredicted,  // where the camera was expected
  kOfAHand,      // where a hand may have carried it since
  kUnlikely,
};

// A camera that was at `world_from_last`, and may have been expected elsewhere since.
struct ExpectedMotion {
  Pose3 world_from_last;
  std::optional<Pose3> world_from_predicted;  // none: nothing is known of its motion
  alignment::StartSigma sigma;                // of the prediction (MotionModel::SigmaOfStart)
  double duration_s = 0;
};

[[nodiscard]] MotionLikelihood LikelihoodOf(const Pose3& world_from_camera,
                                            const ExpectedMotion& expected);

}  // namespace deepslam::tracking
