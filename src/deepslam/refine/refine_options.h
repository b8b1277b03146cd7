// Options of the refinement of latents against depth.
#pragma once

#include "deepslam/core/options.h"

namespace deepslam::refine {

struct RefineOptions {
  bool enabled = false;  // its gain is within noise where models are completed
  bool complete = true;  // the best model by what was measured of the object
  // Voxels of the completed model follow the object's level face, the top of a table; else the
  // floor.
  bool follow_level_face = true;
  bool pose = false;      // the winner's similarity, jointly over all views
  double reach_m = 0.15;  // of the model, for what completes it
  // Views of an object that take part, evenly over its frames: as many as an object has by default
  // (object_views.h).
  static constexpr int kMaxViews = 24;
  int max_evaluations = 20;  // of loss and derivative
  // Voxels behind a measured point of the object that are solid. With 2 of them edges reach a layer
  // too far, with 1.5 thin boards of rendered homes lose one.
  static constexpr double kSurfaceVoxels = 1.75;
  int min_voxels = 200;     // with fewer solid ones the depth says too little
  double prior_weight = 3;  // of the way from the start, in units of the start's size
};
void Describe(OptionsVisitor& visitor, RefineOptions& options);

}  // namespace deepslam::refine
