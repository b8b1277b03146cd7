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

std::vector<KeyframePair> PairsOfKeyframes(std::span<const CovisiblePair> proposed,
                                           const Trajectory& trajectory) {
  const auto keyframe = [&](int k) { return trajectory.keyframes[static_cast<std::size_t>(k)]; };
  std::vector<KeyframePair> pairs;
  for (const CovisiblePair& pair : proposed)
    pairs.push_back({keyframe(pair.older), keyframe(pair.newer), pair.older_from_newer});
  return pairs;
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

// Adds the edges that tracking has not: of keyframes that see the same. They are the largest part
// of a long path, so they are held once.
Status MeasureCovisible(const RunInputs& inputs,
                        KeyframePyramids pyramids,
                        Progress& progress,
                        Odometry& odometry) {
  const odometry::AlignmentOptions& options = inputs.config.track.alignment;
  PairAlignment alignment;
  alignment.align = [&](const auto& older, const auto& newer, const Pose3& start) {
    return odometry::RefineAlignment(older, newer, start, options);
  };
  alignment.pairs_at_once = kPairsAtOnce;
  alignment.without = "not measured against others that see the same";
  const std::vector<CovisiblePair> pairs =
      loop::ProposeCovisible(odometry, inputs.config.covisible);
  odometry.edges.reserve(odometry.edges.size() + pairs.size());
  for (std::size_t begin = 0; begin < pairs.size(); begin += kPairsAtOnce) {
    const auto batch =
        std::span(pairs).subspan(begin, std::min(kPairsAtOnce, pairs.size() - begin));
    const auto registrations =
        RegisterPairs(pyramids, PairsOfKeyframes(batch, odometry), alignment, progress);
    if (!registrations.ok()) return registrations.error();
    std::ranges::move(
        loop::AcceptCovisible(batch, *registrations, odometry, inputs.config.covisible),
        std::back_inserter(odometry.edges));
  }
  return Ok();
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
  const Status measured = MeasureCovisible(inputs, std::move(pyramids), progress, odometry);
  ReturnFreedMemory(kMostHeldBytes);  // the pyramids'
  if (!measured.ok()) return measured.error();
  if (progress.StopRequested()) return Interrupted();
  const auto covisible = [&] { return odometry.edges.begin() + num_tracked; };
  if (covisible() == odometry.edges.end()) return 0;
  // The options of `optimize` are that stage's own: they must not change what tracking is.
  graph::GraphOptions robust;
  robust.odometry_loss = "cauchy";
  const Stretches stretches = StretchesFor(inputs.config);
  robust.max_direct_keyframes = stretches.num_keyframes;  // without loops the factor stays sparse
  robust.max_keyframes = stretches.num_keyframes;
  Result<std::vector<TrackedFrame>> solved = SolveStretches(odometry, robust, stretches);
  if (!solved.ok()) {
    odometry.edges.erase(covisible(), odometry.edges.end());
    progress.Warn("the path stays as tracked: " + solved.error().message);
    return 0;
  }
  odometry.frames = std::move(solved).value();
  const auto contradicted =
      std::remove_if(covisible(), odometry.edges.end(), [&](const RelativePose& edge) {
        return !loop::IsConsistent(edge, odometry, options);
      });
  odometry.edges.erase(contradicted, odometry.edges.end());
  return static_cast<int>(odometry.edges.end() - covisible());
}

}  // namespace deepslam::stages
