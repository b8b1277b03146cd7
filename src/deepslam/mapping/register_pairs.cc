#include "deepslam/mapping/register_pairs.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"

namespace deepslam::mapping {
namespace {

std::vector<FrameIdx> KeyframesOf(std::span<const KeyframePair> pairs) {
  std::vector<FrameIdx> keyframes;
  for (const KeyframePair& pair : pairs) {
    keyframes.push_back(pair.older);
    keyframes.push_back(pair.newer);
  }
  return keyframes;
}

loop::KeyframeRegistration RegistrationOf(const alignment::FrameAlignment& found) {
  return {
      found.ok, found.i_from_j, found.information, found.inlier_ratio, found.intensity_correlation};
}

}  // namespace

Result<std::vector<loop::KeyframeRegistration>> RegisterPairs(KeyframePyramids& pyramids,
                                                              std::span<const KeyframePair> pairs,
                                                              const PairAlignment& alignment,
                                                              Progress& progress) {
  std::vector<loop::KeyframeRegistration> registrations(pairs.size());
  for (std::size_t begin = 0; begin < pairs.size(); begin += alignment.pairs_at_once) {
    if (progress.StopRequested()) return Interrupted();
    const auto batch =
        pairs.subspan(begin, std::min(alignment.pairs_at_once, pairs.size() - begin));
    for (const std::string& fault : pyramids.Hold(KeyframesOf(batch)))
      progress.Warn(fmt::format("{}: {}", alignment.without, fault));
    ParallelFor(batch.size(), [&](std::size_t n) {
      const KeyframePair& pair = batch[n];
      registrations[begin + n] = RegistrationOf(
          alignment.align(pyramids[pair.older], pyramids[pair.newer], pair.older_from_newer));
    });
  }
  return registrations;
}

}  // namespace deepslam::mapping
