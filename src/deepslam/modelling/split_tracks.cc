#include "deepslam/modelling/split_tracks.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/loop/correction.h"
#include "deepslam/modelling/candidate_set.h"
#include "deepslam/modelling/loop_evidence.h"
#include "deepslam/modelling/moved_objects.h"
#include "deepslam/modelling/rescore_objects.h"

namespace deepslam::modelling {
namespace {

// Tracklets of objects that were re-identified, one object's after the other's.
struct Tracklets {
  std::vector<ObjectTrack> tracks;  // ids are places in the list: views are planned by them
  std::vector<ObjectId> objects;    // of the observations
};

Tracklets TrackletsOfMap(const LoopWorld& world, const loop::LoopOptions& options) {
  Tracklets tracklets;
  for (const ObjectTrack& track : world.association.tracks) {
    if (std::ranges::find(world.map.objects, track.id, &MapObject::id) == world.map.objects.end())
      continue;
    std::vector<ObjectTrack> own = loop::Tracklets(track, options);
    if (own.size() < 2) continue;
    for (ObjectTrack& tracklet : own) {
      tracklet.id = ObjectId{static_cast<int>(tracklets.tracks.size())};
      tracklets.tracks.push_back(std::move(tracklet));
      tracklets.objects.push_back(track.id);
    }
  }
  return tracklets;
}

// Which of the observations stand apart from the one before. What was measured is held for a batch
// of observations and the one before it: a camera that goes round for an hour sees
// everything many times.
class TrackletComparison {
 public:
  TrackletComparison(const Tracklets& tracklets,
                     const Eigen::Vector3d& up_world,
                     const loop::LoopOptions& options)
      : tracklets_(tracklets), up_world_(up_world), options_(options) {}

  // The next observations.
  void Compare(std::span<const TrackViews> batch) {
    std::vector<loop::ObjectEvidence> measured(1 + batch.size());  // the one before, then these
    measured.front() = std::move(before_);
    ParallelFor(batch.size(),
                [&](std::size_t n) { AppendMeasured(batch[n].views, measured[n + 1]); });
    std::vector<char> is_apart(batch.size());
    ParallelFor(batch.size(), [&](std::size_t n) {
      is_apart[n] = Follows(num_compared_ + n) &&
                    loop::StandApart(measured[n], measured[n + 1], up_world_, options_);
    });
    for (const char apart : is_apart) {
      if (Follows(num_compared_)) apart_[tracklets_.objects[num_compared_]].push_back(apart != 0);
      ++num_compared_;
    }
    before_ = std::move(measured.back());
  }
  [[nodiscard]] loop::StandingApart Take() && { return std::move(apart_); }

 private:
  // Of the same object as the observation before.
  [[nodiscard]] bool Follows(std::size_t tracklet) const {
    return tracklet > 0 && tracklets_.objects[tracklet - 1] == tracklets_.objects[tracklet];
  }

  const Tracklets& tracklets_;
  const Eigen::Vector3d up_world_;
  const loop::LoopOptions& options_;
  std::size_t num_compared_ = 0;
  loop::ObjectEvidence before_;  // of the last observation
  loop::StandingApart apart_;
};

void SortTracks(Association& association) {
  std::ranges::stable_sort(association.tracks, {}, &ObjectTrack::id);
}

void SortObjects(ObjectMap& map) { std::ranges::stable_sort(map.objects, {}, &MapObject::id); }

void CopyCandidates(ObjectId from, ObjectId to, LoopWorld& world) {
  const int first = NextId(world.proposals);
  for (ShapeCandidate candidate : CandidatesOf(world.proposals, from)) {
    candidate.object = to;
    candidate.id = CandidateId{first + static_cast<int>(world.made.candidates.size())};
    world.made.candidates.push_back(std::move(candidate));
  }
}

// The object with what one of its observations saw.
MapObject OfTracklet(const MapObject& object, const ObjectTrack& tracklet) {
  MapObject own = object;
  own.id = tracklet.id;
  own.merged.clear();
  std::erase_if(own.views, [&](const ViewRegistration& view) {
    return view.frame < tracklet.members.front().frame ||
           view.frame > tracklet.members.back().frame;
  });
  return own;
}

void EraseObject(ObjectMap& map, ObjectId id) {
  std::erase_if(map.objects, [&](const MapObject& object) { return object.id == id; });
}

// The first observation of an object has its number: what was made for the whole stays.
void RemoveTracklet(ObjectId tracklet, std::size_t num_made_before, LoopWorld& world) {
  EraseTrack(world.association, tracklet);
  EraseObject(world.map, tracklet);
  world.registrations.erase(tracklet);
  for (ShapeCandidate& candidate : std::span(world.made.candidates).subspan(num_made_before)) {
    if (candidate.object == tracklet) candidate.object = ObjectId();
  }
}

}  // namespace

Result<loop::SplitObjects> FindSplits(const LoopClosing& closing, const LoopWorld& world) {
  const Tracklets tracklets = TrackletsOfMap(world, closing.loops);
  if (!closing.loops.constellations || tracklets.tracks.empty()) return loop::SplitObjects();
  TrackletComparison comparison(tracklets, loop::UpDirection(world.map), closing.loops);
  const auto use = [&](std::span<TrackViews> batch) {
    comparison.Compare(batch);
    return Ok();
  };
  const Status compared = closing.sources.views.ForBatches(
      {tracklets.tracks, world.odometry, world.ground}, observe::ViewContent::kDepth, use);
  if (!compared.ok()) return compared.error();
  return loop::SplitTracklets(world.association, std::move(comparison).Take(), closing.loops);
}

Result<WholeObjects> SplitTracks(const loop::SplitObjects& splits,
                                 const LoopClosing& closing,
                                 LoopWorld& world) {
  WholeObjects whole{world.odometry, splits.tracklets, {}, {}, world.made.candidates.size()};
  std::vector<MapObject> tracklets;
  for (std::size_t k = 0; k < splits.tracklets.size(); ++k) {
    const ObjectId id = splits.tracklets[k].object;
    if (!whole.objects.contains(id)) {
      whole.objects.emplace(id, *FindObject(world.map, id));
      whole.tracks.emplace(id, *FindTrack(world.association, id));
      EraseObject(world.map, id);
      EraseTrack(world.association, id);
    }
    if (splits.tracks[k].id != id) CopyCandidates(id, splits.tracks[k].id, world);
    world.association.tracks.push_back(splits.tracks[k]);
    tracklets.push_back(OfTracklet(whole.objects.at(id), splits.tracks[k]));
  }
  SortTracks(world.association);
  for (MapObject& tracklet : tracklets) {
    if (Status status = RescoreTrack("visit", closing, world, tracklet); !status.ok())
      return status.error();
  }
  std::ranges::move(tracklets, std::back_inserter(world.map.objects));
  SortObjects(world.map);
  return whole;
}

Status RejoinTracks(const std::set<ObjectId>& rejoined,
                    const WholeObjects& before,
                    const LoopClosing& closing,
                    LoopWorld& world) {
  for (const SplitTracklet& tracklet : before.tracklets) {
    if (rejoined.contains(tracklet.object))
      RemoveTracklet(tracklet.tracklet, before.num_made, world);
  }
  for (const ObjectId id : rejoined) {
    world.association.tracks.push_back(before.tracks.at(id));
    SortTracks(world.association);
    const MapObject& whole = before.objects.at(id);
    MapObject object = whole;
    object.world_from_object =
        MovedWith(before.trajectory, world.odometry, whole) * whole.world_from_object;
    const Eigen::Vector3d& centre = whole.world_from_object.translation_m;
    if (MovedApart_m(before.trajectory, world.odometry, whole, centre) > loop::kApart_m) {
      if (Status status = RescoreTrack("closed", closing, world, object); !status.ok())
        return status;
    }
    world.map.objects.push_back(std::move(object));
  }
  SortObjects(world.map);
  return Ok();
}

}  // namespace deepslam::modelling
