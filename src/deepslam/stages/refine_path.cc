#include "deepslam/stages/refine_path.h"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/alignment/frame_alignment.h"
#include "deepslam/core/freed_memory.h"
#include "deepslam/loop/covisible.h"
#include "deepslam/stages/keyframe_graph.h"
#include "deepslam/stages/register_pairs.h"
#include "deepslam/stages/shelf_of_edges.h"

namespace deepslam::stages {
namespace {

using loop::CovisiblePair;
using pipeline::StageContext;
using SharedEdges = std::shared_ptr<const ShelvedEdges>;

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

// The edges that tracking has not: of keyframes that see the same, ascending by the newer one. They
// are the largest part of a long path.
Result<SharedEdges> MeasureCovisible(const StageContext& context,
                                     const RunInputs& inputs,
                                     KeyframePyramids pyramids,
                                     const Odometry& odometry) {
  const alignment::AlignmentOptions& options = inputs.config.track.alignment;
  PairAlignment alignment;
  alignment.align = [&](const auto& older, const auto& newer, const Pose3& start) {
    return alignment::RefineAlignment(older, newer, start, options);
  };
  alignment.pairs_at_once = kPairsAtOnce;
  alignment.without = "not measured against others that see the same";
  const auto edges = std::make_shared<ShelfOfEdges>(context.Scratch());
  loop::CovisiblePairs pairs(odometry, inputs.config.covisible);
  while (true) {
    const std::vector<CovisiblePair> batch = pairs.Next(kPairsAtOnce);
    if (batch.empty()) return SharedEdges(edges);
    const auto registrations =
        RegisterPairs(pyramids, PairsOfKeyframes(batch, odometry), alignment, context.progress());
    if (!registrations.ok()) return registrations.error();
    const Status added =
        edges->Add(loop::AcceptCovisible(batch, *registrations, odometry, inputs.config.covisible));
    if (!added.ok()) return added.error();
  }
}

// Those that the solved path does not contradict.
Result<SharedEdges> ConsistentOf(const StageContext& context,
                                 const ShelvedEdges& edges,
                                 const Trajectory& solved,
                                 const loop::CovisibleOptions& options) {
  const auto consistent = std::make_shared<ShelfOfEdges>(context.Scratch());
  Status added = Ok();
  ForEach(edges, [&](const RelativePose& edge) {
    if (added.ok() && loop::IsConsistent(edge, solved, options)) added = consistent->Add(edge);
  });
  if (!added.ok()) return added.error();
  return SharedEdges(consistent);
}

}  // namespace

KeyframePyramids PyramidsToRefine(const RunInputs& inputs) {
  // Pairs reach back by so many keyframes, and a few are registered at once.
  const auto most = static_cast<std::size_t>(inputs.config.covisible.max_gap_keyframes) + 8;
  return {*inputs.capture->frames, inputs.config.track.alignment.pyramid, most};
}

Status RefinePath(const StageContext& context,
                  const RunInputs& inputs,
                  KeyframePyramids pyramids,
                  Odometry& odometry) {
  const loop::CovisibleOptions& options = inputs.config.covisible;
  if (!options.enabled) return Ok();
  auto measured = MeasureCovisible(context, inputs, std::move(pyramids), odometry);
  ReturnFreedMemory(kMostHeldBytes);  // the pyramids'
  if (!measured.ok()) return measured.error();
  if (context.progress().StopRequested()) return Interrupted();
  if ((*measured)->size() == 0) return Ok();
  odometry.more_edges = *measured;
  // The options of `optimize` are that stage's own: they must not change what tracking is.
  graph::GraphOptions robust;
  robust.odometry_loss = "cauchy";
  const Stretches stretches = StretchesFor(inputs.config);
  robust.max_direct_keyframes = stretches.num_keyframes;  // without loops the factor stays sparse
  robust.max_keyframes = stretches.num_keyframes;
  Result<std::vector<TrackedFrame>> solved = SolveStretches(odometry, robust, stretches);
  odometry.more_edges = nullptr;
  if (!solved.ok()) {
    context.progress().Warn("the path stays as tracked: " + solved.error().message);
    return Ok();
  }
  odometry.frames = std::move(solved).value();
  auto consistent = ConsistentOf(context, **measured, odometry, options);
  if (!consistent.ok()) return consistent.error();
  odometry.more_edges = std::move(consistent).value();
  return Ok();
}

}  // namespace deepslam::stages
