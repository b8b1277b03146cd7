#include "deepslam/report/sanity_checks.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/angles.h"
#include "deepslam/report/path_jumps.h"
#include "deepslam/report/report_content.h"

namespace deepslam::report {
namespace {

constexpr double kBadLostShare = 0.5;        // of frames: most of the capture has no map
constexpr double kDoubtfulLostShare = 0.05;  // less is usual, as of a quick turn
// Of frames that saw too flat a scene to fix all directions.
constexpr double kDoubtfulDegenerateShare = 0.25;
// Of frames whose place relative to the others was not measured. Two captures in one that are laid
// over each other are no map; a few frames between two losses spoil what they alone saw.
constexpr double kBadUnmeasuredShare = 0.2;
constexpr std::size_t kFewKeyframes = 3;  // fewer: hardly anything was seen twice

// Sub-trajectories of frames whose place relative to the largest part was not measured.
struct Unmeasured {
  std::size_t num_sub_trajectories = 0;
  double share = 0;  // of all frames
  // Of the longest sub-trajectory.
  std::size_t first_frame = 0;
  std::size_t last_frame = 0;
  std::size_t cut_frame = 0;  // where tracking found nothing in common with the frames before
};

std::optional<Unmeasured> FindUnmeasured(const OptimizedMap& map,
                                         std::span<const KeyframeJoin> joins) {
  const auto sub_trajectories = MeasuredSubTrajectories(map.frames, map.keyframes, joins);
  if (sub_trajectories.size() < 2) return std::nullopt;
  // A sub-trajectory reaches from its first keyframe to the next sub-trajectory's; what is before
  // the first keyframe is the first sub-trajectory's.
  const auto begin = [&](std::size_t n) -> std::size_t {
    if (n == 0) return 0;
    if (n == sub_trajectories.size()) return map.frames.size();
    const auto keyframe = static_cast<std::size_t>(sub_trajectories[n].first_keyframe);
    return static_cast<std::size_t>(map.keyframes[keyframe].value);
  };
  std::map<int, std::size_t> num_frames;  // by part
  for (std::size_t n = 0; n < sub_trajectories.size(); ++n)
    num_frames[sub_trajectories[n].part] += begin(n + 1) - begin(n);
  const int largest =
      std::ranges::max_element(num_frames, {}, [](const auto& part) { return part.second; })->first;
  Unmeasured unmeasured;
  std::size_t longest = 0;
  for (std::size_t n = 0; n < sub_trajectories.size(); ++n) {
    const std::size_t length = begin(n + 1) - begin(n);
    if (sub_trajectories[n].part == largest) continue;
    ++unmeasured.num_sub_trajectories;
    unmeasured.share += static_cast<double>(length) / static_cast<double>(map.frames.size());
    if (length <= longest) continue;
    longest = length;
    unmeasured.first_frame = begin(n);
    unmeasured.last_frame = begin(n + 1) - 1;
    unmeasured.cut_frame = n > 0 ? begin(n) : begin(1);
  }
  return unmeasured;
}

std::string InWords(const Unmeasured& unmeasured) {
  const std::string others =
      unmeasured.num_sub_trajectories > 1
          ? fmt::format(", nor where {} more such parts are", unmeasured.num_sub_trajectories - 1)
          : "";
  return fmt::format(
      "at frame {} the camera sees nothing in common with the frames before: where frames {} to {} "
      "lie relative to the others was not measured{} ({:.0f} % of the frames), so their "
      "objects may stand in the others'; record again with overlap, or run each part as a capture "
      "of its own",
      unmeasured.cut_frame,
      unmeasured.first_frame,
      unmeasured.last_frame,
      others,
      100 * unmeasured.share);
}

std::string InWords(const std::vector<PathJump>& jumps) {
  const PathJump& first = jumps.front();
  const std::string how =
      first.is_turn ? fmt::format("the camera turns by {:.0f} deg", first.angle_rad / kRadPerDeg)
                    : fmt::format("the camera jumps by {:.2f} m", first.length_m);
  return fmt::format(
      "{} at frame {}{}, unlike the rest of the capture; what was seen "
      "before and after may not fit together",
      how,
      first.to_frame,
      jumps.size() > 1 ? fmt::format(" and at {} others", jumps.size() - 1) : "");
}

void Note(Verdict level, std::string reason, RunVerdict& run) {
  run.verdict = std::max(run.verdict, level);
  run.reasons.push_back(std::move(reason));
}

void CheckTracking(const std::vector<TrackedFrame>& frames, RunVerdict& run) {
  const auto share = [&](auto... statuses) {
    const auto count = std::ranges::count_if(
        frames, [&](const TrackedFrame& frame) { return ((frame.status == statuses) || ...); });
    return frames.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(frames.size());
  };
  const double lost = share(TrackingStatus::kLost, TrackingStatus::kUnreadable);
  const double degenerate = share(TrackingStatus::kDegenerate);
  if (lost > kDoubtfulLostShare) {
    Note(lost > kBadLostShare ? Verdict::kBad : Verdict::kDoubtful,
         fmt::format("{:.0f} % of the frames could not be tracked", 100 * lost),
         run);
  }
  if (degenerate > kDoubtfulDegenerateShare) {
    Note(Verdict::kDoubtful,
         fmt::format("{:.0f} % of the frames are weakly constrained", 100 * degenerate),
         run);
  }
}

void CheckPath(const OptimizedMap& map, std::span<const KeyframeJoin> joins, RunVerdict& run) {
  if (const std::optional<Unmeasured> unmeasured = FindUnmeasured(map, joins)) {
    Note(unmeasured->share > kBadUnmeasuredShare ? Verdict::kBad : Verdict::kDoubtful,
         InWords(*unmeasured),
         run);
  }
  const std::vector<PathJump> jumps = FindPathJumps(map.frames);
  if (!jumps.empty()) Note(Verdict::kDoubtful, InWords(jumps), run);
  if (map.keyframes.size() < kFewKeyframes) {
    Note(Verdict::kDoubtful,
         fmt::format("only {} keyframes: the camera hardly moved, so little was seen twice",
                     map.keyframes.size()),
         run);
  }
}

void CheckMap(const OptimizedMap& map, RunVerdict& run) {
  if (!map.has_ground) Note(Verdict::kDoubtful, "no ground plane was found", run);
  if (!map.summary.converged) Note(Verdict::kDoubtful, "the graph did not converge", run);
  if (map.map.objects.empty()) Note(Verdict::kBad, "no object was mapped", run);
  for (const MapObject& object : map.map.objects) {
    if (object.confidence < kEvenOdds) {
      Note(Verdict::kDoubtful,
           fmt::format("{} is unsure ({:.2f})", ObjectName(object), object.confidence),
           run);
    }
  }
}

}  // namespace

RunVerdict CheckRun(const OptimizedMap& map,
                    std::span<const KeyframeJoin> joins,
                    std::span<const std::string> doubts) {
  RunVerdict run;
  for (const std::string& doubt : doubts) Note(Verdict::kDoubtful, doubt, run);
  CheckTracking(map.frames, run);
  CheckPath(map, joins, run);
  CheckMap(map, run);
  return run;
}

}  // namespace deepslam::report
