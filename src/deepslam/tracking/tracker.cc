#include "deepslam/tracking/tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "deepslam/alignment/detail_likeness.h"
#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/alignment/rotation_search.h"
#include "deepslam/core/order_statistics.h"
#include "deepslam/tracking/pose_interpolation.h"

namespace deepslam::tracking {

using alignment::AlignPyramids;
using alignment::AsReference;
using alignment::ContradictedShare;
using alignment::DepthNoise;
using alignment::DetailCorrelation;
using alignment::FrameAlignment;
using alignment::FramePyramid;
using alignment::IsReference;
using alignment::OtherStarts;
using alignment::PlacedPyramid;
using alignment::PyramidLevel;
using alignment::RefineAlignment;
using alignment::SearchRotation;
using alignment::Sharpened;
using alignment::StartSigma;
using alignment::Support;
using alignment::WithoutMoved;

namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
// A motion is carried on over at most this many times the interval it was measured in.
constexpr double kMaxPredictionRatio = 3.0;
// Overlap that a skip edge needs: below, it adds little and fails often.
constexpr double kSkipEdgeOverlap = 0.4;
// Holes in both depth images leave few common points between frames that see the same place: only
// this share of the asked overlap makes a keyframe of such a frame.
constexpr double kFewCommonPoints = 0.5;

// Alignments of real captures that are right reach these; below, other minima are looked for.
constexpr double kSureAgreement = 0.85;
constexpr double kSureCorrelation = 0.8;
// Successive images correlate like that where they are laid right, however poor their depth is;
// laid elsewhere, they differ by parallax.
constexpr double kSameImage = 0.95;
constexpr std::array<double, 4> kTurnsDeg = {-18, -9, 9, 18};

// Of cameras in hands, one standard deviation.
constexpr double kHandSpeed = 0.5;        // m/s
constexpr double kHandAcceleration = 2;   // m/s^2
constexpr double kWristSpeed = 0.7;       // rad/s
constexpr double kWristAcceleration = 4;  // rad/s^2
constexpr double kManySigmas = 5;
// Of a prediction from two alignments, beside what the hand does, one standard deviation: where
// somebody walks through they are off by several centimetres.
constexpr double kPredictedM = 0.02;
constexpr double kPredictedRad = 0.016;
// Farther off, or after a longer time, a prediction is none.
constexpr StartSigma kFarthestPrediction;
// Share that keyframes may contradict of a frame which a hand may have brought there: noise that is
// underrated makes as much. Placed right, captures without motion leave less than half of it.
constexpr double kMaxContradicted = 0.02;
constexpr double kMaxContradictedFar = 0.01;
// Frames that are placed right reach this: real captures 0.7 and more. At wrong places it is seldom
// above 0.6, also where the same chair stands.
constexpr double kLikeDetails = 0.65;
// Where no hand would have carried the camera, wrong places are as many as there are keyframes:
// the same furniture on a like floor reaches 0.68.
constexpr double kLikeDetailsFar = 0.72;

// A camera whose motion nothing shows may be anywhere after a while, also where it would see
// something again: it is compared with what it saw lately.
constexpr double kLongHeld_s = 0.5;
// As long as somebody takes to pass by.
constexpr double kPassingBy_s = 2;

bool Doubtful(const FrameAlignment& alignment) {
  if (!alignment.ok) return true;
  return alignment.intensity_correlation < kSameImage &&
         (alignment.inlier_ratio < kSureAgreement ||
          alignment.intensity_correlation < kSureCorrelation);
}

TrackingStatus StatusOf(bool degenerate) {
  return degenerate ? TrackingStatus::kDegenerate : TrackingStatus::kTracked;
}

double MedianDepthM(const PyramidLevel& level) {
  std::vector<float> depths;
  std::ranges::copy_if(level.depth_m, std::back_inserter(depths), [](float z) { return z > 0; });
  if (depths.empty()) return 1.0;
  return static_cast<double>(Median(depths));
}

// Camera motions about the point in front of the camera: they leave the image in place, so that
// neither prediction nor image-based search finds them, and are what a camera does that is carried
// round an object.
std::vector<Pose3> Orbits(double distance_m) {
  std::vector<Pose3> orbits;
  const Eigen::Vector3d centre(0, 0, distance_m);
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0, 0)}) {
    for (const double turn_deg : kTurnsDeg) {
      const Eigen::Quaterniond rotation = RotationFromVector(turn_deg * kRadPerDeg * axis);
      orbits.push_back({rotation, centre - rotation * centre});
    }
  }
  return orbits;
}

Matrix6d DiagonalInformation(double translation_m, double rotation_deg) {
  Vector6d diagonal;
  diagonal.head<3>().setConstant(1 / (translation_m * translation_m));
  diagonal.tail<3>().setConstant(1 / std::pow(rotation_deg * kRadPerDeg, 2));
  return diagonal.asDiagonal();
}

}  // namespace

void Tracker::Add(FrameIdx frame, double time_s, std::shared_ptr<const FramePyramid> pyramid) {
  const double clock_s = ClockS(time_s);
  clocks_s_.push_back(clock_s);
  if (pyramid == nullptr) {
    AddUnaligned(TrackingStatus::kUnreadable, frame, time_s);
    return;
  }
  const bool one_depth = pyramid->one_depth;
  if (pyramid->valid_share < options_.min_valid_share || (one_depth && seen_measured_)) {
    AddUnaligned(TrackingStatus::kLost, frame, time_s);
    return;
  }
  if (!one_depth && !seen_measured_) {
    ForgetOneDepth();
    seen_measured_ = true;
  }
  Anchor anchor{frame, time_s, clock_s, std::move(pyramid), Pose3{}, piece_};
  if (keyframes_.empty()) {
    odometry_.frames.push_back({frame, time_s, Pose3{}, StatusOf(one_depth), frame, 0, 1});
    pieces_.push_back(0);
    PushKeyframe(anchor);
    previous_ = anchor;
    return;
  }
  Align(anchor);
}

// Where the capture's clock is set back, as long as between the two frames before has passed.
double Tracker::ClockS(double time_s) {
  const double clock_s = time_s + clock_behind_s_;
  if (clocks_s_.empty() || clock_s >= clocks_s_.back()) return clock_s;
  const std::size_t last = clocks_s_.size() - 1;
  const double interval_s = last > 0 ? clocks_s_[last] - clocks_s_[last - 1] : 0;
  const double goes_on_s = clocks_s_[last] + interval_s;
  clock_behind_s_ += goes_on_s - clock_s;
  return goes_on_s;
}

void Tracker::ForgetOneDepth() {
  if (odometry_.keyframes.empty()) return;
  for (TrackedFrame& frame : odometry_.frames) {
    if (frame.status == TrackingStatus::kUnreadable) continue;
    frame = {frame.frame, frame.time_s, Pose3{}, TrackingStatus::kLost, FrameIdx{}, 0, 0};
  }
  odometry_.keyframes.clear();
  odometry_.edges.clear();
  keyframes_.clear();
  previous_.reset();
  previous_alignment_.reset();
  pending_.reset();
  last_interval_s_ = 0;
  held_s_ = 0;
  piece_ = 0;
  piece_starts_.resize(1);
}

void Tracker::AddUnaligned(TrackingStatus status, FrameIdx frame, double time_s) {
  const Pose3 last = previous_ ? previous_->world_from_camera : Pose3{};
  const FrameIdx keyframe = keyframes_.empty() ? FrameIdx{} : keyframes_.back().frame;
  odometry_.frames.push_back({frame, time_s, last, status, keyframe, 0, 0});
  pieces_.push_back(previous_ ? previous_->piece : 0);
}

void Tracker::Align(Anchor& frame) {
  if (AlignToReference(frame) || AlignToPrevious(frame) || Relocalise(frame) ||
      AlignToPending(frame))
    return;
  Lose(frame);
}

// The motion before, carried on.
std::optional<Pose3> Tracker::Predicted(const Anchor& frame) const {
  if (!(last_interval_s_ > 0)) return std::nullopt;
  const double ratio = (frame.clock_s - previous_->clock_s) / last_interval_s_;
  if (!(ratio > 0) || ratio > kMaxPredictionRatio) return std::nullopt;
  return previous_->world_from_camera * V2t(ratio * T2v(last_motion_));
}

Tracker::Starts Tracker::StartsOf(const Anchor& frame) const {
  Starts starts;
  if (options_.motion_prediction) {
    if (const auto predicted = Predicted(frame)) starts.world_from_camera.push_back(*predicted);
  }
  starts.world_from_camera.push_back(previous_->world_from_camera);
  if (options_.rotation_search) starts.turned_from = &*previous_;
  return starts;
}

std::optional<Pose3> Tracker::SearchStart(const Anchor& anchor, const Anchor& frame) const {
  const auto rotation = SearchRotation(*anchor.pyramid, *frame.pyramid);
  if (!rotation) return std::nullopt;
  return anchor.world_from_camera * Pose3{*rotation, Eigen::Vector3d::Zero()};
}

FrameAlignment Tracker::AlignTo(const Anchor& anchor,
                                const Anchor& frame,
                                const std::vector<Pose3>& starts_world,
                                const OtherStarts& others) const {
  const Pose3 anchor_from_world = anchor.world_from_camera.Inverse();
  std::vector<Pose3> starts;
  starts.reserve(starts_world.size());
  for (const Pose3& start : starts_world) starts.push_back(anchor_from_world * start);
  const auto search = [&]() -> std::optional<Pose3> {
    if (!others.search) return std::nullopt;
    const std::optional<Pose3> found = others.search();
    return found ? std::optional(anchor_from_world * *found) : std::nullopt;
  };
  return AlignPyramids(*anchor.pyramid,
                       *frame.pyramid,
                       starts,
                       options_.alignment,
                       SigmaOfStart(frame.clock_s - anchor.clock_s),
                       {search, others.always});
}

// The first start after `duration_s` of prediction from frame to frame, or of none. A motion that
// was predicted itself, since nothing showed it, is as old as when it was last seen.
StartSigma Tracker::SigmaOfStart(double duration_s) const {
  StartSigma sigma;
  if (!(duration_s > 0) || !(last_interval_s_ > 0)) return sigma;
  const bool predicted = options_.motion_prediction;
  const double motion_age_s = 0.5 * last_interval_s_ + held_s_;
  const double speed_error_m_per_s = predicted ? kHandAcceleration * motion_age_s : kHandSpeed;
  const double turn_error_per_s = predicted ? kWristAcceleration * motion_age_s : kWristSpeed;
  const double reach_m = std::max(sigma.translation_m, kHandSpeed * duration_s);
  const double turned_rad = std::max(sigma.rotation_rad, kWristSpeed * duration_s);
  sigma.translation_m = std::min(reach_m, speed_error_m_per_s * duration_s);
  sigma.rotation_rad = std::min(turned_rad, turn_error_per_s * duration_s);
  return sigma;
}

FrameAlignment Tracker::AlignWidely(const Anchor& anchor,
                                    const Anchor& last,
                                    const Anchor& frame,
                                    Starts starts) const {
  std::vector<Pose3>& starts_world = starts.world_from_camera;
  const auto search_turn = [&]() -> std::optional<Pose3> {
    if (starts.turned_from == nullptr) return std::nullopt;
    const auto found = SearchStart(*std::exchange(starts.turned_from, nullptr), frame);
    if (found) starts_world.push_back(*found);
    return found;
  };
  const auto align = [&](const OtherStarts& others) {
    FrameAlignment alignment = AlignTo(anchor, frame, starts_world, others);
    alignment.ok = alignment.ok && Believable(anchor, last, frame, alignment);
    return alignment;
  };
  const FrameAlignment first = align({search_turn});
  if (!options_.wide_search || !Doubtful(first)) return first;
  search_turn();
  const std::vector<Pose3> orbits = Orbits(MedianDepthM(frame.pyramid->levels.back()));
  const std::size_t num_starts = starts_world.size();
  for (std::size_t k = 0; k < num_starts; ++k) {
    for (const Pose3& orbit : orbits) starts_world.push_back(starts_world[k] * orbit);
  }
  const FrameAlignment second = align({.search = {}, .always = true});
  const auto support_of = [&](const FrameAlignment& alignment) {
    return Support(*anchor.pyramid, *frame.pyramid, alignment.i_from_j, options_.alignment);
  };
  const bool better = second.ok == first.ok ? support_of(second) > support_of(first) : second.ok;
  return better ? second : first;
}

Tracker::Motion Tracker::MotionTo(const Pose3& world_from_camera,
                                  const Anchor& last,
                                  const Anchor& frame) const {
  const double duration_s = frame.clock_s - last.clock_s;
  const auto predicted = last.frame == previous_->frame ? Predicted(frame) : std::nullopt;
  const Pose3 expected = predicted.value_or(last.world_from_camera);
  const Pose3 off = expected.Inverse() * world_from_camera;
  const double off_m = off.translation_m.norm();
  const double off_rad = RotationAngle(off.rotation);
  if (predicted) {
    const StartSigma hand = SigmaOfStart(duration_s);
    const double sigma_m = std::hypot(hand.translation_m, kPredictedM);
    const double sigma_rad = std::hypot(hand.rotation_rad, kPredictedRad);
    if (off_m <= std::min(kFarthestPrediction.translation_m, kManySigmas * sigma_m) &&
        off_rad <= std::min(kFarthestPrediction.rotation_rad, kManySigmas * sigma_rad))
      return Motion::kAsPredicted;
  }
  // Back the way it came is twice the motion off.
  const Pose3 motion = last.world_from_camera.Inverse() * expected;
  const bool of_a_hand =
      off_m <= kManySigmas * kHandSpeed * duration_s + 2 * motion.translation_m.norm() &&
      off_rad <= kManySigmas * kWristSpeed * duration_s + 2 * RotationAngle(motion.rotation);
  return of_a_hand || !(duration_s > 0) ? Motion::kOfAHand : Motion::kUnlikely;
}

// What fits where the camera was expected is taken for it, whatever has moved: unless it looks like
// another place as well. Elsewhere most frames fit somehow, so nothing may speak against it; and
// where no hand would have carried the camera, all has to speak for it.
bool Tracker::Believable(const Anchor& anchor,
                         const Anchor& last,
                         const Anchor& frame,
                         const FrameAlignment& alignment) const {
  if (options_.reference == "previous") return true;  // the paper's plain behaviour
  const Pose3 placed = anchor.world_from_camera * alignment.i_from_j;
  const DepthNoise& noise = options_.alignment.pyramid.noise;
  const auto sure = [&] { return !Doubtful(alignment); };
  const auto looks_like_it = [&](double least = kLikeDetails) {
    return DetailCorrelation(*anchor.pyramid, *frame.pyramid, alignment.i_from_j, noise) >= least;
  };
  const auto contradicted = [&](double most) {
    const PlacedPyramid seen{frame.pyramid, placed};
    const PlacedPyramid seen_before{anchor.pyramid, anchor.world_from_camera};
    return ContradictedShare({&seen, 1}, {&seen_before, 1}, noise) > most ||
           Contradicted(anchor.piece, {seen}) > most;
  };
  const bool one_piece = last.piece == anchor.piece;
  switch (one_piece ? MotionTo(placed, last, frame) : Motion::kUnlikely) {
    case Motion::kAsPredicted:
      return sure() || looks_like_it() || !contradicted(kMaxContradicted);
    case Motion::kOfAHand:
      return looks_like_it() && !contradicted(kMaxContradicted);
    case Motion::kUnlikely:
      break;
  }
  return sure() && looks_like_it(kLikeDetailsFar) && !contradicted(kMaxContradictedFar);
}

std::vector<PlacedPyramid> Tracker::KeyframesOf(int piece) const {
  std::vector<PlacedPyramid> keyframes;
  for (const Anchor& keyframe : keyframes_) {
    if (keyframe.piece == piece)
      keyframes.push_back({keyframe.pyramid, keyframe.world_from_camera});
  }
  return keyframes;
}

double Tracker::Contradicted(int piece, const std::vector<PlacedPyramid>& placed) const {
  return ContradictedShare(KeyframesOf(piece), placed, options_.alignment.pyramid.noise);
}

void Tracker::Accept(Anchor& frame, const Anchor& aligned_to, const FrameAlignment& alignment) {
  frame.world_from_camera = aligned_to.world_from_camera * alignment.i_from_j;
  frame.piece = aligned_to.piece;
  last_motion_ = previous_->world_from_camera.Inverse() * frame.world_from_camera;
  last_interval_s_ = frame.clock_s - previous_->clock_s;
  held_s_ = alignment.held ? held_s_ + last_interval_s_ : 0;
  pending_.reset();
}

void Tracker::AddAligned(const Anchor& frame, const FrameAlignment& alignment) {
  odometry_.frames.push_back({frame.frame,
                              frame.time_s,
                              frame.world_from_camera,
                              StatusOf(alignment.degenerate || frame.pyramid->one_depth),
                              keyframes_.back().frame,
                              alignment.rmse_m,
                              alignment.inlier_share});
  pieces_.push_back(frame.piece);
  previous_ = frame;
}

bool Tracker::AlignToReference(Anchor& frame) {
  const bool to_previous = options_.reference == "previous";
  if (to_previous) Prepare(*previous_);
  const Anchor reference = to_previous ? *previous_ : keyframes_.back();
  FrameAlignment alignment = AlignWidely(reference, *previous_, frame, StartsOf(frame));
  if (!alignment.ok) return false;
  // From frame to frame each end carries on.
  if (to_previous)
    alignment = Sharpened(alignment, *reference.pyramid, *frame.pyramid, options_.alignment);
  Accept(frame, reference, alignment);
  if (to_previous) {
    previous_alignment_.reset();
    if (WantsKeyframe(frame, nullptr)) AddKeyframe(frame, nullptr);
  } else {
    previous_alignment_ = alignment;
    if (WantsKeyframe(frame, &alignment)) AddKeyframe(frame, &alignment);
  }
  AddAligned(frame, alignment);
  return true;
}

// Too far from the keyframe, but still near the frame before: that one becomes the keyframe.
bool Tracker::AlignToPrevious(Anchor& frame) {
  if (options_.reference == "previous" || previous_->frame == keyframes_.back().frame) return false;
  HideMoved(*previous_);
  Prepare(*previous_);
  const FrameAlignment alignment = AlignWidely(*previous_, *previous_, frame, StartsOf(frame));
  if (!alignment.ok) return false;
  const std::optional<FrameAlignment> direct = previous_alignment_;
  AddKeyframe(*previous_, direct ? &*direct : nullptr);
  TrackedFrame& promoted = odometry_.frames[static_cast<std::size_t>(previous_->frame.value)];
  promoted.keyframe = promoted.frame;
  promoted.world_from_camera = previous_->world_from_camera;
  Accept(frame, *previous_, alignment);
  previous_alignment_ = alignment;
  AddAligned(frame, alignment);
  return true;
}

bool Tracker::Relocalise(Anchor& frame) {
  for (auto keyframe = keyframes_.rbegin(); keyframe != keyframes_.rend(); ++keyframe) {
    const Starts starts{{previous_->world_from_camera, keyframe->world_from_camera}, &*keyframe};
    FrameAlignment alignment = AlignWidely(*keyframe, *previous_, frame, starts);
    // Elsewhere some earlier keyframe nearly always fits somehow; a new piece is joined when it is
    // sure where.
    const bool is_last = keyframe == keyframes_.rbegin();
    if (!alignment.ok || (!is_last && Doubtful(alignment))) continue;
    const Anchor found = *keyframe;
    alignment = Sharpened(alignment, *found.pyramid, *frame.pyramid, options_.alignment);
    Accept(frame, found, alignment);
    last_interval_s_ = 0;  // the motion across a loss predicts nothing
    if (found.frame != keyframes_.back().frame) {
      AddEdge(found, frame, alignment);
      AddWeakEdge(keyframes_.back(), frame);
    } else {
      AddEdge(found, frame, alignment);
    }
    PushKeyframe(frame);
    previous_alignment_.reset();
    AddAligned(frame, alignment);
    return true;
  }
  return false;
}

// The frame before was lost as well, but the two fit together: a new piece of trajectory begins
// there.
bool Tracker::AlignToPending(Anchor& frame) {
  if (!pending_) return false;
  Anchor start = *pending_;
  start.piece = piece_ + 1;
  Prepare(start);
  const FrameAlignment alignment =
      AlignWidely(start, start, frame, {{start.world_from_camera}, &start});
  if (!alignment.ok) return false;
  piece_ = start.piece;
  piece_starts_.push_back(start.frame);
  AddWeakEdge(keyframes_.back(), start);
  PushKeyframe(start);
  odometry_.frames[static_cast<std::size_t>(start.frame.value)].keyframe = start.frame;
  pieces_[static_cast<std::size_t>(start.frame.value)] = start.piece;
  previous_ = start;
  Accept(frame, start, alignment);
  previous_alignment_ = alignment;
  AddAligned(frame, alignment);
  return true;
}

void Tracker::Lose(const Anchor& frame) {
  AddUnaligned(TrackingStatus::kLost, frame.frame, frame.time_s);
  pending_ = frame;
  pending_->world_from_camera = previous_->world_from_camera;
  last_interval_s_ = 0;
}

bool Tracker::WantsKeyframe(const Anchor& frame, const FrameAlignment* to_keyframe) const {
  if (to_keyframe != nullptr && to_keyframe->held &&
      frame.clock_s - keyframes_.back().clock_s > kLongHeld_s)
    return true;
  const Pose3 moved = keyframes_.back().world_from_camera.Inverse() * frame.world_from_camera;
  if (moved.translation_m.norm() > options_.keyframe_distance_m) return true;
  if (RotationAngle(moved.rotation) > options_.keyframe_angle_deg * kRadPerDeg) return true;
  return to_keyframe != nullptr &&
         (to_keyframe->inside < options_.keyframe_min_overlap ||
          to_keyframe->overlap < kFewCommonPoints * options_.keyframe_min_overlap);
}

void Tracker::AddKeyframe(Anchor& frame, const FrameAlignment* direct) {
  HideMoved(frame);
  const Anchor& last = keyframes_.back();
  const FrameAlignment alignment =
      Sharpened(direct != nullptr ? *direct : AlignTo(last, frame, {frame.world_from_camera}),
                *last.pyramid,
                *frame.pyramid,
                options_.alignment);
  if (direct != nullptr && alignment.ok)
    frame.world_from_camera = last.world_from_camera * alignment.i_from_j;
  frame.held = alignment.held;
  if (alignment.ok) {
    AddEdge(last, frame, alignment);
    AddSkipEdge(frame, alignment);
  } else {
    AddWeakEdge(last, frame);
  }
  RejoinPiece(frame);
  PushKeyframe(frame);
  previous_alignment_.reset();
}

void Tracker::AddSkipEdge(Anchor& frame, const FrameAlignment& direct) {
  if (!options_.skip_edges || keyframes_.size() < 2) return;
  const Anchor& before_last = keyframes_[keyframes_.size() - 2];
  if (before_last.piece != frame.piece || keyframes_.back().held) return;
  const FrameAlignment skip =
      RefineAlignment(*before_last.pyramid,
                      *frame.pyramid,
                      before_last.world_from_camera.Inverse() * frame.world_from_camera,
                      options_.alignment);
  if (!skip.ok || skip.inside < kSkipEdgeOverlap || skip.inlier_ratio < kSureAgreement) return;
  const Pose3 by_last = keyframes_.back().world_from_camera * direct.i_from_j;
  const Pose3 by_skip = before_last.world_from_camera * skip.i_from_j;
  const Vector6d difference = T2v(by_last.Inverse() * by_skip);
  // Two measurements that disagree beyond their covariances are both less certain than they say:
  // the Birge ratio scales them down. The edge to the last keyframe is the one just added.
  const Matrix6d covariance = direct.information.inverse() + skip.information.inverse();
  const double birge = std::max(1.0, difference.dot(covariance.ldlt().solve(difference)) / 6);
  odometry_.edges.back().information = direct.information / birge;
  AddEdge(before_last, frame, skip);
  odometry_.edges.back().information = skip.information / birge;
  // Least squares over the two.
  const Matrix6d joint = direct.information + skip.information;
  const Vector6d step = joint.ldlt().solve(skip.information * difference);
  frame.world_from_camera = by_last * V2t(step);
}

// A piece that began after a loss is carried over as soon as one of its keyframes fits an earlier
// keyframe.
void Tracker::RejoinPiece(Anchor& frame) {
  for (const Anchor& earlier : keyframes_) {
    if (earlier.piece >= frame.piece) continue;
    FrameAlignment alignment =
        AlignWidely(earlier, *previous_, frame, {{earlier.world_from_camera}, &earlier});
    if (Doubtful(alignment)) continue;
    alignment = Sharpened(alignment, *earlier.pyramid, *frame.pyramid, options_.alignment);
    const Pose3 moved =
        earlier.world_from_camera * alignment.i_from_j * frame.world_from_camera.Inverse();
    std::vector<PlacedPyramid> carried = KeyframesOf(frame.piece);
    for (PlacedPyramid& keyframe : carried)
      keyframe.world_from_camera = moved * keyframe.world_from_camera;
    const bool belongs = Contradicted(earlier.piece, carried) <= kMaxContradictedFar;
    if (!belongs && !PassedBy(frame, earlier.piece)) continue;
    const Anchor found = earlier;
    if (!belongs) GiveUpPieceBefore(frame, found.frame);
    CarryPiece(frame, moved, found.piece);
    AddEdge(found, frame, alignment);
    if (!belongs && found.frame != keyframes_.back().frame) AddWeakEdge(keyframes_.back(), frame);
    return;
  }
}

// Whether the frame's piece is as short as somebody takes who comes so near that little else is in
// view, and shorter than what was before.
bool Tracker::PassedBy(const Anchor& frame, int earlier_piece) const {
  const auto start = [&](int piece) { return piece_starts_[static_cast<std::size_t>(piece)]; };
  const auto start_s = [&](int piece) {
    return clocks_s_[static_cast<std::size_t>(start(piece).value)];
  };
  const double lasts_s = frame.clock_s - start_s(frame.piece);
  const double lasted_s = start_s(frame.piece) - start_s(earlier_piece);
  return lasts_s < std::min(kPassingBy_s, lasted_s) &&
         std::ranges::all_of(keyframes_, [&](const Anchor& keyframe) {
           return (keyframe.frame >= start(frame.piece)) == (keyframe.piece == frame.piece);
         });
}

// The piece followed what had moved: its frames are lost, as the one before.
void Tracker::GiveUpPieceBefore(const Anchor& frame, FrameIdx keyframe) {
  const FrameIdx start = piece_starts_[static_cast<std::size_t>(frame.piece)];
  for (int k = start.value; k < frame.frame.value; ++k) {
    TrackedFrame& followed = odometry_.frames[static_cast<std::size_t>(k)];
    if (followed.status != TrackingStatus::kUnreadable) followed.status = TrackingStatus::kLost;
    followed.keyframe = keyframe;
  }
  std::erase_if(odometry_.keyframes, [&](FrameIdx followed) { return followed >= start; });
  std::erase_if(odometry_.edges,
                [&](const RelativePose& edge) { return edge.i >= start || edge.j >= start; });
  std::erase_if(keyframes_, [&](const Anchor& followed) { return followed.frame >= start; });
}

// The frame's piece becomes a part of an earlier one, with the frame.
void Tracker::CarryPiece(Anchor& frame, const Pose3& moved, int joined) {
  const int piece = frame.piece;
  const auto carry = [&](Anchor& anchor) {
    if (anchor.piece != piece) return;
    anchor.world_from_camera = moved * anchor.world_from_camera;
    anchor.piece = joined;
  };
  const FrameIdx start = piece_starts_[static_cast<std::size_t>(piece)];
  for (std::size_t k = static_cast<std::size_t>(start.value); k < odometry_.frames.size(); ++k) {
    if (pieces_[k] != piece) continue;  // others came between two stays in this one
    odometry_.frames[k].world_from_camera = moved * odometry_.frames[k].world_from_camera;
    pieces_[k] = joined;
  }
  for (Anchor& anchor : keyframes_) carry(anchor);
  carry(*previous_);
  carry(frame);  // nothing where it is the previous one itself
}

void Tracker::HideMoved(Anchor& frame) const {
  if (options_.reference == "previous") return;  // the paper's plain behaviour
  frame.pyramid = WithoutMoved({frame.pyramid, frame.world_from_camera},
                               KeyframesOf(frame.piece),
                               options_.alignment.pyramid.noise);
}

void Tracker::Prepare(Anchor& target) {
  if (IsReference(*target.pyramid)) return;
  target.pyramid = std::make_shared<const FramePyramid>(AsReference(*target.pyramid));
}

void Tracker::PushKeyframe(Anchor frame) {
  Prepare(frame);
  odometry_.keyframes.push_back(frame.frame);
  keyframes_.push_back(std::move(frame));
  while (keyframes_.size() > static_cast<std::size_t>(options_.num_relocalisation_keyframes))
    keyframes_.pop_front();
}

void Tracker::AddEdge(const Anchor& i, const Anchor& j, const FrameAlignment& alignment) {
  odometry_.edges.push_back({i.frame, j.frame, alignment.i_from_j, alignment.information, false});
}

void Tracker::AddWeakEdge(const Anchor& i, const Anchor& j) {
  odometry_.edges.push_back(
      {i.frame,
       j.frame,
       i.world_from_camera.Inverse() * j.world_from_camera,
       DiagonalInformation(options_.lost_translation_m, options_.lost_rotation_deg),
       true});
}

// Frames without an alignment of their own lie between their aligned neighbours, as far as there
// are any.
void Tracker::InterpolateGaps() {
  std::vector<std::optional<Pose3>> poses;
  for (const TrackedFrame& frame : odometry_.frames) {
    const bool aligned = frame.status == TrackingStatus::kTracked ||
                         frame.status == TrackingStatus::kDegenerate ||
                         frame.keyframe == frame.frame;
    poses.push_back(aligned ? std::optional(frame.world_from_camera) : std::nullopt);
  }
  const std::vector<Pose3> filled = InterpolateMissing(poses, clocks_s_);
  for (std::size_t k = 0; k < filled.size(); ++k) odometry_.frames[k].world_from_camera = filled[k];
}

Odometry Tracker::Finish() && {
  if (odometry_.keyframes.empty()) return std::move(odometry_);
  for (TrackedFrame& frame : odometry_.frames) {
    if (!frame.keyframe.valid()) frame.keyframe = odometry_.keyframes.front();
  }
  InterpolateGaps();
  return std::move(odometry_);
}

}  // namespace deepslam::tracking
