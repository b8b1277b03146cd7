// What a correspondence must fulfil, and the scale that its geometric residual is divided by.
#pragma once

namespace deepslam::alignment {

struct PlaceGates {
  float max_distance_m = 0.1F;  // along the optical axis of i
  float min_normal_cosine = 0.64F;
  float geometric_scale = 1.0F;  // standard deviation of residual / noise(z)
};

}  // namespace deepslam::alignment
