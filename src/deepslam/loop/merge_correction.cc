#include "deepslam/loop/merge_correction.h"

#include <map>
#include <vector>

namespace deepslam::loop {
namespace {

struct Step {
  ObjectId to;
  Pose3 to_from_here;
};

std::vector<Step> StepsFrom(ObjectId here, const Loops& loops) {
  std::vector<Step> steps;
  for (const Constellation& constellation : loops.constellations) {
    if (!constellation.accepted) continue;
    const Pose3& old_from_new = constellation.old_world_from_new_world;
    for (const ObjectMerge& pair : constellation.pairs) {
      if (pair.merged == here) steps.push_back({pair.kept, old_from_new});
      if (pair.kept == here) steps.push_back({pair.merged, old_from_new.Inverse()});
    }
  }
  return steps;
}

}  // namespace

Pose3 CorrectionOf(const ObjectMerge& merge, const Loops& loops) {
  std::map<ObjectId, Pose3> reached = {{merge.merged, Pose3{}}};
  std::vector<ObjectId> next = {merge.merged};
  for (std::size_t n = 0; n < next.size() && !reached.contains(merge.kept); ++n) {
    const Pose3 here_from_merged = reached.at(next[n]);
    for (const Step& step : StepsFrom(next[n], loops)) {
      if (reached.emplace(step.to, step.to_from_here * here_from_merged).second)
        next.push_back(step.to);
    }
  }
  const auto kept = reached.find(merge.kept);
  return kept == reached.end() ? Pose3{} : kept->second;
}

}  // namespace deepslam::loop
