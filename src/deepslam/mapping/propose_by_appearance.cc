#include "deepslam/mapping/propose_by_appearance.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/keyframe_features.h"
#include "deepslam/loop/neighbours.h"

namespace deepslam::mapping {
namespace {

constexpr std::size_t kKeyframesAtOnce = 32;  // keyframes looked at side by side

// Which keyframes are looked at, by their place along the path.
struct Look {
  std::vector<char> for_loops;  // at most max_keyframes, evenly
  std::vector<char> at_all;     // these, and those of adjacent pairs
  std::vector<loop::NeighbourPair> adjacent;
};

Look PlanLook(const Odometry& odometry,
              bool by_depth_alone,
              const loop::AppearanceOptions& options) {
  const std::size_t num_keyframes = odometry.keyframes.size();
  const auto step = static_cast<std::size_t>(loop::KeyframeStep(num_keyframes, options));
  Look look;
  look.for_loops.assign(num_keyframes, 0);
  for (std::size_t k = 0; k < num_keyframes; k += step) look.for_loops[k] = 1;
  look.at_all = look.for_loops;
  look.adjacent = loop::PoorlyMeasured(odometry, by_depth_alone);
  for (const loop::NeighbourPair& pair : look.adjacent) {
    look.at_all[static_cast<std::size_t>(pair.older)] = 1;
    look.at_all[static_cast<std::size_t>(pair.newer)] = 1;
  }
  return look;
}

// Pairs whose newer keyframe lies in [begin, end); `pairs` ascend by it.
std::span<const loop::NeighbourPair> PairsOf(std::span<const loop::NeighbourPair> pairs,
                                             std::size_t begin,
                                             std::size_t end) {
  const auto first_from = [&](std::size_t place) {
    return std::ranges::lower_bound(
        pairs, static_cast<int>(place), {}, &loop::NeighbourPair::newer);
  };
  return {first_from(begin), first_from(end)};
}

// Goes along the path once. Adjacent keyframes are compared while the features of both are at hand.
class PathLook {
 public:
  PathLook(const FrameSource& frames,
           const Odometry& odometry,
           bool by_depth_alone,
           const loop::AppearanceOptions& options,
           Progress& progress)
      : frames_(frames),
        odometry_(odometry),
        options_(options),
        progress_(progress),
        look_(PlanLook(odometry, by_depth_alone, options)) {}

  Result<AppearanceProposals> Run() {
    const std::size_t num_keyframes = odometry_.keyframes.size();
    for (std::size_t begin = 0; begin < num_keyframes; begin += kKeyframesAtOnce) {
      if (progress_.StopRequested()) return Interrupted();
      LookAt(begin, std::min(kKeyframesAtOnce, num_keyframes - begin));
      progress_.Report(std::min(begin + kKeyframesAtOnce, num_keyframes), num_keyframes);
    }
    std::ranges::stable_sort(adjacent_, {}, [](const AppearanceLoop& pair) {
      return std::pair(pair.old_keyframe, pair.new_keyframe);
    });
    return AppearanceProposals{
        loop::ProposeAppearanceLoops(features_for_loops_, odometry_, options_),
        std::move(adjacent_)};
  }

 private:
  void LookAt(std::size_t begin, std::size_t count) {
    std::vector<loop::KeyframeFeatures> batch = Extract(begin, count);
    for (std::size_t k = 0; k < count; ++k) {
      if (look_.for_loops[begin + k] != 0) features_for_loops_.push_back(batch[k]);
    }
    if (recent_.size() > loop::kMostNeighbourGap)
      recent_.erase(recent_.begin(), recent_.end() - loop::kMostNeighbourGap);
    const auto first = static_cast<int>(begin - recent_.size());
    std::ranges::move(batch, std::back_inserter(recent_));
    std::ranges::move(loop::ProposeNeighbours(
                          PairsOf(look_.adjacent, begin, begin + count), recent_, first, options_),
                      std::back_inserter(adjacent_));
  }

  // None of keyframes that are not looked at.
  std::vector<loop::KeyframeFeatures> Extract(std::size_t begin, std::size_t count) {
    const auto keyframes = std::span(odometry_.keyframes).subspan(begin, count);
    std::vector<loop::KeyframeFeatures> features(count);
    std::vector<std::string> faults(count);
    ParallelFor(count, [&](std::size_t k) {
      features[k].keyframe = keyframes[k];
      if (look_.at_all[begin + k] == 0) return;
      const Result<Frame> frame = frames_.Read(keyframes[k]);
      if (frame.ok()) {
        features[k] =
            loop::ExtractFeatures(*frame, frames_.camera(), loop::AppearanceOptions::kMaxFeatures);
      } else {
        faults[k] = frame.error().message;
      }
    });
    for (std::size_t k = 0; k < count; ++k) {
      if (faults[k].empty()) continue;
      progress_.Warn(
          fmt::format("frame {} is not looked at for loops: {}", keyframes[k].value, faults[k]));
    }
    return features;
  }

  const FrameSource& frames_;
  const Odometry& odometry_;
  const loop::AppearanceOptions& options_;
  Progress& progress_;
  Look look_;
  std::vector<loop::KeyframeFeatures> features_for_loops_;
  std::vector<loop::KeyframeFeatures> recent_;  // of the batch, behind the last ones before it
  std::vector<AppearanceLoop> adjacent_;
};

}  // namespace

Result<AppearanceProposals> ProposeByAppearance(const FrameSource& frames,
                                                const Odometry& odometry,
                                                bool by_depth_alone,
                                                const loop::AppearanceOptions& options,
                                                Progress& progress) {
  return PathLook(frames, odometry, by_depth_alone, options, progress).Run();
}

}  // namespace deepslam::mapping
