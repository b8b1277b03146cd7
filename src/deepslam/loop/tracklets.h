// Objects that association re-identified. Behind drift it may have known the right one at a place
// that is no longer its own, or taken the neighbour for it; either way the views of both
// observations agree on no place, and what is registered with all of them stands nowhere. The depth
// tells: where what one observation saw of the object and around it fits the other better
// elsewhere, the observations are parted and looked for like objects of their own, so that
// constellations decide which are one and how far the path is off.
#pragma once

#include <map>
#include <set>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_track.h"

namespace deepslam::loop {

// What moves further than this was scored where it does not stand.
inline constexpr double kApart_m = 0.10;

// The track's tracklets: cut wherever the object was not seen for min_gap_frames. At least one, all
// under the track's own id.
[[nodiscard]] std::vector<ObjectTrack> Tracklets(const ObjectTrack& track,
                                                 const LoopOptions& options);

// Whether what two observations measured of an object, in a world with this up direction, belongs
// further on: registered with each other, surroundings with it, one observation moves by more than
// kApart_m, and the object's points lie on each other then (min_object_agreement), clearly more of
// them than as the observations stand. Surroundings tell drift from observations that saw different
// parts of an object. Models do not count. Fewer than 30 points of either observation tell nothing.
[[nodiscard]] bool StandApart(const ObjectEvidence& old_tracklet,
                              const ObjectEvidence& new_tracklet,
                              const Eigen::Vector3d& up_world,
                              const LoopOptions& options);

// Per object and for each of its tracklets but the first: whether it stands apart from the one
// before.
using StandingApart = std::map<ObjectId, std::vector<bool>>;

struct SplitObjects {
  std::vector<ObjectTrack> tracks;  // of the observations, each under an id of its own, ascending
  std::vector<SplitTracklet> tracklets;  // in the same order
};

// Objects parted where an observation stands apart from the one before; the first part keeps the
// id, others get the next free ones of `association`. Objects of which nothing is said stay whole
// and are not among the tracks.
[[nodiscard]] SplitObjects SplitTracklets(const Association& association,
                                          const StandingApart& apart,
                                          const LoopOptions& options);

// Tracklets of one object, one after the other, as single pairs: association says that they are one
// thing, and depth has to say where. Where a constellation of `proposed` has the pair, it decides;
// other single pairs of such observations leave `proposed`, since where models overlap tells
// nothing new.
[[nodiscard]] std::vector<Constellation> ProposeReidentified(
    const std::vector<SplitTracklet>& tracklets,
    const ObjectMap& map,
    std::vector<Constellation>& proposed);

// What becomes of the observations when nothing more is found among them.
struct RejoinedTracklets {
  std::set<ObjectId> whole;  // objects none of whose observations is in a merge
  // Of observations in no merge, where all others of their object are one, and nothing else with
  // them.
  std::vector<ObjectMerge> merges;
};

[[nodiscard]] RejoinedTracklets RejoinTracklets(const std::vector<SplitTracklet>& tracklets,
                                                const std::vector<ObjectMerge>& merges);

}  // namespace deepslam::loop
