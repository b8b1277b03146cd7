// What carries tables: legs, columns and boards under a support plane.
#pragma once

#include <span>

#include "deepslam/geometry/plane.h"
#include "deepslam/segment/image_pieces.h"
#include "deepslam/segment/region.h"
#include "deepslam/segment/support_plane.h"

namespace deepslam::segment {

struct OwnedTop {
  int owner = 0;
  SupportPlane top;
};

// Gives unowned pixels of what carries each top to its owner, also outside its box: pieces under
// the top, inside its outline on the ground, that are seen to reach up to it and not above it, and
// are not level themselves (a seat pushed under the table is), and the slim parts of legs that hang
// together with these. Chairs before a table do not get its legs that way.
void ClaimCarriers(const ImagePieces& pieces,
                   const Plane& ground_camera,
                   std::span<const OwnedTop> tops,
                   Owners& owners);

}  // namespace deepslam::segment
