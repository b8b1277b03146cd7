// Objects that association knew again. Behind drift it may have known the right one at a place that
// is no longer its own, or taken the neighbour for it; either way the views of both visits agree on
// no place, and what is registered with all of them stands nowhere. The depth tells: where that of
// one visit fits that of another better elsewhere, the visits are parted and looked for like
// objects of their own, so that constellations decide which are one and how far the path is off.
#pragma once

#include <map>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/ids.h"
#include "deepslam/loop/constellation.h"
#include "deepslam/scene/loop.h"
#include "deepslam/scene/object_track.h"

namespace deepslam::loop {

// What moves further than this was judged where it does not stand.
inline constexpr double kApart_m = 0.10;

// The track cut wherever the object was not seen for min_gap_frames. At least one, all under the
// track's own id.
[[nodiscard]] std::vector<ObjectTrack> Visits(const ObjectTrack& track, const LoopOptions& options);

// Whether points of two visits, in a world with this up direction, lie on each other
// (min_object_agreement of either) after one of them has moved by more than kApart_m. Not where too
// few are near each other to tell: visits may have seen different sides.
[[nodiscard]] bool StandApart(std::span<const Eigen::Vector3f> old_world,
                              std::span<const Eigen::Vector3f> new_world,
                              const Eigen::Vector3d& up_world,
                              const LoopOptions& options);

// Measured points of every visit of an object, in the order of Visits.
using VisitDepth = std::map<ObjectId, std::vector<std::vector<Eigen::Vector3f>>>;

struct PartedObjects {
  std::vector<ObjectTrack> tracks;  // of the visits, each under an id of its own, ascending
  std::vector<PartedVisit> visits;  // in the same order
};

// Objects parted where a visit stands apart from the one before; the first part keeps the id,
// others get the next free ones of `association`. Objects without depth stay whole and are not
// among the tracks.
[[nodiscard]] PartedObjects PartVisits(const Association& association,
                                       const VisitDepth& depth,
                                       const Eigen::Vector3d& up_world,
                                       const LoopOptions& options);

}  // namespace deepslam::loop
