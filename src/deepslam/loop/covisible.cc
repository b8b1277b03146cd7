#include "deepslam/loop/covisible.h"

#include <algorithm>
#include <set>
#include <utility>

#include "deepslam/core/check.h"
#include "deepslam/loop/keyframe_path.h"
#include "deepslam/loop/registered_pair.h"

namespace deepslam::loop {
namespace {

std::set<std::pair<int, int>> Joined(const Odometry& odometry, const KeyframePath& path) {
  std::set<std::pair<int, int>> joined;
  odometry.ForEachEdge([&](const RelativePose& edge) {
    joined.insert(std::minmax(path.IndexOf(edge.i), path.IndexOf(edge.j)));
  });
  return joined;
}

bool BearsOut(const KeyframeRegistration& registration, const CovisiblePair& pair) {
  return Verdict(registration,
                 pair.older_from_newer,
                 {CovisibleOptions::kMinAgreement,
                  CovisibleOptions::kMinCorrelation,
                  CovisibleOptions::kMaxMove_m,
                  CovisibleOptions::kMaxMove_deg})
      .empty();
}

// At most `most` of them, evenly along the path.
void AppendSpread(const std::vector<CovisiblePair>& own,
                  std::size_t most,
                  std::vector<CovisiblePair>& pairs) {
  const std::size_t count = std::min(most, own.size());
  for (std::size_t k = 0; k < count; ++k)
    pairs.push_back(own[(2 * k + 1) * own.size() / (2 * count)]);
}

}  // namespace

CovisiblePairs::CovisiblePairs(const Odometry& odometry, const CovisibleOptions& options)
    : options_(options),
      path_(odometry, 0),
      joined_(Joined(odometry, path_)),
      num_keyframes_(static_cast<int>(odometry.keyframes.size())) {}

std::vector<CovisiblePair> CovisiblePairs::Of(int newer) const {
  std::vector<CovisiblePair> own;
  for (int older = std::max(0, newer - options_.max_gap_keyframes); older < newer; ++older) {
    const Pose3 older_from_newer =
        path_.world_from_camera(older).Inverse() * path_.world_from_camera(newer);
    if (!Within(older_from_newer, CovisibleOptions::kMaxDistance_m, CovisibleOptions::kMaxTurn_deg))
      continue;
    if (path_.Broken(older, newer) || joined_.contains({older, newer})) continue;
    own.push_back({older, newer, older_from_newer});
  }
  return own;
}

std::vector<CovisiblePair> CovisiblePairs::Next(std::size_t most) {
  while (left_.size() < most && next_ < num_keyframes_)
    AppendSpread(Of(next_++), static_cast<std::size_t>(options_.max_pairs), left_);
  const auto end = left_.begin() + static_cast<std::ptrdiff_t>(std::min(most, left_.size()));
  const std::vector<CovisiblePair> pairs(left_.begin(), end);
  left_.erase(left_.begin(), end);
  return pairs;
}

std::vector<RelativePose> AcceptCovisible(std::span<const CovisiblePair> pairs,
                                          std::span<const KeyframeRegistration> registrations,
                                          const Trajectory& trajectory) {
  DEEPSLAM_CHECK(pairs.size() == registrations.size(), "one registration for each pair");
  const auto keyframe = [&](int n) { return trajectory.keyframes[static_cast<std::size_t>(n)]; };
  std::vector<RelativePose> edges;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!BearsOut(registrations[k], pairs[k])) continue;
    edges.push_back({keyframe(pairs[k].older),
                     keyframe(pairs[k].newer),
                     registrations[k].old_from_new,
                     registrations[k].information,
                     false});
  }
  return edges;
}

bool IsConsistent(const RelativePose& edge, const Trajectory& solved) {
  return Agrees(solved,
                edge.i,
                edge.j,
                edge.i_from_j,
                CovisibleOptions::kMaxResidual_m,
                CovisibleOptions::kMaxResidual_deg);
}

void Describe(OptionsVisitor& visitor, CovisibleOptions& options) {
  visitor.Field(
      "enabled",
      options.enabled,
      "measure keyframes against others that see the same; not with poses of the capture");
  visitor.Field("max_pairs",
                options.max_pairs,
                {1, 10000},
                "1",
                "for each keyframe, spread evenly over those before it");
}

}  // namespace deepslam::loop
