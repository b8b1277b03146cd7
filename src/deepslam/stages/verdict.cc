#include "deepslam/stages/verdict.h"

#include <algorithm>

#include <fmt/format.h>

#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

constexpr double kBadLostShare = 0.5;
constexpr double kDoubtfulLostShare = 0.05;
constexpr double kDoubtfulDegenerateShare = 0.25;
constexpr std::size_t kFewKeyframes = 3;  // fewer: hardly anything was seen twice
constexpr double kLowConfidence = 0.4;    // below even odds that class, shape and place are right

}  // namespace

RunVerdict JudgeRun(const OptimizedMap& map) {
  RunVerdict verdict;
  const auto note = [&](artifact::Verdict level, std::string reason) {
    verdict.verdict = std::max(verdict.verdict, level);
    verdict.reasons.push_back(std::move(reason));
  };
  const auto share = [&](auto... statuses) {
    const auto count =
        std::count_if(map.frames.begin(), map.frames.end(), [&](const TrackedFrame& frame) {
          return ((frame.status == statuses) || ...);
        });
    return map.frames.empty() ? 0.0
                              : static_cast<double>(count) / static_cast<double>(map.frames.size());
  };
  const double lost = share(TrackingStatus::kLost, TrackingStatus::kUnreadable);
  const double degenerate = share(TrackingStatus::kDegenerate);
  if (lost > kDoubtfulLostShare) {
    note(lost > kBadLostShare ? artifact::Verdict::kBad : artifact::Verdict::kDoubtful,
         fmt::format("{:.0f} % of the frames could not be tracked", 100 * lost));
  }
  if (degenerate > kDoubtfulDegenerateShare) {
    note(artifact::Verdict::kDoubtful,
         fmt::format("{:.0f} % of the frames are weakly constrained", 100 * degenerate));
  }
  if (map.keyframes.size() < kFewKeyframes) {
    note(artifact::Verdict::kDoubtful,
         fmt::format("only {} keyframes: the camera hardly moved, so little was seen twice",
                     map.keyframes.size()));
  }
  if (!map.has_ground) note(artifact::Verdict::kDoubtful, "no ground plane was found");
  if (!map.summary.converged) note(artifact::Verdict::kDoubtful, "the graph did not converge");
  if (map.map.objects.empty()) note(artifact::Verdict::kBad, "no object was mapped");
  for (const MapObject& object : map.map.objects) {
    if (object.confidence < kLowConfidence) {
      note(artifact::Verdict::kDoubtful,
           fmt::format("{} is unsure ({:.2f})", ObjectName(object), object.confidence));
    }
  }
  return verdict;
}

}  // namespace deepslam::stages
