// Decides which detection each piece of the image belongs to, where boxes overlap.
#pragma once

#include <span>
#include <vector>

#include "deepslam/segment/image_pieces.h"
#include "deepslam/segment/region.h"

namespace deepslam::segment {

// Gives unowned pixels of pieces to the detections marked in `takes_pieces`. A piece goes as a
// whole to a region that holds enough of it; among several to the one that holds clearly more, then
// to the one whose pieces so far are nearest in space, then to the smallest. A piece that only
// several regions together hold is cut along their boxes.
void AssignPieces(const ImagePieces& pieces,
                  std::span<const Region> regions,
                  const std::vector<bool>& takes_pieces,
                  const SegmentOptions& options,
                  Owners& owners);

}  // namespace deepslam::segment
