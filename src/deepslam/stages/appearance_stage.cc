#include "deepslam/stages/appearance_stage.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/neighbours.h"
#include "deepslam/odometry/frame_alignment.h"
#include "deepslam/stages/keyframe_graph.h"
#include "deepslam/stages/register_pairs.h"
#include "deepslam/stages/stage_inputs.h"

namespace deepslam::stages {
namespace {

using pipeline::StageContext;

constexpr std::size_t kBatch = 32;  // keyframes looked at side by side

Result<std::vector<loop::KeyframeFeatures>> Extract(const StageContext& context,
                                                    const RunInputs& inputs,
                                                    std::span<const FrameIdx> keyframes) {
  if (context.progress().StopRequested()) return Interrupted();
  const FrameSource& frames = *inputs.capture->frames;
  std::vector<loop::KeyframeFeatures> features(keyframes.size());
  std::vector<std::string> faults(keyframes.size());
  ParallelFor(keyframes.size(), [&](std::size_t k) {
    features[k].keyframe = keyframes[k];
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
std::span<const loop::NeighbourPair> PairsUpTo(std::span<const loop::NeighbourPair> pairs,
                                               int begin,
                                               int end) {
  const auto first = std::ranges::lower_bound(pairs, begin, {}, &loop::NeighbourPair::newer);
  const auto last = std::ranges::lower_bound(pairs, end, {}, &loop::NeighbourPair::newer);
  return {first, last};
}

struct Seen {
  std::vector<loop::KeyframeFeatures> features;  // of at most max_keyframes, evenly along the path
  std::vector<AppearanceLoop> neighbours;        // proposed; in the order of the older keyframes
};

// Goes along the path once. Neighbours are compared while the features of both are at hand.
Result<Seen> LookAtKeyframes(const StageContext& context,
                             const RunInputs& inputs,
                             const Odometry& odometry) {
  const loop::AppearanceOptions& options = inputs.config.appearance;
  const bool depth_alone =
      inputs.config.track_stage.poses != "capture" && !inputs.config.track.alignment.photometric;
  const std::vector<loop::NeighbourPair> pairs = loop::PoorlyMeasured(odometry, depth_alone);
  const std::span<const FrameIdx> keyframes = odometry.keyframes;
  const auto most = static_cast<std::size_t>(options.max_keyframes);
  const std::size_t step = (keyframes.size() + most - 1) / most;
  Seen seen;
  std::vector<loop::KeyframeFeatures> run;  // the batch, behind the last ones before it
  for (std::size_t begin = 0; begin < keyframes.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, keyframes.size() - begin);
    Result<std::vector<loop::KeyframeFeatures>> batch =
        Extract(context, inputs, keyframes.subspan(begin, count));
    if (!batch.ok()) return batch.error();
    if (run.size() > loop::kMostNeighbourGap)
      run.erase(run.begin(), run.end() - loop::kMostNeighbourGap);
    const auto first = static_cast<int>(begin - run.size());
    std::ranges::move(*batch, std::back_inserter(run));
    const auto own = PairsUpTo(pairs, static_cast<int>(begin), static_cast<int>(begin + count));
    std::ranges::move(loop::ProposeNeighbours(own, run, first, options),
                      std::back_inserter(seen.neighbours));
    for (std::size_t k = 0; k < count; ++k) {
      if ((begin + k) % step == 0) seen.features.push_back(run[run.size() - count + k]);
    }
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
  return Proposed{loop::ProposeAppearanceLoops(seen->features, odometry, inputs.config.appearance),
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
  odometry::AlignmentOptions options = inputs.config.track.alignment;
  options.photometric = true;
  PairAlignment alignment;
  alignment.align = [&](const auto& older, const auto& newer, const Pose3& start) {
    return odometry::AlignPyramids(older, newer, {&start, 1}, options);
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
    const Trajectory path{std::move(solved->frames), odometry.keyframes};
    if (loop::RefuseContradicted(path, options, closed.appearance)) continue;
    closed.frames = path.frames;
    closed.ground = std::move(solved->ground);
    closed.num_measured_again = CountKept(neighbours, edges);
    break;
  }
  return closed;
}

}  // namespace deepslam::stages
