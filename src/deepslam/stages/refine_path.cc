#include "deepslam/stages/refine_path.h"

#include <malloc.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/covisible.h"
#include "deepslam/odometry/frame_alignment.h"
#include "deepslam/odometry/image_pyramid.h"
#include "deepslam/odometry/read_pyramid.h"
#include "deepslam/stages/keyframe_graph.h"

namespace deepslam::stages {
namespace {

using loop::CovisiblePair;
using odometry::FramePyramid;

constexpr std::size_t kBatch = 8;  // keyframes whose pyramids (3 MB each) are made at a time

// Pyramids of the keyframes that pairs ask for, by position; made and given up as the pairs go on.
class KeyframePyramids {
 public:
  KeyframePyramids(const RunInputs& inputs,
                   const Odometry& odometry,
                   std::span<const CovisiblePair> pairs)
      : frames_(*inputs.capture->frames),
        options_(inputs.config.track.alignment.pyramid),
        keyframes_(odometry.keyframes),
        pyramids_(keyframes_.size()),
        last_use_(keyframes_.size(), -1) {
    for (const CovisiblePair& pair : pairs) {
      for (const int k : {pair.older, pair.newer}) {
        int& last = last_use_[static_cast<std::size_t>(k)];
        last = std::max(last, pair.newer);
      }
    }
  }

  void Make(std::size_t begin, std::size_t end, Progress& progress) {
    std::vector<std::string> faults(end - begin);
    ParallelFor(end - begin, [&](std::size_t n) {
      const std::size_t k = begin + n;
      if (last_use_[k] < 0) return;
      Result<FramePyramid> pyramid = odometry::ReadPyramid(frames_, keyframes_[k], options_);
      if (pyramid.ok()) {
        pyramids_[k] = std::move(pyramid).value();
      } else {
        faults[n] = pyramid.error().message;
      }
    });
    for (std::size_t n = 0; n < faults.size(); ++n) {
      if (faults[n].empty()) continue;
      progress.Warn(fmt::format("frame {} is not measured against others that see the same: {}",
                                keyframes_[begin + n].value,
                                faults[n]));
    }
  }

  void GiveUpBefore(std::size_t newer) {
    for (std::size_t k = 0; k < newer; ++k) {
      if (last_use_[k] < static_cast<int>(newer)) pyramids_[k] = {};
    }
  }

  const FramePyramid& operator[](int k) const { return pyramids_[static_cast<std::size_t>(k)]; }

 private:
  const FrameSource& frames_;
  const odometry::PyramidOptions& options_;
  const std::vector<FrameIdx>& keyframes_;
  std::vector<FramePyramid> pyramids_;
  std::vector<int> last_use_;  // as the newer keyframe of a pair; -1 without a pair
};

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
  KeyframePyramids pyramids(inputs, odometry, pairs);
  std::vector<loop::KeyframeRegistration> registrations(pairs.size());
  std::size_t done = 0;
  for (std::size_t begin = 0; done < pairs.size(); begin += kBatch) {
    if (progress.StopRequested()) break;
    const std::size_t end = std::min(begin + kBatch, odometry.keyframes.size());
    pyramids.Make(begin, end, progress);
    const auto is_later = [&](const CovisiblePair& pair) {
      return pair.newer >= static_cast<int>(end);
    };
    const auto later =
        std::find_if(pairs.begin() + static_cast<std::ptrdiff_t>(done), pairs.end(), is_later);
    const auto next = static_cast<std::size_t>(later - pairs.begin());
    ParallelFor(next - done, [&](std::size_t n) {
      const CovisiblePair& pair = pairs[done + n];
      registrations[done + n] = Register(pyramids[pair.older],
                                         pyramids[pair.newer],
                                         pair.older_from_newer,
                                         inputs.config.track.alignment);
    });
    done = next;
    pyramids.GiveUpBefore(end);
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
