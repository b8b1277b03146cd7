#include "deepslam/mapping/close_by_appearance.h"

#include <algorithm>
#include <utility>

#include "deepslam/loop/neighbours.h"
#include "deepslam/mapping/keyframe_graph.h"
#include "deepslam/mapping/propose_by_appearance.h"
#include "deepslam/mapping/register_pairs.h"

namespace deepslam::mapping {
namespace {

using Registrations = std::vector<loop::KeyframeRegistration>;

Result<Registrations> Register(const std::vector<AppearanceLoop>& proposed,
                               const FrameSource& frames,
                               const alignment::AlignmentOptions& tracking_options,
                               Progress& progress) {
  std::vector<KeyframePair> pairs;
  for (const AppearanceLoop& loop : proposed)
    pairs.push_back({loop.old_keyframe, loop.new_keyframe, loop.old_from_new});
  // What images proposed, images confirm, also where tracking goes by depth alone.
  alignment::AlignmentOptions options = tracking_options;
  options.photometric = true;
  PairAlignment alignment;
  alignment.align = [&](const auto& older, const auto& newer, const Pose3& start) {
    const auto found = alignment::AlignPyramids(older, newer, {&start, 1}, options);
    return alignment::Sharpened(found, older, newer, options);
  };
  alignment.without = "not registered to others that look alike";
  constexpr std::size_t kMostPyramids = 32;  // 128 MB at 4 MB each
  KeyframePyramids pyramids(frames, options.pyramid, kMostPyramids);
  return RegisterPairs(pyramids, pairs, alignment, progress);
}

struct MeasuredByAppearance {
  loop::AcceptedAppearance loops;
  std::vector<RelativePose> adjacent;
};

Result<MeasuredByAppearance> Measure(const FrameSource& frames,
                                     const Odometry& odometry,
                                     const AppearanceClosing& options,
                                     Progress& progress) {
  const Result<AppearanceProposals> proposed =
      ProposeByAppearance(frames, odometry, options.by_depth_alone, options.appearance, progress);
  if (!proposed.ok()) return proposed.error();
  const auto loops = Register(proposed->loops, frames, options.alignment, progress);
  if (!loops.ok()) return loops.error();
  const auto adjacent = Register(proposed->adjacent, frames, options.alignment, progress);
  if (!adjacent.ok()) return adjacent.error();
  return MeasuredByAppearance{
      loop::AcceptAppearanceLoops(proposed->loops, *loops, odometry, options.appearance),
      loop::AcceptNeighbours(proposed->adjacent, *adjacent)};
}

int CountKept(const std::vector<RelativePose>& of, const std::vector<RelativePose>& edges) {
  return static_cast<int>(std::ranges::count_if(of, [&](const RelativePose& edge) {
    return std::ranges::any_of(
        edges, [&](const RelativePose& kept) { return kept.i == edge.i && kept.j == edge.j; });
  }));
}

}  // namespace

Result<ClosedTrajectory> CloseByAppearance(const FrameSource& frames,
                                           const Odometry& odometry,
                                           const Ground& ground,
                                           const AppearanceClosing& options,
                                           Progress& progress) {
  ClosedTrajectory closed{odometry.frames, ground, {}, 0};
  if (!options.appearance.enabled) return closed;
  Result<MeasuredByAppearance> measured = Measure(frames, odometry, options, progress);
  if (!measured.ok()) return measured.error();
  const std::vector<RelativePose>& adjacent = measured->adjacent;
  closed.appearance = std::move(measured->loops);
  std::vector<RelativePose>& edges = closed.appearance.edges;
  edges.insert(edges.end(), adjacent.begin(), adjacent.end());
  while (!edges.empty()) {
    Result<SolvedPath> solved = SolvePath(odometry, ground, edges, options.graph);
    if (!solved.ok()) return solved.error();
    Trajectory path{std::move(solved->frames), odometry.keyframes};
    if (loop::RefuseContradicted(path, options.appearance, closed.appearance)) continue;
    closed.frames = std::move(path.frames);
    closed.ground = std::move(solved->ground);
    closed.num_reregistered = CountKept(adjacent, edges);
    break;
  }
  return closed;
}

}  // namespace deepslam::mapping
