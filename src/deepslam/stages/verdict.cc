#include "deepslam/stages/verdict.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/order_statistics.h"
#include "deepslam/report/report_content.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

constexpr double kBadLostShare = 0.5;
constexpr double kDoubtfulLostShare = 0.05;
constexpr double kDoubtfulDegenerateShare = 0.25;
constexpr std::size_t kFewKeyframes = 3;  // fewer: hardly anything was seen twice
// A camera in a hand or on a robot keeps its pace: a step between neighbouring frames that is
// longer than the first and quicker than the second times the capture's median speed is a wrong
// alignment or a cut in the capture.
constexpr double kJumpM = 0.2;
constexpr double kJumpSpeeds = 4;

bool Aligned(const TrackedFrame& frame) {
  return frame.status == TrackingStatus::kTracked || frame.status == TrackingStatus::kDegenerate;
}

struct Step {
  std::size_t to_frame;
  double length_m;
  double speed_m_per_s;
};

// Of frames that are later than the one before.
double UsualIntervalS(const std::vector<TrackedFrame>& frames) {
  std::vector<double> intervals_s;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const double time_s = frames[k].time_s - frames[k - 1].time_s;
    if (time_s > 0) intervals_s.push_back(time_s);
  }
  return intervals_s.empty() ? 0 : Median(intervals_s);
}

std::vector<Step> Steps(const std::vector<TrackedFrame>& frames) {
  std::vector<Step> steps;
  const double usual_s = UsualIntervalS(frames);
  for (std::size_t k = 1; k < frames.size(); ++k) {
    double time_s = frames[k].time_s - frames[k - 1].time_s;
    if (time_s < 0) time_s = usual_s;  // the clock was set back
    if (!Aligned(frames[k - 1]) || !Aligned(frames[k]) || !(time_s > 0)) continue;
    const double length_m =
        (frames[k].world_from_camera.translation_m - frames[k - 1].world_from_camera.translation_m)
            .norm();
    steps.push_back({k, length_m, length_m / time_s});
  }
  return steps;
}

std::vector<Step> Jumps(const std::vector<TrackedFrame>& frames) {
  std::vector<Step> steps = Steps(frames);
  if (steps.empty()) return steps;
  std::vector<double> speeds;
  for (const Step& step : steps) speeds.push_back(step.speed_m_per_s);
  const double usual = Median(speeds);
  std::erase_if(steps, [&](const Step& step) {
    return step.length_m < kJumpM || step.speed_m_per_s < kJumpSpeeds * usual;
  });
  return steps;
}

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
  const std::vector<Step> jumps = Jumps(map.frames);
  if (!jumps.empty()) {
    note(artifact::Verdict::kDoubtful,
         fmt::format("the camera jumps by {:.2f} m at frame {}{}; what was seen before and after "
                     "may not fit together",
                     jumps.front().length_m,
                     jumps.front().to_frame,
                     jumps.size() > 1 ? fmt::format(" and at {} others", jumps.size() - 1) : ""));
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
    if (object.confidence < report::kEvenOdds) {
      note(artifact::Verdict::kDoubtful,
           fmt::format("{} is unsure ({:.2f})", ObjectName(object), object.confidence));
    }
  }
  return verdict;
}

}  // namespace deepslam::stages
