// The sequential part of tracking: takes prepared frames in order, keeps the anchors they are
// aligned to.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "deepslam/alignment/moved_surfaces.h"
#include "deepslam/tracking/odometry.h"

namespace deepslam::tracking {

class Tracker {
 public:
  explicit Tracker(const OdometryOptions& options) : options_(options) {}

  // Frames must come in order, none left out. Null: the frame was unreadable.
  void Add(FrameIdx frame, double time_s, std::shared_ptr<const alignment::FramePyramid> pyramid);

  // Nothing before the first.
  [[nodiscard]] std::optional<FrameIdx> newest_keyframe() const {
    if (odometry_.keyframes.empty()) return std::nullopt;
    return odometry_.keyframes.back();
  }

  // Keyframes may be empty when no frame was usable.
  [[nodiscard]] Odometry Finish() &&;

 private:
  // A frame that others can be aligned to.
  struct Anchor {
    FrameIdx frame;
    double time_s = 0;   // of the capture
    double clock_s = 0;  // goes on where the capture's was set back
    std::shared_ptr<const alignment::FramePyramid> pyramid;
    Pose3 world_from_camera;
    int piece = 0;      // connected part of the trajectory it belongs to
    bool held = false;  // since the keyframe before, a direction of its motion was predicted alone
  };

  struct Starts {
    std::vector<Pose3> world_from_camera;  // the likeliest first
    const Anchor* turned_from = nullptr;   // whose image a turn is searched for in, if need be
  };

  [[nodiscard]] double ClockS(double time_s);
  // Frames of one depth everywhere are as good as a wall only while nothing better has come.
  void ForgetOneDepth();
  void AddUnaligned(TrackingStatus status, FrameIdx frame, double time_s);
  void AddAligned(const Anchor& anchor, const alignment::FrameAlignment& alignment);
  void Align(Anchor& frame);
  bool AlignToReference(Anchor& frame);
  bool AlignToPrevious(Anchor& frame);
  bool Relocalise(Anchor& frame);
  bool AlignToPending(Anchor& frame);
  void Lose(const Anchor& frame);

  [[nodiscard]] Starts StartsOf(const Anchor& frame) const;
  // `others`: in the world.
  [[nodiscard]] alignment::FrameAlignment AlignTo(const Anchor& anchor,
                                                  const Anchor& frame,
                                                  const std::vector<Pose3>& starts_world,
                                                  const alignment::OtherStarts& others = {}) const;
  [[nodiscard]] alignment::StartSigma SigmaOfStart(double duration_s) const;
  // AlignTo, and once more from turns about the scene when the outcome is doubtful. Not ok where it
  // is not to be believed of a camera that was at `last` before.
  [[nodiscard]] alignment::FrameAlignment AlignWidely(const Anchor& anchor,
                                                      const Anchor& last,
                                                      const Anchor& frame,
                                                      Starts starts) const;
  [[nodiscard]] bool Believable(const Anchor& anchor,
                                const Anchor& last,
                                const Anchor& frame,
                                const alignment::FrameAlignment& alignment) const;
  // What keyframes of a piece saw against what `placed` saw: ContradictedShare.
  [[nodiscard]] double Contradicted(int piece,
                                    const std::vector<alignment::PlacedPyramid>& placed) const;
  [[nodiscard]] std::vector<alignment::PlacedPyramid> KeyframesOf(int piece) const;
  enum class Motion { kAsPredicted, kOfAHand, kUnlikely };
  [[nodiscard]] Motion MotionTo(const Pose3& world_from_camera,
                                const Anchor& last,
                                const Anchor& frame) const;
  [[nodiscard]] std::optional<Pose3> Predicted(const Anchor& frame) const;
  [[nodiscard]] std::optional<Pose3> SearchStart(const Anchor& anchor, const Anchor& frame) const;
  void Accept(Anchor& frame, const Anchor& aligned_to, const alignment::FrameAlignment& alignment);

  [[nodiscard]] bool WantsKeyframe(const Anchor& frame,
                                   const alignment::FrameAlignment* to_keyframe) const;
  // `direct`: the alignment of the frame to the current keyframe where there is one.
  // Moves the frame to where its alignments to the last two keyframes agree best, and a piece of
  // trajectory that has found back to an earlier one with it.
  void AddKeyframe(Anchor& frame, const alignment::FrameAlignment* direct);
  void AddSkipEdge(Anchor& frame, const alignment::FrameAlignment& direct);
  void RejoinPiece(Anchor& frame);
  [[nodiscard]] bool PassedBy(const Anchor& frame, int earlier_piece) const;
  void GiveUpPieceBefore(const Anchor& frame, FrameIdx keyframe);
  void CarryPiece(Anchor& frame, const Pose3& moved, int joined);
  // Nothing is to be aligned to what walks about.
  void HideMoved(Anchor& frame) const;
  // Only to what was prepared for it frames can be aligned.
  static void Prepare(Anchor& target);
  void PushKeyframe(Anchor frame);
  void AddEdge(const Anchor& i, const Anchor& j, const alignment::FrameAlignment& alignment);
  void AddWeakEdge(const Anchor& i, const Anchor& j);
  void InterpolateGaps();

  const OdometryOptions options_;
  Odometry odometry_;
  std::deque<Anchor> keyframes_;    // the last ones
  std::optional<Anchor> previous_;  // the last aligned frame
  std::optional<alignment::FrameAlignment>
      previous_alignment_;         // of that frame to the current keyframe, if that was it
  std::optional<Anchor> pending_;  // a usable frame that could not be aligned
  Pose3 last_motion_;              // previous frame from the one after it
  double last_interval_s_ = 0;
  double clock_behind_s_ = 0;     // of the capture, by what it was set back
  std::vector<double> clocks_s_;  // of all frames
  bool seen_measured_ = false;    // a frame of more than one depth
  double held_s_ = 0;  // for how long alignments kept a direction of the motion as predicted
  int piece_ = 0;
  std::vector<int> pieces_;                          // of all frames
  std::vector<FrameIdx> piece_starts_{FrameIdx{0}};  // first frame of each piece
};

}  // namespace deepslam::tracking
