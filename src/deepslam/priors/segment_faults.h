// What a camera and the segmentation of the chain do to a view.
#pragma once

#include "deepslam/core/random.h"
#include "deepslam/priors/raster.h"

namespace deepslam::priors {

// Sets raster.mask and raster.depth_m from the truth, and spoils both and raster.colour:
// truncation by the image's border, occluders (straight edges at any angle, boxes), now and then
// all but a part of the object, mostly its upper part; the pixels near the ground that segmentation
// takes for ground, missing depth (grazing sight, shadows beside edges, spots), parts without
// depth, rims of background and pieces of neighbours taken for the object, noise of depth (Nguyen,
// Izadi, Lovell 2012) shared between neighbours, blur and noise of colour.
// `part`: most of it is hidden.
void SpoilView(Random& random, bool part, Raster& raster);

// The truth itself: mask where something is hit, its depth.
void KeepView(Raster& raster);

}  // namespace deepslam::priors
