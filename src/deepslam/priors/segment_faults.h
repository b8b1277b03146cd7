// What a camera and the segmentation of the chain do to a view.
#pragma once

#include "deepslam/core/random.h"
#include "deepslam/priors/raster.h"

namespace deepslam::priors {

// What of the object is left at most, before all other faults.
enum class Left {
  kWhole,
  kPart,  // a part on one side of a line across the image, mostly the upper one
  kTop,   // what lies above some height, cut by the image's borders: a table's top, a chair's back
};

// Sets raster.mask and raster.depth_m from the truth, and spoils both and raster.colour:
// truncation by the image's border, occluders (straight edges at any angle, boxes), now and then
// all but a part of the object, mostly its upper part; the pixels near the ground that segmentation
// takes for ground, missing depth (grazing angles, shadows beside edges, spots), parts without
// depth, rims of background and pieces of neighbours taken for the object, noise of depth (Nguyen,
// Izadi, Lovell 2012) shared between neighbours, blur and noise of colour.
void SpoilView(Random& random, Left left, Raster& raster);

// The truth itself: mask where something is hit, its depth.
void KeepView(Raster& raster);

}  // namespace deepslam::priors
