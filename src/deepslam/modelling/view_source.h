// Where views of tracked objects come from: cut out of a capture's frames, or held in memory.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "deepslam/core/parallel.h"
#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/observe/object_views.h"
#include "deepslam/scene/ground.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/object_view.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::modelling {

// Tracks whose views are asked for, with the cameras and the ground that the views are given.
struct TrackedObjects {
  std::span<const ObjectTrack> tracks;
  const Trajectory& trajectory;
  const Ground& ground;
};

struct TrackViews {
  const ObjectTrack* track = nullptr;
  std::vector<ObjectView> views;  // ascending frames; empty where none could be read
};

using UseViews = std::function<Status(std::span<TrackViews>)>;

class ViewSource {
 public:
  virtual ~ViewSource() = default;
  // A few tracks at a time, in their order, so that memory does not grow with the number of
  // objects; every track comes once. Stops at the first error of `use`; Interrupted when the user
  // asks to stop.
  [[nodiscard]] virtual Status ForBatches(const TrackedObjects& objects,
                                          observe::ViewContent content,
                                          const UseViews& use) const = 0;
};

// What is made of each track: `make` of several tracks side by side, `take` of one after another in
// their order, with progress. Stops at the first error in that order.
template <typename Value>
struct PerTrack {
  std::function<Result<Value>(const TrackViews&)> make;
  std::function<Status(const TrackViews&, Value)> take;
};

template <typename Value>
[[nodiscard]] Status ForEachTrack(const ViewSource& source,
                                  const TrackedObjects& objects,
                                  observe::ViewContent content,
                                  Progress& progress,
                                  const PerTrack<Value>& work) {
  std::size_t done = 0;
  const auto use_batch = [&](std::span<TrackViews> batch) -> Status {
    std::vector<std::optional<Result<Value>>> made(batch.size());
    ParallelFor(batch.size(), [&](std::size_t n) {
      if (!progress.StopRequested()) made[n] = work.make(batch[n]);
    });
    for (std::size_t n = 0; n < batch.size(); ++n) {
      if (progress.StopRequested() || !made[n]) return Interrupted();
      if (!made[n]->ok()) return made[n]->error();
      if (Status status = work.take(batch[n], *std::move(*made[n])); !status.ok()) return status;
      progress.Report(++done, objects.tracks.size());
    }
    return Ok();
  };
  return source.ForBatches(objects, content, use_batch);
}

}  // namespace deepslam::modelling
