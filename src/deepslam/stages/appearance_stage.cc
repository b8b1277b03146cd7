#include "deepslam/stages/appearance_stage.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/core/parallel.h"
#include "deepslam/loop/neighbours.h"
#include "deepslam/stages/keyframe_graph.h"
#include "deepslam/stages/register_pairs.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;

constexpr std::size_t kBatch = 32;  // keyframes looked at side by side

// Which keyframes are looked at, by their place along the path.
struct Look {
  std::vector<char> for_loops;  // at most max_keyframes, evenly
  std::vector<char> at_all;     // these, and those of neighbours
  std::vector<loop::NeighbourPair> neighbours;
};

Look PlanLook(const RunInputs& inputs, const Odometry& odometry) {
  const std::size_t num_keyframes = odometry.keyframes.size();
  const auto step =
      static_cast<std::size_t>(loop::KeyframeStep(num_keyframes, inputs.config.appearance));
  const bool depth_alone =
      inputs.config.track_stage.poses != "capture" && !inputs.config.track.alignment.photometric;
  Look look;
  look.for_loops.assign(num_keyframes, 0);
  for (std::size_t k = 0; k < num_keyframes; k += step) look.for_loops[k] = 1;
  look.at_all = look.for_loops;
  look.neighbours = loop::PoorlyMeasured(odometry, depth_alone);
  for (const loop::NeighbourPair& pair : look.neighbours) {
    look.at_all[static_cast<std::size_t>(pair.older)] = 1;
    look.at_all[static_cast<std::size_t>(pair.newer)] = 1;
  }
  return look;
}

// Of keyframes from place `begin` on; none of those that are not looked at.
Result<std::vector<loop::KeyframeFeatures>> Extract(const StageContext& context,
                                                    const RunInputs& inputs,
                                                    const Look& look,
                                                    std::size_t begin,
                                                    std::span<const FrameIdx> keyframes) {
  if (context.progress().StopRequested()) return Interrupted();
  const FrameSource& frames = *inputs.capture->frames;
  std::vector<loop::KeyframeFeatures> features(keyframes.size());
  std::vector<std::string> faults(keyframes.size());
  ParallelFor(keyframes.size(), [&](std::size_t k) {
    features[k].keyframe = keyframes[k];
    if (look.at_all[begin + k] == 0) return;
    const Result<Frame> frame = frames.Read(keyframes[k]);
    if (frame.ok()) {
      features[k] =
          loop::ExtractFeatures(*frame, frames.camera(), inputs.config.appearance.max_features);
    } else {
      faults[k] = frame.error().message;
    }
  });
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    if (faults[k].empty()) continue;
    context.progress().Warn(
        fmt::format("frame {} is not looked at for loops: {}", keyframes[k].value, faults[k]));
  }
  return features;
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

struct Seen {
  std::vector<loop::KeyframeFeatures> for_loops;
  std::vector<AppearanceLoop> neighbours;  // proposed; in the order of the older keyframes
};

// Goes along the path once. Neighbours are compared while the features of both are at hand.
Result<Seen> LookAtKeyframes(const StageContext& context,
                             const RunInputs& inputs,
                             const Odometry& odometry) {
  const Look look = PlanLook(inputs, odometry);
  const std::span<const FrameIdx> keyframes = odometry.keyframes;
  Seen seen;
  std::vector<loop::KeyframeFeatures> run;  // of the batch, behind the last ones before it
  for (std::size_t begin = 0; begin < keyframes.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, keyframes.size() - begin);
    Result<std::vector<loop::KeyframeFeatures>> batch =
        Extract(context, inputs, look, begin, keyframes.subspan(begin, count));
    if (!batch.ok()) return batch.error();
    if (run.size() > loop::kMostNeighbourGap)
      run.erase(run.begin(), run.end() - loop::kMostNeighbourGap);
    const auto first = static_cast<int>(begin - run.size());
    for (std::size_t k = 0; k < count; ++k) {
      if (look.for_loops[begin + k] != 0) seen.for_loops.push_back((*batch)[k]);
    }
    std::ranges::move(*batch, std::back_inserter(run));
    std::ranges::move(
        loop::ProposeNeighbours(
            PairsOf(look.neighbours, begin, begin + count), run, first, inputs.config.appearance),
        std::back_inserter(seen.neighbours));
    context.progress().Report(begin + count, keyframes.size());
  }
  std::ranges::stable_sort(seen.neighbours, {}, [](const AppearanceLoop& pair) {
    return std::pair(pair.old_keyframe, pair.new_keyframe);
  });
  return seen;
}

struct Proposed {
  std::vector<AppearanceLoop> loops;
  std::vector<AppearanceLoop> neighbours;
};

// Features, the largest of what is held here, are gone when what they propose is registered.
Result<Proposed> Propose(const StageContext& context,
                         const RunInputs& inputs,
                         const Odometry& odometry) {
  Result<Seen> seen = LookAtKeyframes(context, inputs, odometry);
  if (!seen.ok()) return seen.error();
  return Proposed{loop::ProposeAppearanceLoops(seen->for_loops, odometry, inputs.config.appearance),
                  std::move(seen->neighbours)};
}

Result<std::vector<loop::KeyframeRegistration>> RegisterLoops(
    const StageContext& context,
    const RunInputs& inputs,
    const std::vector<AppearanceLoop>& proposed) {
  std::vector<KeyframePair> pairs;
  for (const AppearanceLoop& loop : proposed)
    pairs.push_back({loop.old_keyframe, loop.new_keyframe, loop.old_from_new});
  // What images proposed, images confirm, also where tracking goes by depth alone.
  alignment::AlignmentOptions options = inputs.config.track.alignment;
  options.photometric = true;
  PairAlignment alignment;
  alignment.align = [&](const auto& older, const auto& newer, const Pose3& start) {
    const auto found = alignment::AlignPyramids(older, newer, {&start, 1}, options);
    return alignment::Sharpened(found, older, newer, options);
  };
  alignment.without = "not measured against others that look alike";
  constexpr std::size_t kMostPyramids = 32;
  KeyframePyramids pyramids(*inputs.capture->frames, options.pyramid, kMostPyramids);
  return RegisterPairs(pyramids, pairs, alignment, context.progress());
}

struct ByAppearance {
  loop::AcceptedAppearance loops;
  std::vector<RelativePose> neighbours;  // measured again
};

Result<ByAppearance> MeasureByAppearance(const StageContext& context,
                                         const RunInputs& inputs,
                                         const Odometry& odometry) {
  const loop::AppearanceOptions& options = inputs.config.appearance;
  const Result<Proposed> proposed = Propose(context, inputs, odometry);
  if (!proposed.ok()) return proposed.error();
  const auto loops = RegisterLoops(context, inputs, proposed->loops);
  if (!loops.ok()) return loops.error();
  const auto neighbours = RegisterLoops(context, inputs, proposed->neighbours);
  if (!neighbours.ok()) return neighbours.error();
  return ByAppearance{loop::AcceptAppearanceLoops(proposed->loops, *loops, odometry, options),
                      loop::AcceptNeighbours(proposed->neighbours, *neighbours, options)};
}

int CountKept(const std::vector<RelativePose>& of, const std::vector<RelativePose>& edges) {
  return static_cast<int>(std::count_if(of.begin(), of.end(), [&](const RelativePose& edge) {
    return std::any_of(edges.begin(), edges.end(), [&](const RelativePose& kept) {
      return kept.i == edge.i && kept.j == edge.j;
    });
  }));
}

}  // namespace

Result<ClosedTrajectory> CloseByAppearance(const StageContext& context,
                                           const RunInputs& inputs,
                                           const Odometry& odometry,
                                           const Ground& ground) {
  ClosedTrajectory closed{odometry.frames, ground, {}, 0};
  const loop::AppearanceOptions& options = inputs.config.appearance;
  if (!inputs.config.loops.enabled || !options.enabled) return closed;
  Result<ByAppearance> measured = MeasureByAppearance(context, inputs, odometry);
  if (!measured.ok()) return measured.error();
  const std::vector<RelativePose>& neighbours = measured->neighbours;
  closed.appearance = std::move(measured->loops);
  std::vector<RelativePose>& edges = closed.appearance.edges;
  edges.insert(edges.end(), neighbours.begin(), neighbours.end());
  while (!edges.empty()) {
    Result<SolvedPath> solved = SolvePath(odometry, ground, edges, inputs.config.optimize);
    if (!solved.ok()) return solved.error();
    Trajectory path{std::move(solved->frames), odometry.keyframes};
    if (loop::RefuseContradicted(path, options, closed.appearance)) continue;
    closed.frames = std::move(path.frames);
    closed.ground = std::move(solved->ground);
    closed.num_measured_again = CountKept(neighbours, edges);
    break;
  }
  return closed;
}

}  // namespace deepslam::stages
