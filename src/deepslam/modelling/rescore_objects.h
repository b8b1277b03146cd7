// Objects registered and selected anew, because their views have changed: they are one from now on,
// loops moved their views apart, or what each observation saw of them is looked at by itself.
#pragma once

#include <set>
#include <span>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/modelling/loop_world.h"
#include "deepslam/scene/object_view.h"

namespace deepslam::modelling {

// The views, and what is completed by them goes by: with a number behind it from the second time
// on.
struct NewViews {
  std::span<const ObjectView> views;
  std::string_view change;
};

// The object as its candidates make it: registered and scored by all these views, completed anew.
// Where nothing fits all views, what fitted the old ones stays.
[[nodiscard]] Status Rescore(const NewViews& now,
                             const LoopClosing& closing,
                             LoopWorld& world,
                             MapObject& object);

// By all views of its track.
[[nodiscard]] Status RescoreTrack(std::string_view change,
                                  const LoopClosing& closing,
                                  LoopWorld& world,
                                  MapObject& object);

// Objects whose views the closed path has moved apart since `before`, but for those that were just
// scored.
[[nodiscard]] Status RescoreMovedApart(const Trajectory& before,
                                       const std::set<ObjectId>& just_scored,
                                       const LoopClosing& closing,
                                       LoopWorld& world);

}  // namespace deepslam::modelling
