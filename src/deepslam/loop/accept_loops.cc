#include <algorithm>
#include <map>
#include <set>

#include "deepslam/core/angles.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/loop/sightings.h"

namespace deepslam::loop {
namespace {

using IdPair = std::pair<ObjectId, ObjectId>;

IdPair Ordered(ObjectId a, ObjectId b) { return {std::min(a, b), std::max(a, b)}; }

// Whether two constellations pair one object with partners that nothing takes for one object.
bool Contradict(const Constellation& a, const Constellation& b, const std::set<IdPair>& same) {
  for (const ObjectMerge& p : a.pairs) {
    for (const ObjectMerge& q : b.pairs) {
      for (const auto& [shared_p, other_p] : {IdPair{p.kept, p.merged}, {p.merged, p.kept}}) {
        for (const auto& [shared_q, other_q] : {IdPair{q.kept, q.merged}, {q.merged, q.kept}}) {
          if (shared_p == shared_q && other_p != other_q &&
              !same.contains(Ordered(other_p, other_q))) {
            return true;
          }
        }
      }
    }
  }
  return false;
}

// Refuses contradictions. Every pair of verdicts is taken against the verification's, so that order
// does not matter.
void RefuseContradictions(std::vector<Constellation>& all) {
  std::set<IdPair> same;
  for (const Constellation& c : all) {
    if (!c.accepted) continue;
    for (const ObjectMerge& pair : c.pairs) same.insert(Ordered(pair.kept, pair.merged));
  }
  std::vector<std::size_t> refused;
  for (std::size_t a = 0; a < all.size(); ++a) {
    for (std::size_t b = 0; b < all.size(); ++b) {
      if (a == b || !all[a].accepted || !all[b].accepted || !Contradict(all[a], all[b], same)) {
        continue;
      }
      const double mine = static_cast<double>(all[a].pairs.size());
      const double others = static_cast<double>(all[b].pairs.size());
      if (others > LoopOptions::kAmbiguityRatio * mine) {
        refused.push_back(a);
        break;
      }
    }
  }
  for (const std::size_t k : refused) {
    all[k].accepted = false;
    all[k].reason += "; ambiguous: another constellation explains the same objects as well";
  }
}

// Groups of objects that are one.
class Groups {
 public:
  Groups(const ObjectMap& map, const Association& association, const Trajectory& trajectory)
      : sightings_(map, association, trajectory, {}) {
    for (std::size_t k = 0; k < map.objects.size(); ++k) {
      const ObjectId id = map.objects[k].id;
      index_.emplace(id, k);
      members_[id] = {id};
      root_[id] = id;
    }
  }

  // Whether the groups of both may become one: no frame sees two members apart.
  [[nodiscard]] bool MayJoin(ObjectId a, ObjectId b) const {
    if (!root_.contains(a) || !root_.contains(b)) return false;
    if (root_.at(a) == root_.at(b)) return true;
    for (const ObjectId p : members_.at(root_.at(a))) {
      for (const ObjectId q : members_.at(root_.at(b))) {
        if (sightings_.SeenTogether(index_.at(p), index_.at(q))) return false;
      }
    }
    return true;
  }

  void Join(ObjectId a, ObjectId b) {
    const ObjectId low = std::min(root_.at(a), root_.at(b));
    const ObjectId high = std::max(root_.at(a), root_.at(b));
    if (low == high) return;
    for (const ObjectId id : members_.at(high)) {
      root_[id] = low;
      members_[low].push_back(id);
    }
    members_.erase(high);
  }

  [[nodiscard]] std::vector<ObjectMerge> Merges() const {
    std::vector<ObjectMerge> merges;
    for (const auto& [id, root] : root_) {
      if (id != root) merges.push_back({root, id});
    }
    return merges;
  }

 private:
  Sightings sightings_;
  std::map<ObjectId, std::size_t> index_;
  std::map<ObjectId, ObjectId> root_;                  // lowest id of the group
  std::map<ObjectId, std::vector<ObjectId>> members_;  // by root
};

// All of a constellation's pairs enter, or none.
bool JoinAll(const Constellation& constellation, Groups& groups) {
  Groups trial = groups;
  for (const ObjectMerge& pair : constellation.pairs) {
    if (!trial.MayJoin(pair.kept, pair.merged)) return false;
    trial.Join(pair.kept, pair.merged);
  }
  groups = trial;
  return true;
}

// Keyframe of the object's best registered view; an invalid one without any.
FrameIdx BestKeyframe(const ObjectMap& map, ObjectId id, const Trajectory& trajectory) {
  FrameIdx best;
  double best_share = -1;
  for (const MapObject& object : map.objects) {
    if (object.id != id) continue;
    for (const ViewRegistration& view : object.views) {
      if (!view.ok || !view.frame.valid() ||
          view.frame.value >= static_cast<int>(trajectory.frames.size()) ||
          view.inlier_share <= best_share) {
        continue;
      }
      best_share = view.inlier_share;
      best = trajectory.at(view.frame).keyframe;
    }
  }
  return best;
}

void AddEdges(const Constellation& constellation,
              const ObjectMap& map,
              const Trajectory& trajectory,
              std::vector<RelativePose>& edges) {
  const double deviation_m = std::max(LoopOptions::kEdgeFloor_m, constellation.position_error_m);
  Vector6d deviation;
  deviation << Eigen::Vector3d::Constant(deviation_m),
      Eigen::Vector3d::Constant(LoopOptions::kEdgeFloor_deg * kRadPerDeg);
  for (const ObjectMerge& pair : constellation.pairs) {
    const FrameIdx i = BestKeyframe(map, pair.kept, trajectory);
    const FrameIdx j = BestKeyframe(map, pair.merged, trajectory);
    const auto known = [&trajectory](FrameIdx frame) {
      return std::binary_search(trajectory.keyframes.begin(), trajectory.keyframes.end(), frame);
    };
    const bool there = std::any_of(edges.begin(), edges.end(), [i, j](const RelativePose& edge) {
      return edge.i == i && edge.j == j;
    });
    if (i == j || !known(i) || !known(j) || there) continue;
    RelativePose edge;
    edge.i = i;
    edge.j = j;
    edge.i_from_j = trajectory.at(i).world_from_camera.Inverse() *
                    constellation.old_world_from_new_world * trajectory.at(j).world_from_camera;
    edge.information = deviation.cwiseAbs2().cwiseInverse().asDiagonal();
    edges.push_back(edge);
  }
}

}  // namespace

Loops AcceptLoops(std::span<const Constellation> verified,
                  const ObjectMap& map,
                  const Association& association,
                  const Trajectory& trajectory) {
  Loops loops;
  loops.constellations.assign(verified.begin(), verified.end());
  RefuseContradictions(loops.constellations);
  std::stable_sort(loops.constellations.begin(),
                   loops.constellations.end(),
                   [](const Constellation& a, const Constellation& b) {
                     if (a.accepted != b.accepted) return a.accepted;
                     if (a.pairs.size() != b.pairs.size()) return a.pairs.size() > b.pairs.size();
                     return a.position_error_m < b.position_error_m;
                   });
  Groups groups(map, association, trajectory);
  for (Constellation& constellation : loops.constellations) {
    if (!constellation.accepted) continue;
    if (!JoinAll(constellation, groups)) {
      constellation.accepted = false;
      constellation.reason += "; a frame sees two of the objects apart";
      continue;
    }
    if (constellation.pairs.size() > 1) {
      AddEdges(constellation, map, trajectory, loops.edges);
    }
  }
  loops.merges = groups.Merges();
  return loops;
}

void Append(Loops more, Loops& all) {
  const auto pairs = [](const Constellation& constellation) {
    std::vector<IdPair> ids;
    for (const ObjectMerge& pair : constellation.pairs) ids.emplace_back(pair.kept, pair.merged);
    return ids;
  };
  for (Constellation& constellation : more.constellations) {
    std::erase_if(all.constellations, [&](const Constellation& earlier) {
      return !earlier.accepted && pairs(earlier) == pairs(constellation);
    });
    all.constellations.push_back(std::move(constellation));
  }
  for (const ObjectMerge& merge : more.merges) {
    for (ObjectMerge& earlier : all.merges) {
      if (earlier.kept == merge.merged) earlier.kept = merge.kept;
    }
    all.merges.push_back(merge);
  }
  all.edges.insert(all.edges.end(), more.edges.begin(), more.edges.end());
}

}  // namespace deepslam::loop
