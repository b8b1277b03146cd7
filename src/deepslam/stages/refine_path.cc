#include "deepslam/stages/refine_path.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/core/freed_memory.h"
#include "deepslam/loop/covisible.h"
#include "deepslam/odometry/frame_alignment.h"
#include "deepslam/stages/keyframe_graph.h"
#include "deepslam/stages/register_pairs.h"

namespace deepslam::stages {
namespace {

using loop::CovisiblePair;

constexpr std::size_t kPairsAtOnce = 96;  // of eight keyframes

Result<std::vector<loop::KeyframeRegistration>> RegisterAll(const RunInputs& inputs,
                                                            KeyframePyramids pyramids,
                                                            const Odometry& odometry,
                                                            std::span<const CovisiblePair> proposed,
                                                            Progress& progress) {
  const auto keyframe = [&](int k) { return odometry.keyframes[static_cast<std::size_t>(k)]; };
  std::vector<KeyframePair> pairs;
  for (const CovisiblePair& pair : proposed)
    pairs.push_back({keyframe(pair.older), keyframe(pair.newer), pair.older_from_newer});
  const odometry::AlignmentOptions& options = inputs.config.track.alignment;
  PairAlignment alignment;
  alignment.align = [&](const auto& older, const auto& newer, const Pose3& start) {
    return odometry::RefineAlignment(older, newer, start, options);
  };
  alignment.pairs_at_once = kPairsAtOnce;
  alignment.without = "not measured against others that see the same";
  return RegisterPairs(pyramids, pairs, alignment, progress);
}

// No edge is longer than what stretches share: a dropped one would be a tie that is lost.
Stretches StretchesFor(const Config& config) {
  Stretches stretches;
  stretches.overlap = std::max({stretches.overlap,
                                2 * config.covisible.max_gap_keyframes,
                                config.track.num_relocalisation_keyframes});
  stretches.num_keyframes = std::max(stretches.num_keyframes, 4 * stretches.overlap);
  return stretches;
}

// Edges that tracking has not: of keyframes that see the same.
Result<std::vector<RelativePose>> MeasureCovisible(const RunInputs& inputs,
                                                   KeyframePyramids pyramids,
                                                   const Odometry& odometry,
                                                   Progress& progress) {
  const loop::CovisibleOptions& options = inputs.config.covisible;
  const std::vector<CovisiblePair> pairs = loop::ProposeCovisible(odometry, options);
  const auto registrations = RegisterAll(inputs, std::move(pyramids), odometry, pairs, progress);
  if (!registrations.ok()) return registrations.error();
  return loop::AcceptCovisible(pairs, *registrations, odometry, options);
}

}  // namespace

KeyframePyramids PyramidsToRefine(const RunInputs& inputs) {
  // Pairs reach back by so many keyframes, and a few are registered at once.
  const auto most = static_cast<std::size_t>(inputs.config.covisible.max_gap_keyframes) + 8;
  return {*inputs.capture->frames, inputs.config.track.alignment.pyramid, most};
}

Result<int> RefinePath(const RunInputs& inputs,
                       KeyframePyramids pyramids,
                       Progress& progress,
                       Odometry& odometry) {
  const loop::CovisibleOptions& options = inputs.config.covisible;
  if (!options.enabled) return 0;
  const auto num_tracked = static_cast<std::ptrdiff_t>(odometry.edges.size());
  Result<std::vector<RelativePose>> covisible =
      MeasureCovisible(inputs, std::move(pyramids), odometry, progress);
  ReturnFreedMemory(kMostHeldBytes);  // the pyramids'
  if (!covisible.ok()) return covisible.error();
  std::ranges::move(*covisible, std::back_inserter(odometry.edges));
  if (progress.StopRequested()) return Interrupted();
  const auto begin = [&] { return odometry.edges.begin() + num_tracked; };
  if (begin() == odometry.edges.end()) return 0;
  // The options of `optimize` are that stage's own: they must not change what tracking is.
  graph::GraphOptions robust;
  robust.odometry_loss = "cauchy";
  const Stretches stretches = StretchesFor(inputs.config);
  robust.max_direct_keyframes = stretches.num_keyframes;  // without loops the factor stays sparse
  Result<std::vector<TrackedFrame>> solved = SolveStretches(odometry, robust, stretches);
  std::vector<RelativePose> measured(begin(), odometry.edges.end());
  odometry.edges.erase(begin(), odometry.edges.end());
  if (!solved.ok()) {
    progress.Warn("the path stays as tracked: " + solved.error().message);
    return 0;
  }
  odometry.frames = std::move(solved).value();
  measured = loop::Consistent(std::move(measured), odometry, options);
  odometry.edges.insert(odometry.edges.end(), measured.begin(), measured.end());
  return static_cast<int>(measured.size());
}

}  // namespace deepslam::stages
