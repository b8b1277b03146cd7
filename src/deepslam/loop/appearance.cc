#include "deepslam/loop/appearance.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "deepslam/core/angles.h"
#include "deepslam/core/parallel.h"
#include "deepslam/loop/corner_loop.h"
#include "deepslam/loop/feature_pose.h"
#include "deepslam/loop/keyframe_path.h"
#include "deepslam/loop/registered_pair.h"
#include "deepslam/loop/similar_keyframes.h"

namespace deepslam::loop {
namespace {

constexpr int kComparedNeighbours = 15;  // keyframes looked at about one whose loops are compared
// What two right poses of neighbours differ by, beside drift.
constexpr double kSameLoop_m = 0.10;
constexpr double kSameLoop_deg = 4;  // the same for the turn
constexpr double kFloors = 3;        // edge_floor that a solution may be off an edge

// A loop and where it stands on the path.
struct Placed {
  int i = 0;
  int j = 0;
  Pose3 i_from_j;
};

class Consistency {
 public:
  Consistency(const Odometry& odometry, const AppearanceOptions& options)
      : path_(odometry, options.drift_share),
        reach_(kComparedNeighbours * KeyframeStep(odometry.keyframes.size(), options)),
        options_(options) {}

  [[nodiscard]] Placed Place(const AppearanceLoop& loop) const {
    return {path_.IndexOf(loop.old_keyframe), path_.IndexOf(loop.new_keyframe), loop.old_from_new};
  }

  [[nodiscard]] bool WithinDrift(const Placed& loop) const {
    if (path_.Broken(loop.i, loop.j)) return true;
    const Pose3 off =
        (path_.world_from_camera(loop.i).Inverse() * path_.world_from_camera(loop.j)).Inverse() *
        loop.i_from_j;
    return off.translation_m.norm() <= options_.drift_base_m + path_.Drift_m(loop.i, loop.j) &&
           RotationAngle(off.rotation) <=
               kRadPerDeg * (AppearanceOptions::kDriftBase_deg +
                             AppearanceOptions::kDrift_deg_per_m * path_.Length_m(loop.i, loop.j));
  }

  // Both tell the same correction, as far as drift between their keyframes allows to say.
  [[nodiscard]] bool Same(const Placed& a, const Placed& b) const {
    if (path_.Broken(a.i, b.i) || path_.Broken(a.j, b.j)) return true;
    const Pose3 expected = (path_.world_from_camera(b.i).Inverse() * path_.world_from_camera(a.i)) *
                           a.i_from_j *
                           (path_.world_from_camera(a.j).Inverse() * path_.world_from_camera(b.j));
    const Pose3 off = b.i_from_j.Inverse() * expected;
    const double length_m = path_.Length_m(a.i, b.i) + path_.Length_m(a.j, b.j);
    return off.translation_m.norm() <=
               kSameLoop_m + path_.Drift_m(a.i, b.i) + path_.Drift_m(a.j, b.j) &&
           RotationAngle(off.rotation) <=
               kRadPerDeg * (kSameLoop_deg + AppearanceOptions::kDrift_deg_per_m * length_m);
  }

  [[nodiscard]] bool Near(int a, int b) const { return std::abs(a - b) <= reach_; }

 private:
  KeyframePath path_;
  const int reach_;  // keyframes
  const AppearanceOptions& options_;
};

// Indices of the loops whose new keyframe is near that of `k`; `placed` ascends in j.
template <typename Visitor>
void ForNeighbours(const Consistency& consistency,
                   const std::vector<Placed>& placed,
                   std::size_t k,
                   const Visitor& visit) {
  for (std::size_t n = k; n-- > 0 && consistency.Near(placed[n].j, placed[k].j);) visit(n);
  for (std::size_t n = k + 1; n < placed.size() && consistency.Near(placed[n].j, placed[k].j);
       ++n) {
    visit(n);
  }
}

// Other new keyframes that say the same of the same old place.
int Support(const Consistency& consistency,
            const std::vector<Placed>& placed,
            const std::vector<bool>& counts,
            std::size_t k) {
  std::set<int> supporters;
  ForNeighbours(consistency, placed, k, [&](std::size_t n) {
    if (counts[n] && placed[n].j != placed[k].j && consistency.Near(placed[n].i, placed[k].i) &&
        consistency.Same(placed[k], placed[n])) {
      supporters.insert(placed[n].j);
    }
  });
  return static_cast<int>(supporters.size());
}

std::vector<Placed> PlaceAll(const Consistency& consistency,
                             std::span<const AppearanceLoop> loops) {
  std::vector<Placed> placed;
  for (const AppearanceLoop& loop : loops) placed.push_back(consistency.Place(loop));
  return placed;
}

// Of each new keyframe the proposals with most corners.
std::vector<AppearanceLoop> Strongest(std::vector<AppearanceLoop> loops, int most) {
  std::stable_sort(
      loops.begin(), loops.end(), [](const AppearanceLoop& a, const AppearanceLoop& b) {
        if (a.new_keyframe != b.new_keyframe) return a.new_keyframe < b.new_keyframe;
        return a.num_inliers > b.num_inliers;
      });
  std::vector<AppearanceLoop> kept;
  int count = 0;
  for (const AppearanceLoop& loop : loops) {
    count = !kept.empty() && kept.back().new_keyframe == loop.new_keyframe ? count + 1 : 1;
    if (count <= most) kept.push_back(loop);
  }
  return kept;
}

// Judges the registered loops among themselves: support, then contradictions.
void SettleContradictions(const Odometry& odometry,
                          const AppearanceOptions& options,
                          std::vector<AppearanceLoop>& loops) {
  const Consistency consistency(odometry, options);
  const std::vector<Placed> placed = PlaceAll(consistency, loops);
  std::vector<bool> good(loops.size());
  for (std::size_t k = 0; k < loops.size(); ++k) good[k] = loops[k].accepted;
  for (std::size_t k = 0; k < loops.size(); ++k) {
    loops[k].num_support = Support(consistency, placed, good, k);
  }
  for (std::size_t k = 0; k < loops.size(); ++k) {
    if (!good[k]) continue;
    if (loops[k].num_support < AppearanceOptions::kMinSupport) {
      loops[k].accepted = false;
      loops[k].reason = "too few neighbours say the same";
      continue;
    }
    int against = 0;
    ForNeighbours(consistency, placed, k, [&](std::size_t n) {
      if (good[n] && !consistency.Same(placed[k], placed[n]))
        against = std::max(against, loops[n].num_support);
    });
    if (against > AppearanceOptions::kAmbiguityRatio * loops[k].num_support) {
      loops[k].accepted = false;
      loops[k].reason = "ambiguous: neighbours say otherwise";
    }
  }
}

}  // namespace

void Describe(OptionsVisitor& visitor, AppearanceOptions& options) {
  constexpr Range kDistance_m{0, 1000};
  visitor.Field("enabled", options.enabled, "look for loops by the appearance of keyframes");
  visitor.Field("max_keyframes",
                options.max_keyframes,
                {2, 1e6},
                "1",
                "keyframes looked at, so that memory is bounded; of more every second, third, ...");
  visitor.Field("min_gap_keyframes",
                options.min_gap_keyframes,
                {1, 1e6},
                "1",
                "keyframes looked at between the two of a loop");
  visitor.Field("drift_base_m",
                options.drift_base_m,
                kDistance_m,
                "m",
                "largest correction without any path");
}

int KeyframeStep(std::size_t num_keyframes, const AppearanceOptions& options) {
  const auto most = static_cast<std::size_t>(options.max_keyframes);
  return static_cast<int>(std::max<std::size_t>(1, (num_keyframes + most - 1) / most));
}

std::vector<AppearanceLoop> ProposeAppearanceLoops(std::span<const KeyframeFeatures> features,
                                                   const Odometry& odometry,
                                                   const AppearanceOptions& options) {
  if (!options.enabled) return {};
  const Consistency consistency(odometry, options);
  const SimilarityOptions similarity{options.min_gap_keyframes,
                                     AppearanceOptions::kMaxCandidates,
                                     AppearanceOptions::kMinSimilarity};
  const auto similar = FindSimilarKeyframes(features, similarity);
  std::vector<std::vector<AppearanceLoop>> by_keyframe(features.size());
  ParallelFor(features.size(), [&](std::size_t j) {
    for (const SimilarKeyframe& candidate : similar[j]) {
      const KeyframeFeatures& older = features[candidate.index];
      const auto pose = PoseFromFeatures(older, features[j], options.min_inliers);
      if (!pose || !BearsOut(*pose)) continue;
      AppearanceLoop loop{older.keyframe,
                          features[j].keyframe,
                          pose->old_from_new,
                          pose->num_inliers,
                          0,
                          0,
                          false,
                          "not registered"};
      const Placed placed = consistency.Place(loop);
      if (placed.i < 0 || placed.j < 0 || !consistency.WithinDrift(placed)) continue;
      by_keyframe[j].push_back(std::move(loop));
    }
  });
  std::vector<AppearanceLoop> proposed;
  for (const auto& loops : by_keyframe) proposed.insert(proposed.end(), loops.begin(), loops.end());

  const std::vector<Placed> placed = PlaceAll(consistency, proposed);
  const std::vector<bool> all(proposed.size(), true);
  std::vector<AppearanceLoop> supported;
  for (std::size_t k = 0; k < proposed.size(); ++k) {
    proposed[k].num_support = Support(consistency, placed, all, k);
    if (proposed[k].num_support >= AppearanceOptions::kMinSupport) supported.push_back(proposed[k]);
  }
  return Strongest(std::move(supported), AppearanceOptions::kMaxRegistrations);
}

AcceptedAppearance AcceptAppearanceLoops(std::span<const AppearanceLoop> proposed,
                                         std::span<const KeyframeRegistration> registrations,
                                         const Odometry& odometry,
                                         const AppearanceOptions& options) {
  AcceptedAppearance result;
  result.loops.assign(proposed.begin(), proposed.end());
  for (std::size_t k = 0; k < result.loops.size(); ++k) {
    AppearanceLoop& loop = result.loops[k];
    const KeyframeRegistration& registration = registrations[k];
    loop.agreement = registration.agreement;
    loop.reason = Verdict(loop, registration);
    loop.accepted = loop.reason.empty();
    if (loop.accepted) {
      loop.reason = "corners and depth agree";
      loop.old_from_new = registration.old_from_new;
    }
  }
  SettleContradictions(odometry, options, result.loops);
  for (std::size_t k = 0; k < result.loops.size(); ++k) {
    const AppearanceLoop& loop = result.loops[k];
    if (!loop.accepted) continue;
    result.edges.push_back({loop.old_keyframe,
                            loop.new_keyframe,
                            loop.old_from_new,
                            EdgeInformation(registrations[k].information,
                                            AppearanceOptions::kVarianceScale,
                                            AppearanceOptions::kEdgeFloor_m,
                                            kRadPerDeg * AppearanceOptions::kEdgeFloor_deg),
                            false});
  }
  return result;
}

bool RefuseContradicted(const Trajectory& solved,
                        const AppearanceOptions& options,
                        AcceptedAppearance& accepted) {
  const double most_m = kFloors * AppearanceOptions::kEdgeFloor_m + options.drift_share;
  const double most_deg =
      kFloors * AppearanceOptions::kEdgeFloor_deg + AppearanceOptions::kDrift_deg_per_m;
  const auto contradicted = [&](FrameIdx i, FrameIdx j, const Pose3& i_from_j) {
    return !Agrees(solved, i, j, i_from_j, most_m, most_deg);
  };
  const std::size_t before = accepted.edges.size();
  std::erase_if(accepted.edges, [&](const RelativePose& edge) {
    return contradicted(edge.i, edge.j, edge.i_from_j);
  });
  for (AppearanceLoop& loop : accepted.loops) {
    if (!loop.accepted || !contradicted(loop.old_keyframe, loop.new_keyframe, loop.old_from_new))
      continue;
    loop.accepted = false;
    loop.reason = "the other measurements contradict it";
  }
  return accepted.edges.size() != before;
}

}  // namespace deepslam::loop
