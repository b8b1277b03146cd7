#include "deepslam/stages/refine_path.h"

#include <malloc.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/covisible.h"
#include "deepslam/odometry/frame_alignment.h"
#include "deepslam/odometry/image_pyramid.h"
#include "deepslam/stages/keyframe_graph.h"
#include "deepslam/stages/keyframe_pyramids.h"

namespace deepslam::stages {
namespace {

using loop::CovisiblePair;
using odometry::FramePyramid;

constexpr std::size_t kBatch = 8;  // keyframes whose pyramids are made at a time

// The keyframes of these pairs, each once.
std::vector<FrameIdx> KeyframesOf(std::span<const CovisiblePair> pairs, const Odometry& odometry) {
  std::set<FrameIdx> keyframes;
  for (const CovisiblePair& pair : pairs) {
    for (const int k : {pair.older, pair.newer})
      keyframes.insert(odometry.keyframes[static_cast<std::size_t>(k)]);
  }
  return {keyframes.begin(), keyframes.end()};
}

loop::KeyframeRegistration Register(const FramePyramid& older,
                                    const FramePyramid& newer,
                                    const Pose3& older_from_newer,
                                    const odometry::AlignmentOptions& options) {
  const odometry::FrameAlignment found =
      odometry::RefineAlignment(older, newer, older_from_newer, options);
  return {
      found.ok, found.i_from_j, found.information, found.agreement, found.brightness_correlation};
}

std::vector<loop::KeyframeRegistration> RegisterAll(const RunInputs& inputs,
                                                    const Odometry& odometry,
                                                    std::span<const CovisiblePair> pairs,
                                                    Progress& progress) {
  const odometry::AlignmentOptions& alignment = inputs.config.track.alignment;
  // Pairs reach back by so many keyframes: what goes out of reach is given up.
  const auto reach = static_cast<std::size_t>(inputs.config.covisible.max_gap_keyframes);
  KeyframePyramids pyramids(*inputs.capture->frames, alignment.pyramid, reach + kBatch);
  const auto of = [&](int k) -> const FramePyramid& {
    return pyramids[odometry.keyframes[static_cast<std::size_t>(k)]];
  };
  std::vector<loop::KeyframeRegistration> registrations(pairs.size());
  std::size_t done = 0;
  for (std::size_t end = kBatch; done < pairs.size(); end += kBatch) {
    if (progress.StopRequested()) break;
    const auto is_later = [&](const CovisiblePair& pair) {
      return pair.newer >= static_cast<int>(end);
    };
    const auto later =
        std::find_if(pairs.begin() + static_cast<std::ptrdiff_t>(done), pairs.end(), is_later);
    const auto next = static_cast<std::size_t>(later - pairs.begin());
    const std::span<const CovisiblePair> batch = pairs.subspan(done, next - done);
    for (const std::string& fault : pyramids.Hold(KeyframesOf(batch, odometry)))
      progress.Warn("not measured against others that see the same: " + fault);
    ParallelFor(batch.size(), [&](std::size_t n) {
      registrations[done + n] =
          Register(of(batch[n].older), of(batch[n].newer), batch[n].older_from_newer, alignment);
    });
    done = next;
  }
  return registrations;
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
std::vector<RelativePose> MeasureCovisible(const RunInputs& inputs,
                                           const Odometry& odometry,
                                           Progress& progress) {
  const loop::CovisibleOptions& options = inputs.config.covisible;
  const std::vector<CovisiblePair> pairs = loop::ProposeCovisible(odometry, options);
  const auto registrations = RegisterAll(inputs, odometry, pairs, progress);
  return loop::AcceptCovisible(pairs, registrations, odometry, options);
}

}  // namespace

Result<int> RefinePath(const RunInputs& inputs, Progress& progress, Odometry& odometry) {
  const loop::CovisibleOptions& options = inputs.config.covisible;
  if (!options.enabled) return 0;
  const auto num_tracked = static_cast<std::ptrdiff_t>(odometry.edges.size());
  std::ranges::move(MeasureCovisible(inputs, odometry, progress),
                    std::back_inserter(odometry.edges));
  ::malloc_trim(0);  // the pyramids' memory
  if (progress.StopRequested()) return Interrupted();
  const auto begin = [&] { return odometry.edges.begin() + num_tracked; };
  if (begin() == odometry.edges.end()) return 0;
  // The options of `optimize` are that stage's own: they must not change what tracking is.
  graph::GraphOptions robust;
  robust.odometry_loss = "cauchy";
  Result<std::vector<TrackedFrame>> solved =
      SolveStretches(odometry, robust, StretchesFor(inputs.config));
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
