#include "deepslam/mapping/refine_path.h"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/core/freed_memory.h"
#include "deepslam/mapping/register_pairs.h"
#include "deepslam/mapping/sub_trajectories.h"

namespace deepslam::mapping {
namespace {

using loop::CovisiblePair;
using SharedEdges = std::shared_ptr<const EdgeStore>;

// Of eight keyframes: each has at most twelve pairs (CovisibleOptions::max_pairs).
constexpr std::size_t kPairsAtOnce = 96;

std::vector<KeyframePair> PairsOfKeyframes(std::span<const CovisiblePair> proposed,
                                           const Trajectory& trajectory) {
  const auto keyframe = [&](int k) { return trajectory.keyframes[static_cast<std::size_t>(k)]; };
  std::vector<KeyframePair> pairs;
  for (const CovisiblePair& pair : proposed)
    pairs.push_back({keyframe(pair.older), keyframe(pair.newer), pair.older_from_newer});
  return pairs;
}

// No edge is longer than what sub-trajectories share: a dropped one would be a tie that is lost.
SubTrajectorySizes SizesFor(const RefinementOptions& options) {
  SubTrajectorySizes sizes;
  sizes.overlap = std::max(
      {sizes.overlap, 2 * options.covisible.max_gap_keyframes, options.most_keyframes_back});
  sizes.num_keyframes = std::max(sizes.num_keyframes, 4 * sizes.overlap);
  return sizes;
}

// Edges between keyframes that see the same and that tracking has not joined, ascending by the
// newer one. They are the largest part of a long path.
Result<SharedEdges> MeasureCovisible(const Odometry& tracked,
                                     KeyframePyramids pyramids,
                                     const RefinementOptions& options,
                                     const std::shared_ptr<EdgeStore>& edges,
                                     Progress& progress) {
  PairAlignment alignment;
  alignment.align = [&](const auto& older, const auto& newer, const Pose3& start) {
    return alignment::RefineAlignment(older, newer, start, options.alignment);
  };
  alignment.pairs_at_once = kPairsAtOnce;
  alignment.without = "not registered to others that see the same";
  loop::CovisiblePairs pairs(tracked, options.covisible);
  while (true) {
    const std::vector<CovisiblePair> batch = pairs.Next(kPairsAtOnce);
    if (batch.empty()) return SharedEdges(edges);
    const auto registrations =
        RegisterPairs(pyramids, PairsOfKeyframes(batch, tracked), alignment, progress);
    if (!registrations.ok()) return registrations.error();
    const std::vector<RelativePose> accepted =
        loop::AcceptCovisible(batch, *registrations, tracked);
    if (Status added = AddAll(accepted, *edges); !added.ok()) return added.error();
  }
}

// Those that the solved path does not contradict.
Result<SharedEdges> ConsistentOf(const EdgeStore& edges,
                                 const Trajectory& solved,
                                 const std::shared_ptr<EdgeStore>& consistent) {
  Status added = Ok();
  ForEach(edges, [&](const RelativePose& edge) {
    if (added.ok() && loop::IsConsistent(edge, solved)) added = consistent->Add(edge);
  });
  if (!added.ok()) return added.error();
  return SharedEdges(consistent);
}

// The options of the final optimisation are no part of it: a change there must not change what
// tracking is.
Result<std::vector<TrackedFrame>> Solve(const Odometry& odometry,
                                        const RefinementOptions& options) {
  const SubTrajectorySizes sizes = SizesFor(options);
  graph::GraphOptions robust;
  robust.odometry_loss = "cauchy";
  robust.max_direct_keyframes = sizes.num_keyframes;  // without loops the factor stays sparse
  robust.max_keyframes = sizes.num_keyframes;
  return SolveSubTrajectories(odometry, robust, sizes);
}

}  // namespace

KeyframePyramids PyramidsToRefine(const FrameSource& frames, const RefinementOptions& options) {
  // Pairs reach back by so many keyframes, and a few are registered at once.
  const auto most = static_cast<std::size_t>(options.covisible.max_gap_keyframes) + 8;
  return {frames, options.alignment.pyramid, most};
}

Result<Odometry> RefinePath(Odometry tracked,
                            KeyframePyramids pyramids,
                            const RefinementOptions& options,
                            const EdgeStoreFactory& new_store,
                            Progress& progress) {
  if (!options.covisible.enabled && !options.has_other_edges) return tracked;
  auto measured =
      options.covisible.enabled
          ? MeasureCovisible(tracked, std::move(pyramids), options, new_store(), progress)
          : Result<SharedEdges>(SharedEdges(new_store()));
  ReturnFreedMemory(kMostHeldBytes);  // the pyramids'
  if (!measured.ok()) return measured.error();
  if (progress.StopRequested()) return Interrupted();
  if ((*measured)->size() == 0 && !options.has_other_edges) return tracked;
  Odometry refined = std::move(tracked);
  refined.more_edges = *measured;
  Result<std::vector<TrackedFrame>> solved = Solve(refined, options);
  refined.more_edges = nullptr;
  if (!solved.ok()) {
    progress.Warn("the path stays as tracked: " + solved.error().message);
    return refined;
  }
  refined.frames = std::move(solved).value();
  auto consistent = ConsistentOf(**measured, refined, new_store());
  if (!consistent.ok()) return consistent.error();
  refined.more_edges = std::move(consistent).value();
  return refined;
}

}  // namespace deepslam::mapping
