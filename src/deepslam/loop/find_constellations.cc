#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "deepslam/core/angles.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/loop/correction.h"
#include "deepslam/loop/shared_place.h"
#include "deepslam/loop/sightings.h"

namespace deepslam::loop {
namespace {

// An old object and a new one that might be the same.
struct PairHypothesis {
  std::size_t old_object = 0;  // index into the map
  std::size_t new_object = 0;
  Eigen::Vector3d old_level;
  Eigen::Vector3d new_level;
  bool yaw_known = false;
  double yaw_rad = 0;  // old minus new
  double path_m = 0;   // between the observations
  int old_frame = 0;   // middle of each observation
  int new_frame = 0;
};

using PairList = std::vector<std::size_t>;  // indices of hypotheses, ascending

class ConstellationFinder {
 public:
  ConstellationFinder(const MappedPath& mapped, const LoopOptions& options)
      : map_(mapped.map),
        classes_(mapped.classes),
        options_(options),
        sightings_(mapped.map, mapped.association, mapped.trajectory, mapped.part_of_frame),
        level_from_world_(LevelFromWorld(UpDirection(mapped.map))) {}

  FoundConstellations Find() {
    FoundConstellations found;
    if (options_.constellations) {
      FindPairs();
      found.complete = FindSets();
    }
    for (const PairList& pairs : MaximalSets())
      found.constellations.push_back(ToConstellation(pairs));
    if (options_.merge_overlapping) AddOverlaps(found.constellations);
    return found;
  }

 private:
  double MaxDrift_m(double path_m) const {
    return options_.drift_base_m + LoopOptions::kDriftShare * path_m;
  }
  double MaxYawDrift_rad(double path_m) const {
    return kRadPerDeg *
           std::min(180.0, LoopOptions::kDriftBase_deg + LoopOptions::kDrift_deg_per_m * path_m);
  }
  double YawTolerance_rad() const { return kRadPerDeg * LoopOptions::kYawTolerance_deg; }

  bool YawFree(const MapObject& object) const {
    if (classes_.TraitsOf(object.class_name).yaw_free) return true;
    bool any = false;
    for (const ViewRegistration& view : object.views) {
      if (!view.ok) continue;
      if (!view.yaw_free) return false;
      any = true;
    }
    return any;
  }

  double LevelYaw(const MapObject& object) const {
    const Eigen::Vector3d front =
        level_from_world_ * (object.world_from_object.rotation * Eigen::Vector3d::UnitX());
    return std::atan2(front.y(), front.x());
  }

  bool Usable(std::size_t k) const {
    const Pose3& pose = map_.objects[k].world_from_object;
    return pose.translation_m.allFinite() && pose.rotation.coeffs().allFinite() &&
           !sightings_.frames(k).empty();
  }

  void FindPairs() {
    for (std::size_t o = 0; o < map_.objects.size(); ++o) {
      for (std::size_t n = 0; n < map_.objects.size(); ++n) {
        if (o != n && map_.objects[o].class_name == map_.objects[n].class_name && Usable(o) &&
            Usable(n)) {
          TryPair(o, n);
        }
      }
    }
  }

  void TryPair(std::size_t o, std::size_t n) {
    const std::vector<int>& old_frames = sightings_.frames(o);
    const std::vector<int>& new_frames = sightings_.frames(n);
    const int start = new_frames.front();
    const auto end = std::lower_bound(old_frames.begin(), old_frames.end(), start);
    if (end == old_frames.begin() || start - *(end - 1) < options_.min_gap_frames) return;
    if (sightings_.SeenTogether(o, n)) return;
    PairHypothesis pair;
    pair.old_object = o;
    pair.new_object = n;
    pair.old_level = level_from_world_ * map_.objects[o].world_from_object.translation_m;
    pair.new_level = level_from_world_ * map_.objects[n].world_from_object.translation_m;
    pair.path_m = sightings_.PathBetween_m(*(end - 1), start);
    pair.old_frame = old_frames[static_cast<std::size_t>((end - old_frames.begin()) / 2)];
    pair.new_frame = new_frames[new_frames.size() / 2];
    pair.yaw_known = !YawFree(map_.objects[o]) && !YawFree(map_.objects[n]);
    pair.yaw_rad = WrappedAngle(LevelYaw(map_.objects[o]) - LevelYaw(map_.objects[n]));
    if ((pair.old_level - pair.new_level).norm() >
        MaxDrift_m(pair.path_m) + LoopOptions::kPositionTolerance_m) {
      return;
    }
    if (pair.yaw_known &&
        std::abs(pair.yaw_rad) > MaxYawDrift_rad(pair.path_m) + YawTolerance_rad()) {
      return;
    }
    pairs_.push_back(pair);
  }

  // Registration error, and drift inside either observation.
  double Tolerance_m(const PairHypothesis& a, const PairHypothesis& b) const {
    return LoopOptions::kPositionTolerance_m +
           LoopOptions::kLocalDrift * (sightings_.PathBetween_m(a.old_frame, b.old_frame) +
                                       sightings_.PathBetween_m(a.new_frame, b.new_frame));
  }

  LevelCorrection Fit(const PairList& list) const {
    CorrectionFit fit;
    for (const std::size_t k : list) {
      fit.AddPoint(pairs_[k].old_level, pairs_[k].new_level);
      if (pairs_[k].yaw_known) fit.AddYaw(pairs_[k].yaw_rad);
    }
    return fit.Solve(LoopOptions::kPositionTolerance_m, YawTolerance_rad());
  }

  bool Agrees(const LevelCorrection& correction, const PairList& list) const {
    double path_m = 0;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const std::size_t k : list) {
      const PairHypothesis& pair = pairs_[k];
      path_m = std::max(path_m, pair.path_m);
      center += pair.new_level / static_cast<double>(list.size());
      const double tolerance_m = Tolerance_m(pairs_[list.front()], pair);
      if ((correction * pair.new_level - pair.old_level).norm() > tolerance_m) return false;
      if (pair.yaw_known &&
          std::abs(WrappedAngle(pair.yaw_rad - correction.yaw_rad)) > YawTolerance_rad()) {
        return false;
      }
    }
    return std::abs(correction.yaw_rad) <= MaxYawDrift_rad(path_m) &&
           (correction * center - center).norm() <= MaxDrift_m(path_m);
  }

  bool Neighbours(const PairHypothesis& a, const PairHypothesis& b) const {
    return (a.old_level - b.old_level).norm() <= LoopOptions::kMaxSpread_m &&
           (a.new_level - b.new_level).norm() <= LoopOptions::kMaxSpread_m;
  }

  bool Compatible(const PairHypothesis& a, const PairHypothesis& b) const {
    return a.old_object != b.old_object && a.new_object != b.new_object &&
           a.old_object != b.new_object && a.new_object != b.old_object && Neighbours(a, b);
  }

  // Whether all seeds were tried.
  bool FindSets() {
    int num_seeds = 0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      for (std::size_t j = i + 1; j < pairs_.size(); ++j) {
        if (!IsSeed(i, j)) continue;
        if (++num_seeds > options_.max_seeds) return false;
        const PairList seed = {i, j};
        if (Agrees(Fit(seed), seed)) AddSet(Grown(seed));
      }
    }
    return true;
  }

  bool IsSeed(std::size_t i, std::size_t j) const {
    if (!Compatible(pairs_[i], pairs_[j])) return false;
    const double apart_old_m = (pairs_[i].old_level - pairs_[j].old_level).norm();
    const double apart_new_m = (pairs_[i].new_level - pairs_[j].new_level).norm();
    return std::abs(apart_old_m - apart_new_m) <= 2 * Tolerance_m(pairs_[i], pairs_[j]) &&
           !joined_.contains({i, j});
  }

  void AddSet(PairList list) {
    for (std::size_t a = 0; a < list.size(); ++a) {
      for (std::size_t b = a + 1; b < list.size(); ++b) joined_.emplace(list[a], list[b]);
    }
    sets_.insert(std::move(list));
  }

  // The seed with every further pair that agrees, nearest first.
  PairList Grown(PairList list) const {
    const LevelCorrection seed_correction = Fit(list);
    std::vector<std::pair<double, std::size_t>> others;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const PairHypothesis& pair = pairs_[k];
      if (!Compatible(pairs_[list[0]], pair) || !Compatible(pairs_[list[1]], pair)) continue;
      const double error_m = (seed_correction * pair.new_level - pair.old_level).norm();
      if (error_m < 2 * Tolerance_m(pairs_[list.front()], pair)) others.emplace_back(error_m, k);
    }
    std::sort(others.begin(), others.end());
    for (const auto& other : others) {
      const auto k = other.second;  // clang 14 captures no structured binding
      const bool compatible = std::all_of(list.begin(), list.end(), [&](std::size_t member) {
        return Compatible(pairs_[member], pairs_[k]);
      });
      if (!compatible) continue;
      PairList longer = list;
      longer.push_back(k);
      if (Agrees(Fit(longer), longer)) list = longer;
    }
    std::sort(list.begin(), list.end());
    return list;
  }

  std::vector<PairList> MaximalSets() const {
    std::vector<PairList> maximal;
    for (const PairList& list : sets_) {
      if (static_cast<int>(list.size()) < LoopOptions::kMinPairs) continue;
      const bool contained =
          std::any_of(sets_.begin(), sets_.end(), [&list](const PairList& other) {
            return other.size() > list.size() &&
                   std::includes(other.begin(), other.end(), list.begin(), list.end());
          });
      if (!contained) maximal.push_back(list);
    }
    std::stable_sort(maximal.begin(), maximal.end(), [](const PairList& a, const PairList& b) {
      return a.size() > b.size();
    });
    return maximal;
  }

  Constellation ToConstellation(const PairList& list) const {
    Constellation constellation;
    const LevelCorrection correction = Fit(list);
    double squared = 0;
    for (const std::size_t k : list) {
      const PairHypothesis& pair = pairs_[k];
      constellation.pairs.push_back(
          {map_.objects[pair.old_object].id, map_.objects[pair.new_object].id});
      squared += (correction * pair.new_level - pair.old_level).squaredNorm();
    }
    constellation.old_world_from_new_world = correction.InWorld(level_from_world_);
    constellation.position_error_m = std::sqrt(squared / static_cast<double>(list.size()));
    constellation.reason = "not verified";
    return constellation;
  }

  // Duplicates that stand in each other; where a constellation has the pair already, it decides.
  void AddOverlaps(std::vector<Constellation>& found) const {
    std::set<std::pair<ObjectId, ObjectId>> known;
    for (const Constellation& constellation : found) {
      for (const ObjectMerge& pair : constellation.pairs) known.emplace(pair.kept, pair.merged);
    }
    for (std::size_t a = 0; a < map_.objects.size(); ++a) {
      for (std::size_t b = a + 1; b < map_.objects.size(); ++b) {
        if (!SharePlace(map_.objects[a], map_.objects[b]) || !Usable(a) || !Usable(b) ||
            sightings_.SeenTogether(a, b) || !sightings_.Tied(a, b)) {
          continue;
        }
        const bool a_first = sightings_.frames(a).front() <= sightings_.frames(b).front();
        const MapObject& old_object = map_.objects[a_first ? a : b];
        const MapObject& new_object = map_.objects[a_first ? b : a];
        const Eigen::Vector3d move_m =
            old_object.world_from_object.translation_m - new_object.world_from_object.translation_m;
        if (known.contains({old_object.id, new_object.id})) continue;
        Constellation single;
        single.pairs = {{old_object.id, new_object.id}};
        single.old_world_from_new_world.translation_m = move_m;
        single.position_error_m = move_m.norm();
        single.reason = "not verified";
        found.push_back(single);
      }
    }
  }

  const ObjectMap& map_;
  const ClassTable& classes_;
  const LoopOptions& options_;
  const Sightings sightings_;
  const Eigen::Quaterniond level_from_world_;
  std::vector<PairHypothesis> pairs_;
  std::set<PairList> sets_;
  std::set<std::pair<std::size_t, std::size_t>> joined_;  // that one of the sets has both of
};

}  // namespace

void Describe(OptionsVisitor& visitor, LoopOptions& options) {
  constexpr Range kDistance_m{0, 1000};
  visitor.Field("enabled", options.enabled, "look for loops of any kind");
  visitor.Field(
      "constellations", options.constellations, "look for loops by constellations of objects");
  visitor.Field("min_gap_frames",
                options.min_gap_frames,
                {1, 1e6},
                "frames",
                "between the old objects' last observation and the new ones' first");
  visitor.Field("drift_base_m",
                options.drift_base_m,
                kDistance_m,
                "m",
                "largest correction without any path");
  visitor.Field("merge_overlapping",
                options.merge_overlapping,
                "merge two objects of a class that stand in each other");
}

FoundConstellations FindConstellations(const MappedPath& mapped, const LoopOptions& options) {
  if (!options.enabled) return {};
  return ConstellationFinder(mapped, options).Find();
}

}  // namespace deepslam::loop
