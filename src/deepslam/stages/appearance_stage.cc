#include "deepslam/stages/appearance_stage.h"

#include <algorithm>
#include <span>
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

constexpr std::size_t kBatch = 32;  // frames in work at a time

Result<std::vector<loop::KeyframeFeatures>> ExtractAll(const StageContext& context,
                                                       const RunInputs& inputs,
                                                       const Odometry& odometry) {
  const FrameSource& frames = *inputs.capture->frames;
  const std::vector<FrameIdx>& keyframes = odometry.keyframes;
  std::vector<loop::KeyframeFeatures> features(keyframes.size());
  std::vector<std::string> faults(keyframes.size());
  for (std::size_t begin = 0; begin < keyframes.size(); begin += kBatch) {
    if (context.progress().StopRequested()) return Interrupted();
    const std::size_t count = std::min(kBatch, keyframes.size() - begin);
    ParallelFor(count, [&](std::size_t n) {
      const std::size_t k = begin + n;
      features[k].keyframe = keyframes[k];
      const Result<Frame> frame = frames.Read(keyframes[k]);
      if (frame.ok()) {
        features[k] =
            loop::ExtractFeatures(*frame, frames.camera(), inputs.config.appearance.max_features);
      } else {
        faults[k] = frame.error().message;
      }
    });
    context.progress().Report(begin + count, keyframes.size());
  }
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    if (faults[k].empty()) continue;
    context.progress().Warn(
        fmt::format("frame {} is not looked at for loops: {}", keyframes[k].value, faults[k]));
  }
  return features;
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

Result<loop::AcceptedAppearance> FindLoops(const StageContext& context,
                                           const RunInputs& inputs,
                                           const Odometry& odometry,
                                           std::span<const loop::KeyframeFeatures> features) {
  const loop::AppearanceOptions& options = inputs.config.appearance;
  const std::vector<AppearanceLoop> proposed =
      loop::ProposeAppearanceLoops(features, odometry, options);
  const auto registrations = RegisterLoops(context, inputs, proposed);
  if (!registrations.ok()) return registrations.error();
  return loop::AcceptAppearanceLoops(proposed, *registrations, odometry, options);
}

Result<std::vector<RelativePose>> MeasureAgain(const StageContext& context,
                                               const RunInputs& inputs,
                                               const Odometry& odometry,
                                               std::span<const loop::KeyframeFeatures> features) {
  const loop::AppearanceOptions& options = inputs.config.appearance;
  const bool depth_alone =
      inputs.config.track_stage.poses != "capture" && !inputs.config.track.alignment.photometric;
  const std::vector<AppearanceLoop> proposed =
      loop::ProposeNeighbours(features, odometry, depth_alone, options);
  const auto registrations = RegisterLoops(context, inputs, proposed);
  if (!registrations.ok()) return registrations.error();
  return loop::AcceptNeighbours(proposed, *registrations, options);
}

struct ByAppearance {
  loop::AcceptedAppearance loops;
  std::vector<RelativePose> neighbours;  // measured again
};

// Features of all keyframes, the largest of what is held here, are gone when the graph is solved.
Result<ByAppearance> MeasureByAppearance(const StageContext& context,
                                         const RunInputs& inputs,
                                         const Odometry& odometry) {
  const Result<std::vector<loop::KeyframeFeatures>> features =
      ExtractAll(context, inputs, odometry);
  if (!features.ok()) return features.error();
  Result<loop::AcceptedAppearance> loops = FindLoops(context, inputs, odometry, *features);
  if (!loops.ok()) return loops.error();
  Result<std::vector<RelativePose>> neighbours = MeasureAgain(context, inputs, odometry, *features);
  if (!neighbours.ok()) return neighbours.error();
  return ByAppearance{std::move(loops).value(), std::move(neighbours).value()};
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
  ClosedTrajectory closed{odometry, ground, {}, 0};
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
    closed.odometry.frames = std::move(solved->frames);
    closed.ground = std::move(solved->ground);
    if (loop::RefuseContradicted(closed.odometry, options, closed.appearance)) continue;
    closed.num_measured_again = CountKept(neighbours, edges);
    return closed;
  }
  closed.odometry = odometry;
  closed.ground = ground;
  return closed;
}

}  // namespace deepslam::stages
