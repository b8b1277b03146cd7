// Materials and light of a training view.
#pragma once

#include "deepslam/core/random.h"
#include "deepslam/priors/raster.h"
#include "deepslam/priors/training_view.h"

namespace deepslam::priors {

// Fills raster.colour where something is hit: patterned materials (plain, noise, grain, stripes,
// checks), or the model's own colours, under one lamp with shadow and light from the sky.
void PaintSurfaces(const FurnitureMesh& furniture,
                   const render::RayScene& scene,
                   Random& random,
                   Raster& raster);

}  // namespace deepslam::priors
